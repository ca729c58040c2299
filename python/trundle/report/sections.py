"""The sections of the page that show motion, wrenches and what was tried."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from trundle.report import tables, words
from trundle.report.figures import floor, place
from trundle.report.figures import motion as motions
from trundle.report.figures import wrench as wrenches
from trundle.report.gallery import gallery, of
from trundle.report.given import Episode, Series, held_out_first
from trundle.report.legend import legend, sides
from trundle.report.markup import Html, tag
from trundle.report.section import fold, section
from trundle.report.verdict import headline, is_single, judged, lead, quoted
from trundle.report.where import places

__all__ = ["answer", "figures_of_fit", "motion", "parameters", "ranking", "slow_pushes"]

_DRAWN = 9
_RANKED = 6
_LONG = 6


def answer(
    diagnosis: Mapping[str, Any], series: Series, warnings: Sequence[str], recording: str, contents: Html
) -> Html:
    """Return the sentence, what to doubt in it, and the object and the floor with the places marked."""
    sentences = lead(diagnosis, series)
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
    """Return what a careful reader must know, where it cannot be missed."""
    if not warnings:
        return None
    title = tag("b", "Warning" if len(warnings) == 1 else "Warnings")
    items = [tag("li", words.capitalised(words.spoken(each))) for each in warnings]
    return tag("div", title, tag("ul", items), class_="warnings", role="note")


def _maps(diagnosis: Mapping[str, Any], series: Series) -> tuple[Html | None, Html | None]:
    """Return the object unless only the floor has something to mark, and the floor if it has."""
    ground = floor.draw(diagnosis, series)
    named = places(diagnosis.get("missing") or ())
    marked = place.hinted(diagnosis) is not None or any(each.body is not None for each in named)
    return (place.draw(diagnosis, series) if marked or ground is None else None), ground


def motion(diagnosis: Mapping[str, Any], series: Series) -> Html | None:
    """Return recorded and simulated motion: episodes with an event first, then held-out ones."""
    named = places(diagnosis.get("missing") or ())
    drawable = sorted(
        (episode for episode in held_out_first(series.episodes) if _simulated(episode)),
        key=lambda episode: not motions.events_in(episode, named),
    )
    if not drawable:
        return None
    figures = [motions.draw(index, episode, series, named) for index, episode in enumerate(drawable[:_DRAWN])]
    text = "The recorded force alone drives the simulation, from rest. Held-out episodes were never fitted."
    return section(
        "motion",
        "Simulation against recording",
        tag("p", text, of(len(figures), len(drawable))),
        legend(*sides("simulated", drawable)),
        gallery(figures),
    )


def _simulated(episode: Episode) -> bool:
    return len(episode.t) > 1 and (episode.before is not None or episode.after is not None)


def slow_pushes(series: Series) -> Html | None:
    """Needed against recorded wrench, where no motion can be simulated."""
    agreement = wrenches.agreement(series)
    if not agreement:
        return None
    long = [
        episode
        for episode in held_out_first(series.episodes)
        if episode.wrench is not None and len(episode.wrench.t) > _LONG
    ]
    figures = [
        wrenches.in_time(index, episode, episode.wrench, series)
        for index, episode in enumerate(long[:_DRAWN])
        if episode.wrench is not None
    ]
    text = (
        "These pushes are slow: no motion can be simulated from the force alone. Compared is the wrench "
        "that the model needs for the motion that was seen; points beyond the frame are drawn on its edge."
    )
    return section(
        "wrench",
        "Wrench of the model against the recorded one",
        tag("p", text),
        gallery(agreement),
        [legend(*sides("needed", [episode.wrench for episode in long])), gallery(figures)]
        if figures
        else None,
    )


def ranking(series: Mapping[str, Any]) -> Html | None:
    """Return the candidates, best first."""
    entries = series.get("candidates") or ()
    if not entries:
        return None
    text = (
        "Laws added to the simulation, refitted each time. Higher is better: the log evidence of all the "
        "training data, relative to the best, and the log score of a training sample."
    )
    found = tables.candidates(entries)
    return section(
        "ranking",
        "What was tried",
        tag("p", text),
        tables.ranked(found[:_RANKED]),
        fold(f"{len(found) - _RANKED} more", tables.ranked(found[_RANKED:]))
        if len(found) > _RANKED
        else None,
    )


def figures_of_fit(diagnosis: Mapping[str, Any], series: Series) -> Html:
    """Return held-out figures in full, training figures behind a fold."""
    fit, single = diagnosis.get("fit") or {}, is_single(diagnosis, series.unnamed)
    given = diagnosis.get("verdict") == "reparameterised"
    meaning = "with the values given; after: refitted" if given else "refitted; after: with what is missing"
    sides = "" if single else f"; before: the simulation {meaning}"
    above = quoted(diagnosis, series) if judged(diagnosis)[0] == "held-out" else None
    also = ", in addition to the figure below the headline" if above else ""
    return section(
        "fit",
        "How far off",
        tag("p", f"On held-out data{also}{sides}."),
        tables.fit(fit.get("held_out") or {}, series, single, above),
        fold("On the data that were fitted", tables.fit(fit.get("training") or {}, series, single)),
    )


def parameters(diagnosis: Mapping[str, Any]) -> Html | None:
    """Parameters of the simulation under test."""
    given = diagnosis.get("nominal") or {}
    found = tables.nominal(given)
    if found is None:
        return None
    same = not given.get("after") or given.get("after") == given.get("before")
    how = "Refitted" if same else "Refitted without (before) and with (after) what was missing"
    how = "As given and refitted (after)" if diagnosis.get("verdict") == "reparameterised" else how
    text = f"{how}; ± is one standard deviation."
    return section("nominal", "Parameters of the simulation", tag("p", text), found)
