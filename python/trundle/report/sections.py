"""The sections of the page, in the order in which a reader asks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from trundle.report import tables
from trundle.report.figures import motion as motions
from trundle.report.figures import place
from trundle.report.figures import residual as residuals
from trundle.report.figures import wrench as wrenches
from trundle.report.given import Episode, Series, finite, held_out_first
from trundle.report.markup import Html, tag
from trundle.report.quantity import ABSENT, listed, shown
from trundle.report.section import section
from trundle.report.verdict import headline, lead

__all__ = [
    "answer",
    "figures_of_fit",
    "motion",
    "nominal",
    "ranking",
    "reproduce",
    "residual",
    "slow_pushes",
]

_OPEN, _FOLDED = 3, 6
_RANKED = 6
_LONG = 6


def _panels(figures: Sequence[Html]) -> Html:
    """Return the first few open, the others behind a fold."""
    first, rest = figures[:_OPEN], figures[_OPEN:]
    fold = tag("details", tag("summary", f"{len(rest)} more episodes"), tag("div", rest, class_="panels"))
    return tag("div", tag("div", first, class_="panels"), fold if rest else None, class_="gallery")


def _of(shown: int, total: int) -> str:
    return "" if shown == total else f" {shown} of {total} episodes are drawn."


def answer(diagnosis: Mapping[str, Any], series: Series, recording: str) -> Html:
    """Return the sentence, and the object with the place marked."""
    verdict = str(diagnosis.get("verdict"))
    words = tag(
        "div",
        tag("p", "Diagnosis of ", tag("b", recording), class_="kicker"),
        tag("h1", headline(diagnosis)),
        [tag("p", sentence, class_="lead") for sentence in lead(diagnosis, series)],
        class_="words",
    )
    return tag("header", words, place.draw(diagnosis, series), class_=f"answer {verdict}")


def _legend(verb: str, sides: Sequence[str]) -> Html:
    entries = [("recorded", "recorded"), *((side, f"{verb} {side}") for side in sides)]
    return tag("p", [_swatch(style, words) for style, words in entries], class_="legend")


def _sides(curves: Sequence[object]) -> list[str]:
    """Which of before and after any of the curves has."""
    return [side for side in ("before", "after") if any(getattr(each, side) is not None for each in curves)]


def _swatch(style: str, words: str) -> Html:
    line = tag("svg", tag("path", d="M1 6H33", class_=style), viewBox="0 0 34 12", aria_hidden="true")
    return tag("span", line, f" {words}")


def motion(diagnosis: Mapping[str, Any], series: Series) -> Html | None:
    """Return recorded and simulated motion, held-out episodes first."""
    drawable = [episode for episode in held_out_first(series.episodes) if _simulated(episode)]
    if not drawable:
        return None
    effects = diagnosis.get("missing") or ()
    figures = [
        motions.draw(index, episode, series, effects)
        for index, episode in enumerate(drawable[: _OPEN + _FOLDED])
    ]
    text = "The recorded force alone drives the simulation, from rest. Held-out episodes were never fitted."
    return section(
        "Simulation against recording",
        tag("p", text, _of(len(figures), len(drawable))),
        _legend("simulated", _sides(drawable)),
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
        "Wrench of the model against the recorded one",
        tag("p", text),
        _panels(agreement),
        [_legend("needed", _sides([episode.wrench for episode in long])), _panels(figures)]
        if figures
        else None,
    )


def figures_of_fit(diagnosis: Mapping[str, Any], series: Series) -> Html:
    """Held-out figures in full, training figures behind a fold."""
    fit = diagnosis.get("fit") or {}
    return section(
        "How far off",
        tag(
            "p",
            "On held-out data; before: the simulation as given, refitted; after: with what is missing.",
        ),
        tables.fit(fit.get("held_out") or {}, series),
        tag(
            "details",
            tag("summary", "On the data that were fitted"),
            tables.fit(fit.get("training") or {}, series),
        ),
    )


def residual(diagnosis: Mapping[str, Any], series: Series) -> Html | None:
    """Return the missing wrench in time, and when, where and in what it shows."""
    mismatch = diagnosis.get("mismatch") or {}
    windows = mismatch.get("windows") or ()
    effects = diagnosis.get("missing") or ()
    episodes = residuals.chosen(series, windows, _OPEN + _FOLDED)
    figures = [
        residuals.draw(index, episode, episode.residual, series, windows, effects)
        for index, episode in enumerate(episodes)
        if episode.residual is not None
    ]
    listing = tables.windows(windows)
    if not figures and listing is None:
        return None
    total = sum(episode.residual is not None for episode in series.episodes)
    text = "What the seen motion needs and the simulation lacks: force and torque in the object's axes."
    return section(
        "What the simulation lacks in time",
        tag("p", text, _of(len(figures), total), _shares(mismatch, series), _regime(mismatch)),
        _panels(figures),
        tag("details", tag("summary", "The windows in numbers"), listing) if listing else None,
    )


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
    rest = entries[_RANKED:]
    return section(
        "What else was tried",
        tag("p", "Log evidence is relative to the best; the log score is that of episodes left out in turn."),
        tables.candidates(entries[:_RANKED]),
        tag("details", tag("summary", f"{len(rest)} more"), tables.candidates(rest)) if rest else None,
    )


def nominal(diagnosis: Mapping[str, Any]) -> Html | None:
    """Parameters of the simulation under test."""
    found = tables.nominal(diagnosis.get("nominal") or {})
    if found is None:
        return None
    text = "Refitted without (before) and with (after) what was missing; ± is one standard deviation."
    return section("Parameters of the simulation", tag("p", text), found)


def _seed(series: Mapping[str, Any]) -> str:
    seed = series.get("seed")
    return str(seed) if isinstance(seed, int | str) else ABSENT


def reproduce(series: Mapping[str, Any]) -> Html:
    """How to get this page again."""
    noise = series.get("noise") or {}
    pose = noise.get("pose") or (None, None, None)
    origin = "as the recording states" if noise.get("stated") else "estimated from the recording"
    return section(
        "How to get this page again",
        tag("pre", tag("code", str(series.get("command") or ""))),
        tag(
            "p",
            f"trundle {series.get('version') or ''}, seed {_seed(series)}. ",
            "The same recording and seed give the same bytes.",
        ),
        tag(
            "p",
            f"Noise, one standard deviation, {origin}: "
            f"position {shown('m', pose[0])} and {shown('m', pose[1])}, "
            f"heading {shown('rad', pose[2])}, force {shown('N', noise.get('force'))}, "
            f"torque {shown('N·m', noise.get('torque'))}.",
        ),
        tag(
            "p",
            "Beside this page: ",
            tag("code", "diagnosis.json"),
            " holds the same for programs, ",
            tag("code", "model.toml"),
            " the extended model, ",
            tag("code", "predictions.parquet"),
            " the simulated motion of the held-out episodes.",
        ),
    )
