"""The answer in words: the verdict, what it explains on data that were never fitted, what is certain."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from trundle.report import words
from trundle.report.given import Series, finite
from trundle.report.quantity import listed, measured, shown

__all__ = ["before_after", "headline", "improvement", "is_single", "judged", "lead", "quoted"]

_JUDGES = (
    ("position_rmse", "m", "the position error of the simulation"),
    ("window_position_rmse", "m", "the position error one second ahead"),
    ("force_rmse", "N", "the error of the force that the model needs"),
    ("heading_rmse", "rad", "the heading error of the simulation"),
)
"""Figures that can carry the sentence, in order of preference: key, unit, words."""
_AHEAD = (_JUDGES[1], _JUDGES[0], *_JUDGES[2:])
"""The same where a wrench without a name was chosen by what it predicts one second ahead."""


def headline(diagnosis: Mapping[str, Any]) -> str:
    """Return the verdict in one line."""
    verdict = diagnosis.get("verdict")
    names = [str(effect.get("effect")) for effect in diagnosis.get("missing") or ()]
    if verdict == "explained" and names:
        return words.capitalised(_named(names, diagnosis))
    return {
        "consistent": "Nothing is missing: the simulation agrees with the recording.",
        "reparameterised": "The laws of the simulation suffice, but its values do not.",
        "unexplained": "Something is missing that nothing known explains.",
    }.get(str(verdict), "No verdict was reached.")


def _named(names: Sequence[str], diagnosis: Mapping[str, Any]) -> str:
    """Return what is missing as a sentence; instruments are not physics that a simulation lacks."""
    sets = [[name, *_others(name, diagnosis)] for name in names]
    missing = listed([words.effects(group, "or") for group in sets])
    if all(name in words.MEASUREMENT for group in sets for name in group):
        return f"not the physics but the measurement: {missing}."
    return f"{missing} {'is' if len(names) == 1 else 'are'} missing from the simulation."


def lead(diagnosis: Mapping[str, Any], series: Series) -> list[str]:
    """Return the sentences below the headline, most important first."""
    sentences = _statements(diagnosis.get("missing") or ())
    ties = [_tie(group) for group in diagnosis.get("tied") or () if len(group) > 1]
    ties += [_tied_sets(sets) for sets in diagnosis.get("tied_sets") or () if len(sets) > 1]
    changed = _changed(diagnosis) if diagnosis.get("verdict") == "reparameterised" else []
    return [*sentences, improvement(diagnosis, series), *changed, *ties]


def _statements(effects: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return what is said of each effect, with the number that it has on the maps if there are several."""
    numbers = [f"{number}. " if len(effects) > 1 else "" for number in range(1, len(effects) + 1)]
    return [
        number + words.spoken(effect["statement"])
        for number, effect in zip(numbers, effects, strict=True)
        if effect.get("statement")
    ]


def is_single(diagnosis: Mapping[str, Any], unnamed: object) -> bool:
    """Whether there is one simulation and not two: nothing was added to it, nor refitted."""
    if diagnosis.get("verdict") == "unexplained" and not unnamed:
        fit = diagnosis.get("fit") or {}
        pairs = [side for side in (fit.get("held_out"), fit.get("training")) if side]
        return all(not side.get("after") or side.get("after") == side.get("before") for side in pairs)
    return diagnosis.get("verdict") == "consistent"


def quoted(diagnosis: Mapping[str, Any], series: Series) -> str | None:
    """Return the figure that the sentence below the headline gives."""
    scores = judged(diagnosis)[1]
    keys = (key for key, *_ in (_AHEAD if series.unnamed else _JUDGES))
    return next((key for key in keys if before_after(scores, key) != (None, None)), None)


def improvement(diagnosis: Mapping[str, Any], series: Series) -> str:
    """How far the simulation is off on held-out data, before and after."""
    name, scores = judged(diagnosis)
    on = f"On {name} {series.pushes}"
    for key, unit, name in _AHEAD if series.unnamed else _JUDGES:
        before, after = before_after(scores, key)
        if before is None and after is None:
            continue
        if before is None or after is None or before == after:
            return f"{on} {name} is {shown(unit, after if before is None else before)}{_nothing(diagnosis)}."
        way = "falls" if after < before else "rises"
        old, new = shown(unit, before), shown(unit, after)
        return f"{on} {name} {way} from {old} to {new}{_cause(diagnosis, series)}."
    return "No figure could be computed on data that were not fitted."


def before_after(scores: Mapping[str, Any], key: str) -> tuple[float | None, float | None]:
    """One figure of a table of fits, before and after."""
    before, after = (finite((scores.get(side) or {}).get(key)) for side in ("before", "after"))
    return before, after


def judged(diagnosis: Mapping[str, Any]) -> tuple[str, Mapping[str, Any]]:
    """Return the table that counts: held out where there is one, else training."""
    fit = diagnosis.get("fit") or {}
    held_out = fit.get("held_out") or {}
    known = any(finite(value) is not None for side in held_out.values() for value in (side or {}).values())
    return ("held-out", held_out) if known else ("fitted", fit.get("training") or {})


def _cause(diagnosis: Mapping[str, Any], series: Series) -> str:
    if is_single(diagnosis, series.unnamed):
        return ""
    added = "this is" if len(diagnosis.get("missing") or ()) == 1 else "these are"
    known = " with the best that is known, and that is not enough"
    inputs = listed(list(series.unnamed))
    unnamed = f" with an unnamed force learnt from the training data, which depends on {inputs}"
    unnamed += "; it predicts, and is not an explanation"
    return {
        "explained": f" once {added} added",
        "reparameterised": " once the values are refitted",
        "unexplained": unnamed if series.unnamed else known,
    }.get(str(diagnosis.get("verdict")), "")


def _nothing(diagnosis: Mapping[str, Any]) -> str:
    return ", no more than noise explains" if diagnosis.get("verdict") == "consistent" else ""


def _others(effect: str, diagnosis: Mapping[str, Any]) -> list[str]:
    """Return the effects that the data cannot tell from one."""
    groups = [[str(name) for name in group] for group in diagnosis.get("tied") or ()]
    found = [name for group in groups if effect in group for name in group if name != effect]
    return list(dict.fromkeys(found))


def _tie(group: Sequence[Any]) -> str:
    return f"This recording cannot tell {words.effects(group)} apart: any of them would do."


def _tied_sets(sets: Sequence[Sequence[Any]]) -> str:
    return f"This recording cannot tell apart {words.sets(sets)}."


def _changed(diagnosis: Mapping[str, Any]) -> list[str]:
    """Return the given value that lies farthest from the refitted one, in standard deviations."""
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
    fitted = measured(now.get("mean"), now.get("sd"), unit)
    return [f"Farthest off is {name}: given as {measured(was, None, unit)}, it is {fitted}."]
