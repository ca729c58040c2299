"""Sentences about an episode."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trundle.experiments.runs.history import Episode, Update, named_effects, supposed_effects
from trundle.report import wording
from trundle.report.quantity import display_scale, format_estimate, format_fixed, format_quantity, join_words
from trundle.report.series import Array

__all__ = ["belief_line", "headline", "lead", "line", "summary"]

FOUND_DISTANCE_M = 0.02
"""Largest error of a wheel that counts as found."""
MILLIMETRE_SD_M = 0.005
"""Largest standard deviation for which positions are given in millimetres."""
LAWLESS = "regression model"
"""Text for a regression model, whose coefficients have no physical names."""
GAP = "\N{NO-BREAK SPACE}"


def headline(episode: Episode) -> str:
    """Return the outcome of an episode."""
    ended = episode.outcome
    after = f"after {format_seconds(ended['seconds'])}"
    if ended["is_success"]:
        return f"Reached the goal {after}."
    if ended["lost"]:
        return f"Lost the object {after}."
    off = ended["distance"]
    return f"Time limit reached {after}, {display_scale('m', off).text(off, 2)} from the goal."


def lead(episode: Episode) -> list[str]:
    """Return sentences about the belief and the hidden physics, most important first."""
    return [
        text
        for text in (
            wheel_sentence(episode),
            convergence_sentence(episode),
            hidden_sentence(episode),
            *added_sentences(episode),
            obstacle_sentence(episode),
        )
        if text
    ]


def wheel_sentence(episode: Episode) -> str:
    """Return the estimated and the true position of the wheel."""
    last = episode.last
    if last is None:
        return "The agent did not update its initial model."
    if last.wheel is None:
        return (
            "It learnt a regression model, which has no wheel."
            if not last.estimates
            else "The model has no wheel."
        )
    off = episode.off(last)
    verb = "found" if off is None or off <= FOUND_DISTANCE_M else "estimated"
    text = f"The wheel was {verb} at {format_point(last.wheel.at, place_sd(last))}"
    return (
        f"{text}; its true position is {format_point(episode.wheel.at, np.zeros(2))}."
        if episode.wheel is not None
        else f"{text}."
    )


def convergence_sentence(episode: Episode) -> str | None:
    """Return the fit from which on the wheel's position was correct."""
    offs = [episode.off(update) for update in episode.updates]
    known = [off is not None and off <= FOUND_DISTANCE_M for off in offs]
    count = len(known)
    total = f"{count}{GAP}fit{'s' if count != 1 else ''}"
    if not count or episode.wheel is None:
        return f"It learnt from {total}." if count else None
    since = max((index + 1 for index, near in enumerate(known) if not near), default=0)
    if since == count:
        last = offs[-1]
        return (
            None
            if last is None
            else f"After {total} the estimate was still off by {format_quantity('m', last)}."
        )
    when = format_seconds(episode.updates[since].time)
    within = f"within {display_scale('m', FOUND_DISTANCE_M).text(FOUND_DISTANCE_M, 1)} of the true position"
    return f"From fit {since + 1} of {count} on, {when} after the start, the estimate was {within}."


def hidden_sentence(episode: Episode) -> str | None:
    """Return the other hidden effects."""
    parts = [
        each.name if each.at is None else f"{each.name} at {format_point(each.at)}" for each in episode.hidden
    ]
    return f"Other hidden effects: {join_words(parts)}." if parts else None


def added_sentences(episode: Episode) -> list[str]:
    """Return the named and supposed effects with their times."""
    found = [
        f"{wording.capitalise(wording.effect_name(name))} was named after {format_seconds(time)} "
        "and added to the model."
        for time, name in named_effects(episode)
    ]
    return found + [
        f"{wording.capitalise(wording.effect_names(effects))} was supposed after {format_seconds(time)}: the "
        "diagnosis does not confirm it, but it improves the predictions."
        for time, effects in supposed_effects(episode)
    ]


def obstacle_sentence(episode: Episode) -> str | None:
    """Return the number of collisions with an obstacle."""
    if not episode.obstacles:
        return None
    times = int(episode.outcome["touched"])
    return (
        f"The obstacle was touched {times} times."
        if times > 1
        else ("The obstacle was touched once." if times else "The obstacle was not touched.")
    )


def summary(episodes: Sequence[Episode]) -> str:
    """Return the outcomes of several episodes."""
    reached = [each for each in episodes if each.outcome["is_success"]]
    text = f"Reached the goal in {len(reached)} of {len(episodes)} episodes"
    if not reached:
        return f"{text}."
    times = [each.outcome["seconds"] for each in reached]
    return f"{text}, after {format_seconds(float(np.median(times)))} (the median)."


def line(episode: Episode) -> str:
    """Return an episode in one line."""
    return f"{headline(episode)} {wheel_sentence(episode)}"


def belief_line(update: Update) -> str:
    """Return the belief as a line for the terminal."""
    if update.wheel is None:
        parts = [
            join_words([each.name for each in update.other_effects])
            or ("no wheel" if update.estimates else LAWLESS)
        ]
    else:
        drags = [update.value(name) for name in ("least", "most")]
        known = [
            format_estimate(each.mean, each.sd) for each in drags if each is not None and each.sd is not None
        ]
        parts = [f"wheel at {format_point(update.wheel.at, place_sd(update))}"]
        parts += [f"drag {join_words(known)} N·s/m"] if known else []
    mass = update.value("body.mass")
    parts += [f"mass {format_estimate(mass.mean, mass.sd, 'kg')}"] if mass is not None and mass.mean else []
    parts += [f"named: {wording.effect_names(update.named)}"] if update.named else []
    parts += [f"supposed: {wording.effect_names(update.supposed)}"] if update.supposed else []
    parts += [f"new grasp at {format_point(update.regrasp)}"] if update.regrasp is not None else []
    return " · ".join(parts)


def place_sd(update: Update) -> Array | None:
    """Return the standard deviation (2,) of the wheel's position, m."""
    return None if update.wheel_covariance is None else np.sqrt(np.diag(update.wheel_covariance))


def format_point(at: Array, sd: Array | None = None) -> str:
    """Return a point with its standard deviation: `(0.50, −0.30) m ± 1 cm`; `?` for an unknown coordinate."""
    known = np.full(2, True) if sd is None else np.isfinite(sd)
    worst = None if sd is None or not known.any() else float(sd[known].max())
    places = 2 if worst is None or worst > MILLIMETRE_SD_M else 3
    texts = [format_fixed(value, places) if held else "?" for value, held in zip(at, known, strict=True)]
    point = f"({', '.join(texts)}){GAP}m"
    return point if not worst else f"{point} ± {display_scale('m', worst).text(worst, 1)}"


def format_seconds(time: float) -> str:
    """Return a time, with as many digits as multiples of 0.05 s need."""
    tenths = abs(round(time, 1) - time) < 1e-6
    return f"{format_fixed(time, 1 if tenths else 2)}{GAP}s"
