"""The verdict in sentences: headline, statements of effects, error on held-out data, ties."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from trundle.report import wording
from trundle.report.quantity import format_estimate, format_quantity, join_words
from trundle.report.series import Series, finite

__all__ = [
    "PLAIN_VERDICTS",
    "before_after",
    "headline",
    "headline_metric",
    "improvement_sentence",
    "is_single",
    "lead_sentences",
    "tied_with",
    "verdict_scores",
]

PLAIN_VERDICTS = {
    "consistent": "Nothing is missing: the simulation agrees with the recording.",
    "reparameterised": "No effect is missing, but the parameter values of the simulation are wrong.",
    "unexplained": "Something is missing that no effect in the catalogue explains.",
}
"""Verdicts that name no effect, as sentences."""

_HEADLINE_METRICS = (
    ("position_rmse", "m", "the open-loop position error"),
    ("window_position_rmse", "m", "the position error one second ahead"),
    ("force_rmse", "N", "the error of the required force"),
    ("heading_rmse", "rad", "the open-loop heading error"),
)
"""Metrics that the improvement sentence may quote, in order of preference: key, unit, text."""
_HEADLINE_METRICS_AHEAD = (_HEADLINE_METRICS[1], _HEADLINE_METRICS[0], *_HEADLINE_METRICS[2:])
"""The same for a model with a discrepancy, which is chosen by its predictions one second ahead."""


def headline(diagnosis: Mapping[str, Any]) -> str:
    """Return the verdict as one sentence."""
    verdict = diagnosis.get("verdict")
    names = [str(effect.get("effect")) for effect in diagnosis.get("missing") or ()]
    if verdict == "explained" and names:
        return wording.capitalise(_missing_sentence(names, diagnosis))
    if verdict == "consistent" and diagnosis.get("immaterial"):
        return "Nothing that matters for predictions is missing from the simulation."
    return PLAIN_VERDICTS.get(str(verdict), "No verdict was reached.")


def _missing_sentence(names: Sequence[str], diagnosis: Mapping[str, Any]) -> str:
    """Return the sentence that names the missing effects.

    Instrument effects belong to the measurement, so the sentence does not call them missing physics.
    """
    alternatives = [group for entry in diagnosis.get("tied_sets") or () if len(entry) > 1 for group in entry]
    if any(sorted(map(str, group)) == sorted(names) for group in alternatives):
        return f"missing from the simulation: {wording.effect_sets(alternatives)}."
    sets = [[name, *tied_with(name, diagnosis)] for name in names]
    missing = join_words([wording.effect_names(group, "or") for group in sets])
    if all(name in wording.INSTRUMENT_EFFECTS for group in sets for name in group):
        return f"the error is in the measurement, not in the physics: {missing}."
    return f"{missing} {'is' if len(names) == 1 else 'are'} missing from the simulation."


def lead_sentences(diagnosis: Mapping[str, Any], series: Series) -> list[str]:
    """Return the sentences below the headline, most important first."""
    sentences = _statements(diagnosis)
    ties = [_tie_sentence(group) for group in diagnosis.get("tied") or () if len(group) > 1]
    ties += [_tied_sets_sentence(sets) for sets in diagnosis.get("tied_sets") or () if len(sets) > 1]
    changed = _changed_value_sentence(diagnosis) if diagnosis.get("verdict") == "reparameterised" else []
    return [*sentences, improvement_sentence(diagnosis, series), *changed, *ties]


def _statements(diagnosis: Mapping[str, Any]) -> list[str]:
    """Return the statement of each effect, after its number on the maps if there are several.

    The statement of a tied effect holds only if it is that effect, and says so.
    """
    effects = diagnosis.get("missing") or ()
    found = []
    for number, effect in enumerate(effects, 1):
        if effect.get("statement"):
            name = str(effect.get("effect"))
            start = f"{number}. " if len(effects) > 1 else ""
            condition = f"If it is {wording.effect_name(name)}: " if tied_with(name, diagnosis) else ""
            found.append(start + condition + wording.typeset(effect["statement"]))
    return found


def is_single(diagnosis: Mapping[str, Any], discrepancy_inputs: object) -> bool:
    """Return whether the report shows one simulation: no effect was added and nothing was refitted."""
    if diagnosis.get("verdict") == "unexplained" and not discrepancy_inputs:
        fit = diagnosis.get("fit") or {}
        pairs = [side for side in (fit.get("held_out"), fit.get("training")) if side]
        return all(not side.get("after") or side.get("after") == side.get("before") for side in pairs)
    return diagnosis.get("verdict") == "consistent"


def headline_metric(diagnosis: Mapping[str, Any], series: Series) -> str | None:
    """Return the key of the metric that `improvement_sentence` quotes; None if there is none."""
    scores = verdict_scores(diagnosis)[1]
    keys = (key for key, *_ in (_HEADLINE_METRICS_AHEAD if series.discrepancy_inputs else _HEADLINE_METRICS))
    return next((key for key in keys if before_after(scores, key) != (None, None)), None)


def improvement_sentence(diagnosis: Mapping[str, Any], series: Series) -> str:
    """Return a sentence on the error of the simulation on held-out data, before and after."""
    name, scores = verdict_scores(diagnosis)
    on = f"On {name} {series.pushes}"
    for key, unit, name in _HEADLINE_METRICS_AHEAD if series.discrepancy_inputs else _HEADLINE_METRICS:
        before, after = before_after(scores, key)
        if before is None and after is None:
            continue
        if before is None or after is None or before == after:
            size = format_quantity(unit, after if before is None else before)
            return f"{on} {name} is {size}{_noise_phrase(diagnosis)}."
        way = "falls" if after < before else "rises"
        old, new = format_quantity(unit, before), format_quantity(unit, after)
        return f"{on} {name} {way} from {old} to {new}{_cause_phrase(diagnosis, series)}."
    return "No prediction error could be computed."


def before_after(scores: Mapping[str, Any], key: str) -> tuple[float | None, float | None]:
    """Return one metric before and after; None where it is absent."""
    before, after = (finite((scores.get(side) or {}).get(key)) for side in ("before", "after"))
    return before, after


def verdict_scores(diagnosis: Mapping[str, Any]) -> tuple[str, Mapping[str, Any]]:
    """Return the name and the metrics of held-out data if there are any, else of training data."""
    fit = diagnosis.get("fit") or {}
    held_out = fit.get("held_out") or {}
    known = any(finite(value) is not None for side in held_out.values() for value in (side or {}).values())
    return ("held-out", held_out) if known else ("training", fit.get("training") or {})


def _cause_phrase(diagnosis: Mapping[str, Any], series: Series) -> str:
    if is_single(diagnosis, series.discrepancy_inputs):
        return ""
    added = "this effect" if len(diagnosis.get("missing") or ()) == 1 else "these effects"
    known = " with the best effects of the catalogue, which is not enough"
    inputs = join_words(list(series.discrepancy_inputs))
    learned = f" with a force that is learned from the training data and depends on {inputs}"
    learned += "; this force improves predictions but is not an explanation"
    return {
        "explained": f" with {added}",
        "reparameterised": " with refitted values",
        "unexplained": learned if series.discrepancy_inputs else known,
    }.get(str(diagnosis.get("verdict")), "")


def _noise_phrase(diagnosis: Mapping[str, Any]) -> str:
    is_clean = diagnosis.get("verdict") == "consistent" and not diagnosis.get("immaterial")
    return ", which noise explains" if is_clean else ""


def tied_with(effect: str, diagnosis: Mapping[str, Any]) -> list[str]:
    """Return the effects that the data cannot distinguish from `effect`."""
    groups = [[str(name) for name in group] for group in diagnosis.get("tied") or ()]
    found = [name for group in groups if effect in group for name in group if name != effect]
    return list(dict.fromkeys(found))


def _tie_sentence(group: Sequence[Any]) -> str:
    names = wording.effect_names(group)
    return f"This recording cannot distinguish {names}: each explains it equally well."


def _tied_sets_sentence(sets: Sequence[Sequence[Any]]) -> str:
    return f"This recording cannot distinguish these alternatives: {wording.effect_sets(sets)}."


def _changed_value_sentence(diagnosis: Mapping[str, Any]) -> list[str]:
    """Return a sentence on the given value that is farthest from its refit, in standard deviations."""
    nominal = diagnosis.get("nominal") or {}
    refitted = nominal.get("after") or nominal.get("before") or {}
    found = []
    for name, value in (nominal.get("given") or {}).items():
        was, now = finite(value), refitted.get(name) or {}
        mean, sd = finite(now.get("mean")), finite(now.get("sd"))
        if None not in (was, mean, sd) and now.get("identifiable", True) and sd:
            found.append((abs((was or 0.0) - (mean or 0.0)) / sd, name, was, now))
    if not found:
        return []
    _, name, was, now = max(found, key=lambda entry: entry[:2])
    unit = str(now.get("unit") or "")
    fitted = format_estimate(now.get("mean"), now.get("sd"), unit)
    given = format_estimate(was, None, unit)
    return [f"The largest difference is in {name}: the given value is {given}, the fitted value {fitted}."]
