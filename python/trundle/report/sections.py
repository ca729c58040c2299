"""Data of the header, and of the sections on motion, wrenches, errors and parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from trundle.report import tables, wording
from trundle.report.figures import floor_map, object_map
from trundle.report.figures import motion as motions
from trundle.report.figures import wrench as wrenches
from trundle.report.figures.canvas import Figure
from trundle.report.location import locate_effects
from trundle.report.series import Episode, Series, held_out_first
from trundle.report.verdict import headline_metric, is_single, lead_sentences, verdict_scores

__all__ = ["answer_header", "error_metrics", "motion", "parameters", "wrench"]

Section = dict[str, Any]

_MAX_PANELS = 9
"""Maximum number of episodes that are drawn."""
_MIN_SAMPLES_IN_TIME = 6
"""An episode with more wrench samples than this is drawn over time."""


def answer_header(diagnosis: Mapping[str, Any], series: Series, warnings: Sequence[object]) -> Section:
    """Return the verdict in sentences, the warnings, and the maps of the object and the floor."""
    maps = _maps(diagnosis, series)
    return {
        "style": f"{diagnosis.get('verdict')}{' two' if len(maps) > 1 else ''}",
        "sentences": lead_sentences(diagnosis, series),
        "warnings": [wording.capitalise(wording.typeset(each)) for each in warnings],
        "maps": maps,
    }


def _maps(diagnosis: Mapping[str, Any], series: Series) -> list[Figure]:
    """Return the map of the object, unless only the floor has marks, and the map of the floor."""
    ground = floor_map.draw(diagnosis, series)
    named = locate_effects(diagnosis.get("missing") or ())
    marked = object_map.hint_point(diagnosis) is not None or any(each.body is not None for each in named)
    found = (object_map.draw(diagnosis, series) if marked or ground is None else None), ground
    return [one for one in found if one is not None]


def motion(diagnosis: Mapping[str, Any], series: Series) -> Section | None:
    """Return recorded and simulated motion: episodes with an event, then held-out ones, then the others."""
    named = locate_effects(diagnosis.get("missing") or ())
    drawable = sorted(
        (episode for episode in held_out_first(series.episodes) if _has_simulation(episode)),
        key=lambda episode: not motions.events_in(episode, named),
    )
    if not drawable:
        return None
    figures = [
        motions.draw(index, episode, series, named) for index, episode in enumerate(drawable[:_MAX_PANELS])
    ]
    return {
        "figures": figures,
        "note": wording.drawn_note(len(figures), len(drawable)),
        "legend": _legend("simulated", drawable),
    }


def _has_simulation(episode: Episode) -> bool:
    return len(episode.t) > 1 and (episode.before is not None or episode.after is not None)


def wrench(series: Series) -> Section | None:
    """Return required and recorded wrenches of quasi-static pushes; None for other recordings."""
    agreement = wrenches.agreement(series)
    if not agreement:
        return None
    long = [
        (episode, episode.wrench)
        for episode in held_out_first(series.episodes)
        if episode.wrench is not None and len(episode.wrench.t) > _MIN_SAMPLES_IN_TIME
    ]
    figures = [
        wrenches.time_course(index, episode, found, series)
        for index, (episode, found) in enumerate(long[:_MAX_PANELS])
    ]
    return {
        "agreement": agreement,
        "figures": figures,
        "legend": _legend("required", [found for _, found in long]),
    }


def _legend(verb: str, curves: Sequence[object]) -> list[tuple[str, str]]:
    """Return the legend entries of recorded curves and of the existing curves before and after."""
    found = [side for side in ("before", "after") if any(getattr(each, side) is not None for each in curves)]
    entries = [(side, f"{verb} {side}" if len(found) > 1 else verb) for side in found]
    return [("recorded", "recorded"), *entries]


def error_metrics(diagnosis: Mapping[str, Any], series: Series) -> Section:
    """Return the error metrics of held-out and of training data."""
    fit, single = diagnosis.get("fit") or {}, is_single(diagnosis, series.discrepancy_inputs)
    sides = ("refitted", "with the missing effects")
    if diagnosis.get("verdict") == "reparameterised":
        sides = ("as given", "refitted")
    if diagnosis.get("verdict") == "unexplained":
        sides = ("refitted", _unexplained_after(series))
    above = headline_metric(diagnosis, series) if verdict_scores(diagnosis)[0] == "held-out" else None
    return {
        "sides": None if single else sides,
        "omits_headline": above is not None,
        "held_out": tables.metrics(fit.get("held_out") or {}, series, single, above),
        "training": tables.metrics(fit.get("training") or {}, series, single),
    }


def _unexplained_after(series: Series) -> str:
    """Return what the simulation "after" contains if the missing effect is not known."""
    return "with the learned force" if series.discrepancy_inputs else "with the closest effects"


def parameters(diagnosis: Mapping[str, Any], series: Series) -> Section | None:
    """Return the parameters of the simulation under test; None if there are none."""
    given = diagnosis.get("nominal") or {}
    found = tables.nominal_parameters(given)
    if found is None:
        return None
    same = not given.get("after") or given.get("after") == given.get("before")
    is_unexplained = diagnosis.get("verdict") == "unexplained"
    added = _unexplained_after(series) if is_unexplained else "with the missing effects"
    how = "Refitted" if same else f"Refitted alone (before) and {added} (after)"
    how = "As given and refitted (after)" if diagnosis.get("verdict") == "reparameterised" else how
    return {"fit": how, **found}
