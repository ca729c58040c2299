"""The sections of the page that show motion, wrenches and what was tried."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from trundle.report import tables
from trundle.report.figures import floor, place
from trundle.report.figures import motion as motions
from trundle.report.figures import residual as residuals
from trundle.report.figures import wrench as wrenches
from trundle.report.given import Episode, Series, finite, held_out_first
from trundle.report.legend import legend, sides
from trundle.report.markup import Html, tag
from trundle.report.quantity import listed
from trundle.report.section import fold, section
from trundle.report.verdict import headline, lead
from trundle.report.where import Place, places

__all__ = ["answer", "figures_of_fit", "motion", "nominal", "ranking", "residual", "slow_pushes"]

_OPEN, _FOLDED = 3, 6
_RANKED = 6
_LONG = 6


def _panels(figures: Sequence[Html], name: str = "episodes") -> Html:
    """Return the first few open, the others behind a fold."""
    first, rest = figures[:_OPEN], figures[_OPEN:]
    more = fold(f"{len(rest)} more {name}", tag("div", rest, class_="panels")) if rest else None
    return tag("div", tag("div", first, class_="panels"), more, class_="gallery")


def _of(shown: int, total: int) -> str:
    return "" if shown == total else f" {shown} of {total} episodes are drawn."


def answer(diagnosis: Mapping[str, Any], series: Series, recording: str, contents: Html) -> Html:
    """Return the sentence, and the object and the floor with the places marked."""
    sentences = lead(diagnosis, series)
    text = tag(
        "div",
        tag("p", "Diagnosis of ", tag("b", recording), class_="kicker"),
        tag("h1", headline(diagnosis)),
        [tag("p", sentence, class_="lead") for sentence in sentences],
        contents,
        class_="words",
    )
    maps = [found for found in _maps(diagnosis, series) if found is not None]
    drawn = tag("div", maps, class_="maps") if maps else None
    kind = f"{diagnosis.get('verdict')}{' two' if len(maps) > 1 else ''}"
    return tag("header", text, drawn, class_=f"answer {kind}")


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
    figures = [
        motions.draw(index, episode, series, named)
        for index, episode in enumerate(drawable[: _OPEN + _FOLDED])
    ]
    text = "The recorded force alone drives the simulation, from rest. Held-out episodes were never fitted."
    return section(
        "motion",
        "Simulation against recording",
        tag("p", text, _of(len(figures), len(drawable))),
        legend(*sides("simulated", drawable)),
        _panels(figures),
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
        for index, episode in enumerate(long[: _OPEN + _FOLDED])
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
        _panels(agreement),
        [legend(*sides("needed", [episode.wrench for episode in long])), _panels(figures)]
        if figures
        else None,
    )


def residual(diagnosis: Mapping[str, Any], series: Series) -> Html | None:
    """Return the missing wrench in time, and when, where and in what it shows."""
    mismatch = diagnosis.get("mismatch") or {}
    windows = mismatch.get("windows") or ()
    named: Sequence[Place] = places(diagnosis.get("missing") or ())
    episodes = residuals.chosen(series, windows, _OPEN + _FOLDED)
    figures = [
        residuals.draw(index, episode, episode.residual, series, windows, named)
        for index, episode in enumerate(episodes)
        if episode.residual is not None
    ]
    listing = tables.windows(windows)
    if not figures and listing is None:
        return None
    total = sum(episode.residual is not None for episode in series.episodes)
    text = "Force and torque that the seen motion needs and the simulation lacks, in the object's axes."
    return section(
        "residual",
        "What the simulation lacks in time",
        tag("p", text, _of(len(figures), total), _shares(mismatch, series), _regime(mismatch)),
        legend(*_residual_legend(windows)) if figures else None,
        _panels(figures) if figures else None,
        fold("The windows in numbers", listing) if listing else None,
    )


def _residual_legend(windows: Sequence[object]) -> list[tuple[str, str]]:
    band = [("band", "what noise alone explains (two standard deviations)")]
    return band + ([("window", "windows that noise cannot explain")] if windows else [])


def _shares(mismatch: Mapping[str, Any], series: Series) -> str:
    given = mismatch.get("channels") or {}
    shares = [(name, value) for name in series.dof if (value := finite(given.get(name))) is not None]
    words = {"theta": "heading"}
    if len(shares) < 2:
        return ""
    parts = [f"{words.get(name, name)} {100.0 * share:.0f} %" for name, share in shares]
    return f" Shares of the misfit: {listed(parts)}."


def _regime(mismatch: Mapping[str, Any]) -> str:
    return f" It acts {mismatch['regime']}." if mismatch.get("regime") else ""


def ranking(series: Mapping[str, Any]) -> Html | None:
    """Return the candidates, best first."""
    entries = series.get("candidates") or ()
    if not entries:
        return None
    text = (
        "Laws added to the simulation, refitted each time. Higher is better: the log evidence of all the "
        "training data, relative to the best, and the log score of a sample in an episode left out."
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
    fit, single = diagnosis.get("fit") or {}, diagnosis.get("verdict") == "consistent"
    sides = "" if single else "; before: the simulation as given, refitted; after: with what is missing"
    return section(
        "fit",
        "How far off",
        tag("p", f"On held-out data{sides}."),
        tables.fit(fit.get("held_out") or {}, series, single),
        fold("On the data that were fitted", tables.fit(fit.get("training") or {}, series, single)),
    )


def nominal(diagnosis: Mapping[str, Any]) -> Html | None:
    """Parameters of the simulation under test."""
    found = tables.nominal(diagnosis.get("nominal") or {})
    if found is None:
        return None
    text = "Refitted without (before) and with (after) what was missing; ± is one standard deviation."
    return section("nominal", "Parameters of the simulation", tag("p", text), found)
