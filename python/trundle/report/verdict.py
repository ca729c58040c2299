"""The answer in words: the verdict, what it explains on data that were never fitted, what is certain."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from trundle.report.given import Series, finite
from trundle.report.quantity import interval, listed, readable, shown

__all__ = ["before_after", "headline", "improvement", "lead"]

_JUDGES = (
    ("position_rmse", "m", "the position error of the simulation"),
    ("window_position_rmse", "m", "the position error one second ahead"),
    ("force_rmse", "N", "the error of the force that the model needs"),
    ("heading_rmse", "rad", "the heading error of the simulation"),
)
"""Figures that can carry the sentence, in order of preference: key, unit, words."""


def headline(diagnosis: Mapping[str, Any]) -> str:
    """Return the verdict in one line."""
    verdict = diagnosis.get("verdict")
    missing = [_with_ties(str(effect.get("effect")), diagnosis) for effect in diagnosis.get("missing") or ()]
    if verdict == "explained" and missing:
        return _sentence(
            f"{listed(missing)} {'is' if len(missing) == 1 else 'are'} missing from the simulation"
        )
    return {
        "consistent": "Nothing is missing: the simulation agrees with the recording.",
        "reparameterised": "The laws of the simulation suffice, but its values do not.",
        "unexplained": "Something is missing that nothing known explains.",
    }.get(str(verdict), "No verdict was reached.")


def lead(diagnosis: Mapping[str, Any], series: Series) -> list[str]:
    """Return the sentences below the headline, most important first."""
    sentences = [
        str(effect["statement"]) for effect in diagnosis.get("missing") or () if effect.get("statement")
    ]
    ties = [_tie(group) for group in diagnosis.get("tied") or () if len(group) > 1]
    return [*sentences, improvement(diagnosis, series), *ties, *_symptoms(diagnosis)]


def improvement(diagnosis: Mapping[str, Any], series: Series) -> str:
    """How far the simulation is off on held-out data, before and after."""
    name, scores = _scores(diagnosis)
    on = f"On {name} {series.pushes}"
    for key, unit, words in _JUDGES:
        before, after = before_after(scores, key)
        if before is None and after is None:
            continue
        if before is None or after is None or before == after:
            return f"{on} {words} is {shown(unit, after if before is None else before)}{_nothing(diagnosis)}."
        way = "falls" if after < before else "rises"
        old, new = shown(unit, before), shown(unit, after)
        return f"{on} {words} {way} from {old} to {new}{_cause(diagnosis)}."
    return "No figure could be computed on data that were not fitted."


def before_after(scores: Mapping[str, Any], key: str) -> tuple[float | None, float | None]:
    """One figure of a table of fits, before and after."""
    before, after = (finite((scores.get(side) or {}).get(key)) for side in ("before", "after"))
    return before, after


def _scores(diagnosis: Mapping[str, Any]) -> tuple[str, Mapping[str, Any]]:
    """Return the table that counts: held out where there is one, else training."""
    fit = diagnosis.get("fit") or {}
    held_out = fit.get("held_out") or {}
    known = any(finite(value) is not None for side in held_out.values() for value in (side or {}).values())
    return ("held-out", held_out) if known else ("fitted", fit.get("training") or {})


def _cause(diagnosis: Mapping[str, Any]) -> str:
    return {
        "explained": " once this is added",
        "reparameterised": " once the values are refitted",
        "unexplained": " with the best that is known, and that is not enough",
    }.get(str(diagnosis.get("verdict")), "")


def _nothing(diagnosis: Mapping[str, Any]) -> str:
    return ", no more than noise explains" if diagnosis.get("verdict") == "consistent" else ""


def _with_ties(effect: str, diagnosis: Mapping[str, Any]) -> str:
    """Return the name of an effect, with those that the data cannot tell from it."""
    groups = [[str(name) for name in group] for group in diagnosis.get("tied") or ()]
    others = [name for group in groups if effect in group for name in group if name != effect]
    return listed([readable(name) for name in dict.fromkeys([effect, *others])], "or")


def _tie(group: Sequence[Any]) -> str:
    names = [readable(str(name)) for name in group]
    return f"This recording cannot tell {listed(names)} apart: any of them would do."


def _symptoms(diagnosis: Mapping[str, Any]) -> list[str]:
    """Where and when it goes wrong, where no name says so."""
    mismatch = diagnosis.get("mismatch") or {}
    if diagnosis.get("verdict") != "unexplained":
        return []
    sentences = [f"It acts {mismatch['regime']}."] if mismatch.get("regime") else []
    return sentences + _strongest(mismatch.get("windows") or ())


def _strongest(windows: Sequence[Mapping[str, Any]]) -> list[str]:
    known = [
        window for window in windows if None not in map(finite, (window.get("start"), window.get("end")))
    ]
    if not known:
        return []
    worst = max(known, key=lambda window: finite(window.get("strength")) or 0.0)
    span = interval(worst["start"], worst["end"])
    return [f"It is strongest in {worst.get('episode')} at {span}."]


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}."
