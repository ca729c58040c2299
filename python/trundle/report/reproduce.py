"""Section "How to reproduce this report": command, version, seed and SHA-256 of the inputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from trundle.report.markup import Child, Html, tag
from trundle.report.quantity import ABSENT, format_quantity
from trundle.report.section import section

__all__ = ["reproduce"]


def reproduce(series: Mapping[str, Any], wrench_pose: str) -> Html:
    """Return the section with the command, the inputs, the assumed noise and the other output files.

    `wrench_pose` is that of diagnosis.json: which pose transforms a wrench to the object.
    """
    rows: list[tuple[str, Child]] = [
        ("version", f"trundle {series.get('version') or ABSENT}"),
        ("seed", _seed(series)),
        *_inputs(series),
        ("noise", _noise(series.get("noise") or {})),
        *_WRENCH_POSES.get(wrench_pose, ()),
    ]
    return section(
        "reproduce",
        "How to reproduce this report",
        tag("pre", tag("code", str(series.get("command") or ""))),
        tag("p", "The same input, seed and version produce identical files."),
        tag("dl", [[tag("dt", name), tag("dd", value)] for name, value in rows]),
        tag("p", "The same folder contains:"),
        tag("ul", [tag("li", tag("code", name), f": {text}") for name, text in _OUTPUT_FILES]),
    )


_WRENCH_POSES: Mapping[str, Sequence[tuple[str, Child]]] = {
    "own_time": [("wrenches", "transformed to the object with the pose at the time of each wrench")],
    "latest": [
        ("wrenches", "transformed to the object with the latest recorded pose (equation 13 of the paper)")
    ],
}

_OUTPUT_FILES = (
    ("diagnosis.json", "the same results in machine-readable form"),
    ("model.toml", "the extended model, for simulation, estimation and planning"),
    ("predictions.parquet", "recorded and simulated motion of the held-out episodes"),
)
"""Other files of a diagnosis: name, content."""


def _seed(series: Mapping[str, Any]) -> str:
    seed = series.get("seed")
    return str(seed) if isinstance(seed, int | str) else ABSENT


def _inputs(series: Mapping[str, Any]) -> list[tuple[str, Child]]:
    """Return the fingerprint of each input and the command that prints it."""
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
    origin = "stated by the recording" if noise.get("stated") else "estimated from the recording"
    position = " and ".join(dict.fromkeys((format_quantity("m", pose[0]), format_quantity("m", pose[1]))))
    heading, force = format_quantity("rad", pose[2]), format_quantity("N", noise.get("force"))
    torque = format_quantity("N·m", noise.get("torque"))
    return (
        f"standard deviations: position {position}, heading {heading}, force {force}, torque {torque} "
        f"({origin})"
    )
