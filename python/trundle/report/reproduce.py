"""How to get the page again: command, version, seed, and the SHA-256 of what went in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from trundle.report.markup import Child, Html, tag
from trundle.report.quantity import ABSENT, shown
from trundle.report.section import section

__all__ = ["reproduce"]


def reproduce(series: Mapping[str, Any], wrench_pose: str) -> Html:
    """Return how to get this page again, what noise was assumed, and what lies beside it."""
    rows: list[tuple[str, Child]] = [
        ("version", f"trundle {series.get('version') or ABSENT}"),
        ("seed", _seed(series)),
        *_inputs(series),
        ("noise", _noise(series.get("noise") or {})),
        *_POSES.get(wrench_pose, ()),
    ]
    return section(
        "reproduce",
        "How to get this page again",
        tag("pre", tag("code", str(series.get("command") or ""))),
        tag("p", "The same input, seed and version give the same bytes."),
        tag("dl", [[tag("dt", name), tag("dd", value)] for name, value in rows]),
        tag("p", "Beside this page:"),
        tag("ul", [tag("li", tag("code", name), f" {text}") for name, text in _BESIDE]),
    )


_POSES: Mapping[str, Sequence[tuple[str, Child]]] = {
    "own_time": [("wrenches", "brought to the object with the pose at their own time")],
    "latest": [
        ("wrenches", "brought to the object with the latest recorded pose (equation 13 of the paper)")
    ],
}

_BESIDE = (
    ("diagnosis.json", "holds the same for programs,"),
    ("model.toml", "the extended model, which simulator, estimator and planner load,"),
    ("predictions.parquet", "the recorded and simulated motion of the held-out episodes."),
)


def _seed(series: Mapping[str, Any]) -> str:
    seed = series.get("seed")
    return str(seed) if isinstance(seed, int | str) else ABSENT


def _inputs(series: Mapping[str, Any]) -> list[tuple[str, Child]]:
    """Return each input with its fingerprint and the command that checks it."""
    return [
        (
            f"SHA-256 of the {entry.get('what') or 'input'}",
            [tag("code", str(entry.get("sha256"))), *_check(entry)],
        )
        for entry in series.get("input") or ()
        if isinstance(entry, Mapping) and entry.get("sha256")
    ]


def _check(entry: Mapping[str, Any]) -> list[Child]:
    return [tag("br"), "as printed by ", tag("code", str(entry["check"]))] if entry.get("check") else []


def _noise(noise: Mapping[str, Any]) -> str:
    pose = noise.get("pose") or (None, None, None)
    origin = "as the recording states" if noise.get("stated") else "estimated from the recording"
    place = " and ".join(dict.fromkeys((shown("m", pose[0]), shown("m", pose[1]))))
    return (
        f"position {place}, heading {shown('rad', pose[2])}, force {shown('N', noise.get('force'))}, "
        f"torque {shown('N·m', noise.get('torque'))}: one standard deviation, {origin}"
    )
