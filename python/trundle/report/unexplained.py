"""Known symptoms of an unexplained recording, and which recording to make next."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from trundle.report.location import describe_region, finite_pair, polygon
from trundle.report.quantity import format_interval, format_point, join_words
from trundle.report.residual import axis_shares_sentence, dependence_sentences, size_sentences
from trundle.report.series import Series, finite

__all__ = ["symptoms"]

_NEXT_RECORDINGS = (
    (
        "part of the floor",
        "Push across that region with two headings. Repeat the same pushes elsewhere. "
        "An effect of the floor stays in its place; an effect of the object moves with it.",
    ),
    (
        "constant in the world",
        "Turn the object by 90° and repeat the same pushes. A force of the environment keeps "
        "its direction; a force of the object or an error of the sensor turns with it.",
    ),
    (
        "sensor's axes",
        "Hold the object with the gripper turned by 90°. Record a few seconds without "
        "contact before and after each push. An error of the sensor turns with the gripper.",
    ),
    (
        "along world",
        "Push along and across that direction at one speed. Repeat with the object turned by 90°.",
    ),
    (
        "moves with the object",
        "Turn the object by 90° and repeat the same pushes at two speeds. Friction on the object "
        "turns with it, and dry friction does not grow with the speed.",
    ),
    (
        "to the end",
        "Repeat the push of that episode. Inspect the object and its wheels before and after it.",
    ),
    ("of each contact", "Repeat a push with a slow first contact and with a fast one."),
    (
        "reversals",
        "Push back and forth slowly, with stops of one second. Friction and backlash act at reversals.",
    ),
    ("above", "Repeat a push twice, each time at double the speed."),
)
"""A substring of the description of a regime, and the recording that separates its possible causes."""

_DEFAULT_RECORDING = (
    "Repeat one push at half the speed, at double the speed, with a known mass on the object, and at "
    "another place on the floor. The change that alters the residual indicates its cause."
)


def symptoms(diagnosis: Mapping[str, Any], series: Series) -> list[tuple[str, str]]:
    """Return the symptoms and the next recording, as terms and descriptions; none for other verdicts."""
    if diagnosis.get("verdict") != "unexplained":
        return []
    mismatch, residual = diagnosis.get("mismatch") or {}, diagnosis.get("residual") or {}
    rows = [
        (
            "where",
            " ".join(_location_sentences(mismatch))
            or "It is tied neither to a point of the object nor to a region of the floor.",
        ),
        ("when", _strongest_window(mismatch) or "No window exceeds the noise."),
        (
            "size",
            " ".join(
                part
                for part in (*size_sentences(residual, series), axis_shares_sentence(mismatch, series))
                if part
            ),
        ),
        (
            "depends on",
            " ".join(_dependence_sentences(mismatch, residual, series)) or "No dependence was found.",
        ),
        ("record next", _next_recording(str(mismatch.get("regime") or ""))),
    ]
    return [(name, text) for name, text in rows if text]


def _location_sentences(mismatch: Mapping[str, Any]) -> list[str]:
    point, corners = finite_pair(mismatch.get("body_point")), polygon(mismatch.get("world_region"))
    found = []
    if point is not None:
        found.append(f"It acts near {format_point(point)} on the object.")
    if corners is not None:
        found.append(f"It acts in {describe_region(corners)} on the floor.")
    return found


def _strongest_window(mismatch: Mapping[str, Any]) -> str:
    windows = [
        window
        for window in mismatch.get("windows") or ()
        if None not in map(finite, (window.get("start"), window.get("end")))
    ]
    if not windows:
        return ""
    worst = max(windows, key=lambda window: finite(window.get("strength")) or 0.0)
    return f"It is strongest in {worst.get('episode')} at {format_interval(worst['start'], worst['end'])}."


def _dependence_sentences(
    mismatch: Mapping[str, Any], residual: Mapping[str, Any], series: Series
) -> list[str]:
    found = dependence_sentences(
        {"regime": residual.get("regime") or mismatch.get("regime"), "periods": residual.get("periods")}
    )
    if series.discrepancy_inputs:
        inputs = join_words(list(series.discrepancy_inputs))
        found.append(f"A force learned from the training data depends on {inputs}.")
    return found


def _next_recording(regime: str) -> str:
    return next((text for part, text in _NEXT_RECORDINGS if part in regime), _DEFAULT_RECORDING)
