"""What is known about an effect that the catalogue does not explain, and which recording to make next."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from trundle.report import wording
from trundle.report.dependence import MIN_SHARE, predictors
from trundle.report.location import describe_region, finite_pair, polygon
from trundle.report.quantity import format_fixed, format_interval, format_point, join_words
from trundle.report.residual import axis_shares_sentence, dependence_sentences, size_sentences
from trundle.report.results import closest_rejected
from trundle.report.series import Series, finite

__all__ = ["predictor_rows", "symptoms"]

_NEXT_IN_PLANE = {
    "part_of_floor": "Push across that region with two headings. Repeat the same pushes elsewhere. "
    "An effect of the floor stays in its place; an effect of the object moves with it.",
    "constant_in_world": "Turn the object by 90° and repeat the same pushes. A force of the environment "
    "keeps its direction; a force of the object or an error of the sensor turns with it.",
    "constant_in_sensor": "Hold the object with the gripper turned by 90°. Record a few seconds without "
    "contact before and after each push. An error of the sensor turns with the gripper.",
    "world_direction": "Push along and across that direction at one speed. "
    "Repeat with the object turned by 90°.",
    "drag_on_object": "Turn the object by 90° and repeat the same pushes at two speeds. Friction on the "
    "object turns with it, and dry friction does not grow with the speed.",
}
"""The recording that separates the causes, by the kind of regime in the plane."""

_NEXT_IN_TIME = {
    "from_time_on": "Repeat the push of that episode. Inspect the object and its wheels before and after it.",
    "after_contact": "Repeat a push with a slow first contact and with a fast one.",
    "low_speed": "Push back and forth slowly, with stops of one second. "
    "Friction and backlash act at reversals.",
    "high_speed": "Repeat a push twice, each time at double the speed.",
}
"""The same for regimes that also occur on a rail."""

_NEXT_BY_PREDICTOR = {
    "the speed": "Repeat a push three times, each time at double the speed.",
    "the direction of motion on the object": "Repeat the same pushes with the object turned by 90° "
    "under the gripper, so that it moves along another of its axes.",
    "the direction of motion in the world": "Turn the object by 90° and push it along the same lines.",
    "the spin": "Turn the object in place in both directions, at two speeds.",
    "the heading": "Repeat one push at four headings, a quarter turn apart.",
    "the place on the floor": "Repeat the same pushes half a metre aside. An effect of the floor stays.",
    "the time since contact": "Repeat a push that lasts three times as long.",
}
"""The recording that tests the quantity that predicts the missing wrench best."""

_DEFAULT_RECORDING = (
    "Repeat one push at half the speed, at double the speed, with a known mass on the object, and at "
    "another place on the floor. The change that alters the residual indicates its cause."
)
_DEFAULT_ON_RAIL = (
    "Repeat one run at half the speed, at double the speed, in the other direction, on another part of the "
    "rail, and with a known mass on the object. The change that alters the residual indicates its cause."
)


def symptoms(
    diagnosis: Mapping[str, Any], series: Series, ranking: Sequence[Mapping[str, Any]]
) -> list[tuple[str, str]]:
    """Return terms and descriptions: where, when, how large, what it depends on, what was tried, what next.

    The list is empty for other verdicts. All of them describe the residual of the refitted simulation, to
    which no effect was added.
    """
    if diagnosis.get("verdict") != "unexplained":
        return []
    mismatch, residual = diagnosis.get("mismatch") or {}, diagnosis.get("residual") or {}
    regime = residual.get("regime_kind")
    rows = [
        ("where", _where(mismatch)),
        ("when", _when(residual.get("windows") or mismatch.get("windows") or ())),
        (
            "how large",
            " ".join(
                part
                for part in (
                    *size_sentences({**residual, "share": None}, series),
                    _noise_ratio_sentence(series),
                    axis_shares_sentence(mismatch, series),
                )
                if part
            ),
        ),
        ("depends on", _dependence(residual, series)),
        ("tried", _tried(diagnosis, ranking)),
        ("record next", _next_recording(regime, series)),
    ]
    return [(name, text) for name, text in rows if text]


def predictor_rows(series: Series) -> list[tuple[str, str]]:
    """Return quantities and the share of the wrench that each predicts; none if all are small."""
    found = predictors(series)
    is_clear = bool(found) and found[0][1] >= MIN_SHARE
    return [(name, wording.format_percent(share)) for name, share in found] if is_clear else []


def _where(mismatch: Mapping[str, Any]) -> str:
    point, corners = finite_pair(mismatch.get("body_point")), polygon(mismatch.get("world_region"))
    found = []
    if point is not None:
        found.append(f"It acts near {format_point(point)} on the object.")
    if corners is not None:
        found.append(f"It acts in {describe_region(corners)} on the floor.")
    return " ".join(found) or "It is tied neither to a point of the object nor to a region of the floor."


def _when(windows: Sequence[Mapping[str, Any]]) -> str:
    """Return how many windows exceed the noise, in how many episodes, and the strongest one."""
    whole = [
        window for window in windows if None not in map(finite, (window.get("start"), window.get("end")))
    ]
    if not whole:
        return "No window of time stands out from the noise."
    worst = max(whole, key=lambda window: finite(window.get("strength")) or 0.0)
    episodes = len({str(window.get("episode")) for window in whole})
    total = sum(float(window["end"]) - float(window["start"]) for window in whole)
    strongest = f"{worst.get('episode')} at {format_interval(worst['start'], worst['end'])}"
    if len(whole) == 1:
        return f"It exceeds the noise once, in {strongest}."
    spread = f"{episodes} episode{'s' if episodes > 1 else ''}"
    seconds = f"{format_fixed(total, 1)}\N{NO-BREAK SPACE}s"
    return (
        f"It exceeds the noise in {len(whole)} windows of {spread}, {seconds} in total. "
        f"It is strongest in {strongest}."
    )


def _noise_ratio_sentence(series: Series) -> str:
    """Return the size of the missing wrench in standard deviations of its noise; empty if it is unknown."""
    ratios = []
    for episode in series.episodes:
        residual = episode.residual
        missing = None if residual is None else residual.after if residual.before is None else residual.before
        if residual is not None and missing is not None and residual.sd is not None:
            scaled = missing[:, series.channels] / np.maximum(residual.sd[:, series.channels], 1e-12)
            ratios.append(scaled[np.isfinite(scaled)])
    values = np.concatenate([np.empty(0), *ratios])
    if not len(values):
        return ""
    ratio = float(np.sqrt(np.mean(values**2)))
    size = f"{format_fixed(ratio, 1)} times its standard deviation"
    return f"Relative to the noise: {size} (RMS)." if ratio > 1.0 else ""


def _dependence(residual: Mapping[str, Any], series: Series) -> str:
    found = dependence_sentences(residual)
    if series.discrepancy_inputs:
        inputs = join_words(list(series.discrepancy_inputs))
        found.append(f"A force learned from the training data depends on {inputs}.")
    ranked = predictors(series)
    if ranked and ranked[0][1] >= MIN_SHARE:
        found.append(f"Of single quantities, {ranked[0][0]} predicts it best in left-out episodes.")
    elif ranked:
        found.append(
            "No single quantity of the motion predicts it in left-out episodes: it differs between pushes."
        )
    return " ".join(found) or "No dependence was found."


def _tried(diagnosis: Mapping[str, Any], ranking: Sequence[Mapping[str, Any]]) -> str:
    """Return how many models were fitted, and the closest one with the reason for its rejection."""
    count = sum(1 for entry in ranking if entry.get("effects"))
    closest = closest_rejected(diagnosis, ranking)
    if closest is None:
        return ""
    names, reason = closest
    models = f"{count} models with further effects were" if count > 1 else "One model with an effect was"
    name = wording.effect_names(names)
    return f"{models} fitted and rejected. Closest: {name}. It is rejected because {_clause(reason)}."


def _clause(reason: str) -> str:
    """Return a reason as a clause after "because"."""
    is_participle = reason.startswith(("less probable", "not tested"))
    return f"it is {reason}" if is_participle else reason


def _next_recording(regime: str | None, series: Series) -> str:
    """Return the recording that separates the causes of a regime, or else of the best predictor."""
    on_rail = "theta" not in series.dof
    by_regime = _NEXT_IN_TIME if on_rail else _NEXT_IN_PLANE | _NEXT_IN_TIME
    if regime in by_regime:
        return by_regime[regime]
    if on_rail:
        return _DEFAULT_ON_RAIL
    ranked = predictors(series)
    best = ranked[0][0] if ranked and ranked[0][1] >= MIN_SHARE else ""
    return _NEXT_BY_PREDICTOR.get(best, _DEFAULT_RECORDING)
