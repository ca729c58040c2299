"""The header, and the sections on motion, wrenches, tested effects, errors and parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from trundle.report import tables, wording
from trundle.report.figures import floor_map, object_map
from trundle.report.figures import motion as motions
from trundle.report.figures import wrench as wrenches
from trundle.report.gallery import drawn_note, gallery
from trundle.report.legend import legend, side_entries
from trundle.report.location import locate_effects
from trundle.report.markup import Html, tag
from trundle.report.section import collapsible, section
from trundle.report.series import Episode, Series, held_out_first
from trundle.report.verdict import headline, headline_metric, is_single, lead_sentences, verdict_scores

__all__ = ["answer_header", "error_metrics", "motion", "parameters", "ranking", "wrench"]

_MAX_PANELS = 9
"""Maximum number of episodes that are drawn."""
_OPEN_CANDIDATES = 6
"""Number of candidates that are not collapsed."""
_MIN_SAMPLES_IN_TIME = 6
"""An episode with more wrench samples than this is drawn over time."""


def answer_header(
    diagnosis: Mapping[str, Any], series: Series, warnings: Sequence[str], recording: str, contents: Html
) -> Html:
    """Return the header: verdict, warnings, contents, and maps of the object and the floor."""
    sentences = lead_sentences(diagnosis, series)
    text = tag(
        "div",
        tag("p", "Diagnosis of ", tag("b", recording), class_="kicker"),
        tag("h1", headline(diagnosis)),
        [tag("p", sentence, class_="lead") for sentence in sentences],
        _warnings(warnings),
        contents,
        class_="words",
    )
    maps = [found for found in _maps(diagnosis, series) if found is not None]
    drawn = tag("div", maps, class_="maps") if maps else None
    kind = f"{diagnosis.get('verdict')}{' two' if len(maps) > 1 else ''}"
    return tag("header", text, drawn, class_=f"answer {kind}")


def _warnings(warnings: Sequence[str]) -> Html | None:
    """Return the box of warnings; None if there are none."""
    if not warnings:
        return None
    title = tag("b", "Warning" if len(warnings) == 1 else "Warnings")
    items = [tag("li", wording.capitalise(wording.typeset(each))) for each in warnings]
    return tag("div", title, tag("ul", items), class_="warnings", role="note")


def _maps(diagnosis: Mapping[str, Any], series: Series) -> tuple[Html | None, Html | None]:
    """Return the map of the object, unless only the floor has marks, and the map of the floor."""
    ground = floor_map.draw(diagnosis, series)
    named = locate_effects(diagnosis.get("missing") or ())
    marked = object_map.hint_point(diagnosis) is not None or any(each.body is not None for each in named)
    return (object_map.draw(diagnosis, series) if marked or ground is None else None), ground


def motion(diagnosis: Mapping[str, Any], series: Series) -> Html | None:
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
    text = (
        "The simulation starts at rest and is driven by the recorded wrench only. "
        "Held-out episodes were not used in any fit."
    )
    return section(
        "motion",
        "Simulated and recorded motion",
        tag("p", text, drawn_note(len(figures), len(drawable))),
        legend(*side_entries("simulated", drawable)),
        gallery(figures),
    )


def _has_simulation(episode: Episode) -> bool:
    return len(episode.t) > 1 and (episode.before is not None or episode.after is not None)


def wrench(series: Series) -> Html | None:
    """Return required and recorded wrenches of quasi-static pushes; None for other recordings."""
    agreement = wrenches.agreement(series)
    if not agreement:
        return None
    long = [
        episode
        for episode in held_out_first(series.episodes)
        if episode.wrench is not None and len(episode.wrench.t) > _MIN_SAMPLES_IN_TIME
    ]
    figures = [
        wrenches.time_course(index, episode, episode.wrench, series)
        for index, episode in enumerate(long[:_MAX_PANELS])
        if episode.wrench is not None
    ]
    text = (
        "These pushes are quasi-static: the force alone does not determine the motion. The plots compare "
        "the wrench that the model requires for the observed motion with the recorded one. "
        "Points outside the axes are drawn on their edge."
    )
    return section(
        "wrench",
        "Required and recorded wrench",
        tag("p", text),
        gallery(agreement),
        [legend(*side_entries("required", [episode.wrench for episode in long])), gallery(figures)]
        if figures
        else None,
    )


def ranking(series: Mapping[str, Any]) -> Html | None:
    """Return the table of tested effects, best first; None if there are none."""
    entries = series.get("candidates") or ()
    if not entries:
        return None
    text = (
        "Each row adds effects to the simulation and refits it. Higher values are better. "
        "Log evidence: all training data, relative to the best. Log score: mean per training sample."
    )
    found = tables.candidate_rows(entries)
    return section(
        "ranking",
        "Tested effects",
        tag("p", text),
        tables.candidate_table(found[:_OPEN_CANDIDATES]),
        collapsible(f"{len(found) - _OPEN_CANDIDATES} more", tables.candidate_table(found[_OPEN_CANDIDATES:]))
        if len(found) > _OPEN_CANDIDATES
        else None,
    )


def error_metrics(diagnosis: Mapping[str, Any], series: Series) -> Html:
    """Return the error metrics of held-out data, and those of training data collapsed."""
    fit, single = diagnosis.get("fit") or {}, is_single(diagnosis, series.unnamed)
    given = diagnosis.get("verdict") == "reparameterised"
    before, after = ("as given", "refitted") if given else ("refitted", "with the missing effects")
    sides = "" if single else f" Before: the simulation {before}. After: the simulation {after}."
    above = headline_metric(diagnosis, series) if verdict_scores(diagnosis)[0] == "held-out" else None
    also = ", without the metric in the headline" if above else ""
    return section(
        "fit",
        "Error metrics",
        tag("p", f"Held-out data{also}.{sides}"),
        tables.metrics(fit.get("held_out") or {}, series, single, above),
        collapsible("Training data", tables.metrics(fit.get("training") or {}, series, single)),
    )


def parameters(diagnosis: Mapping[str, Any]) -> Html | None:
    """Return the parameters of the simulation under test; None if there are none."""
    given = diagnosis.get("nominal") or {}
    found = tables.nominal_parameters(given)
    if found is None:
        return None
    same = not given.get("after") or given.get("after") == given.get("before")
    how = "Refitted" if same else "Refitted without (before) and with (after) the missing effects"
    how = "As given and refitted (after)" if diagnosis.get("verdict") == "reparameterised" else how
    text = f"{how}. ± is one standard deviation."
    return section("nominal", "Parameters of the simulation", tag("p", text), found)
