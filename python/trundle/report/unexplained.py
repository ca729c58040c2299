"""Where nothing known explains it: where, when, how large, and what to record next."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from trundle.report.given import Series, finite
from trundle.report.markup import Html, tag
from trundle.report.quantity import fixed, interval, listed
from trundle.report.remains import depends, shares, size
from trundle.report.section import section
from trundle.report.where import extent, pair, region

__all__ = ["symptoms"]

_NEXT = (
    (
        "part of the floor",
        "Push across that place with two headings, and repeat the same pushes elsewhere: "
        "what belongs to the floor stays at the place, what belongs to the object moves along.",
    ),
    (
        "constant in the world",
        "Turn the object by a quarter and repeat the same pushes: a force of the world keeps "
        "its direction, one of the object or the sensor turns along.",
    ),
    (
        "sensor's axes",
        "Hold the object with the gripper turned by a quarter, and record some seconds without "
        "contact before and after each push: an error of the sensor turns with it.",
    ),
    (
        "along world",
        "Push along and across that direction at one speed, then with the object turned by a quarter.",
    ),
    (
        "moves with the object",
        "Turn the object by a quarter and repeat the same pushes, at two speeds: what rubs on the object "
        "turns along, and dry friction does not grow with the speed.",
    ),
    (
        "to the end",
        "Repeat the push of that episode, and look at the object and its wheels before and after it.",
    ),
    ("of each contact", "Repeat a push with a slow first touch and with a fast one."),
    ("reversals", "Push to and fro slowly, with stops of a second: friction and play show at reversals."),
    ("above", "Repeat a push three times, each twice as fast."),
)
"""A part of the words for a regime, and the recording that separates its causes."""

_ANY = (
    "Repeat one push at half the speed, at twice the speed, with a known mass on the object, and at another "
    "place of the floor: what changes with which says what to look for."
)


def symptoms(diagnosis: Mapping[str, Any], series: Series) -> Html | None:
    """Return what is known of something that has no name; None for other verdicts."""
    if diagnosis.get("verdict") != "unexplained":
        return None
    mismatch, left = diagnosis.get("mismatch") or {}, diagnosis.get("residual") or {}
    rows = [
        (
            "where",
            " ".join(_places(mismatch)) or "It is tied to no point of the object and no place of the floor.",
        ),
        ("when", _strongest(mismatch) or "No window stands out."),
        ("how large", " ".join(part for part in (*size(left, series), shares(mismatch, series)) if part)),
        ("depends on", " ".join(_dependence(mismatch, left, series)) or "No dependence stands out."),
        ("record next", _next(str(mismatch.get("regime") or ""))),
    ]
    return section(
        "missing",
        "What is known of it",
        tag("dl", [[tag("dt", name), tag("dd", text)] for name, text in rows if text]),
    )


def _places(mismatch: Mapping[str, Any]) -> list[str]:
    spot, corners = pair(mismatch.get("body_point")), region(mismatch.get("world_region"))
    found = []
    if spot is not None:
        place = ", ".join(fixed(value, 2) for value in spot)
        found.append(f"It acts near ({place})\N{NO-BREAK SPACE}m on the object.")
    if corners is not None:
        found.append(f"It is tied to {extent(corners)} on the floor.")
    return found


def _strongest(mismatch: Mapping[str, Any]) -> str:
    windows = [
        window
        for window in mismatch.get("windows") or ()
        if None not in map(finite, (window.get("start"), window.get("end")))
    ]
    if not windows:
        return ""
    worst = max(windows, key=lambda window: finite(window.get("strength")) or 0.0)
    return f"It is strongest in {worst.get('episode')} at {interval(worst['start'], worst['end'])}."


def _dependence(mismatch: Mapping[str, Any], left: Mapping[str, Any], series: Series) -> list[str]:
    found = depends({"regime": left.get("regime") or mismatch.get("regime"), "periods": left.get("periods")})
    if series.unnamed:
        found.append(f"A force learnt from the training data depends on {listed(list(series.unnamed))}.")
    return found


def _next(regime: str) -> str:
    return next((text for words, text in _NEXT if words in regime), _ANY)
