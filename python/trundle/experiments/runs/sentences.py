"""Sentences about an episode, for the page and the terminal."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trundle.experiments.runs.history import Episode, Update
from trundle.report import wording
from trundle.report.quantity import (
    display_scale,
    format_estimate,
    format_fixed,
    format_point,
    format_quantity,
    join_words,
)

__all__ = ["belief_line", "change_phrases", "convergence_sentence", "headline", "summary", "wheel_sentence"]

FOUND_DISTANCE_M = 0.02
"""Largest error of a wheel that counts as found."""
GAP = "\N{NO-BREAK SPACE}"


def headline(episode: Episode) -> str:
    """Return the outcome of an episode."""
    outcome = episode.outcome
    after = f"after {format_seconds(outcome['seconds'])}"
    if outcome["is_success"]:
        return f"Reached the goal {after}."
    if outcome["lost"]:
        return f"Lost the object {after}."
    distance = outcome["distance"]
    return f"Time limit reached {after}, {display_scale('m', distance).text(distance, 2)} from the goal."


def summary(episodes: Sequence[Episode]) -> str:
    """Return the outcomes of several episodes."""
    times = [each.outcome["seconds"] for each in episodes if each.outcome["is_success"]]
    text = f"Reached the goal in {len(times)} of {len(episodes)} episodes"
    return f"{text}, after {format_seconds(float(np.median(times)))} (the median)." if times else f"{text}."


def wheel_sentence(episode: Episode) -> str:
    """Return the estimated and the true position of the wheel."""
    if not episode.updates:
        return "The agent did not update its initial model."
    last = episode.updates[-1]
    if last.wheel is None:
        model = "The model has no wheel."
        return model if last.estimates else "It learnt a regression model, which has no wheel."
    error = episode.wheel_error(last)
    true = (
        ""
        if episode.wheel is None
        else f"; its true position is {format_point(episode.wheel.at, np.zeros(2))}"
    )
    if not last.has_located_wheel:
        return f"The pushes did not show where the wheel is{true}."
    verb = "found" if error is None or error <= FOUND_DISTANCE_M else "estimated"
    return f"The wheel was {verb} at {format_point(last.wheel.at, last.wheel_sd)}{true}."


def convergence_sentence(episode: Episode) -> str:
    """Return the fit from which on the wheel's position was correct; empty without a fit."""
    errors = [episode.wheel_error(update) for update in episode.updates]
    count = len(errors)
    total = f"{count}{GAP}fit{'s' if count != 1 else ''}"
    if not errors or episode.wheel is None:
        return f"It learnt from {total}." if errors else ""
    wrong = [index for index, error in enumerate(errors, 1) if error is None or error > FOUND_DISTANCE_M]
    since = max(wrong, default=0)
    if since == count:
        last = errors[-1] if episode.updates[-1].has_located_wheel else None
        still = f"After {total} the estimate was still off by {format_quantity('m', last)}."
        return "" if last is None else still
    when = format_seconds(episode.updates[since].time)
    within = f"within {display_scale('m', FOUND_DISTANCE_M).text(FOUND_DISTANCE_M, 1)} of the true position"
    return f"From fit {since + 1} of {count} on, {when} after the start, the estimate was {within}."


def belief_line(update: Update) -> str:
    """Return the belief as a line for the terminal."""
    if update.wheel is None:
        names = join_words([each.name for each in update.other_effects])
        parts = [names or ("no wheel" if update.estimates else "regression model")]
    else:
        drags = [update.estimates.get(name) for name in ("least", "most")]
        known = [format_estimate(each["mean"], each["sd"]) for each in drags if each and each["sd"]]
        place = format_point(update.wheel.at, update.wheel_sd)
        parts = [f"wheel at {place}" if update.has_located_wheel else "wheel not located"]
        parts += [f"drag {join_words(known)} N·s/m"] if known else []
    mass = update.estimates.get("body.mass")
    parts += [f"mass {format_estimate(mass['mean'], mass['sd'], 'kg')}"] if mass and mass["mean"] else []
    return " · ".join([*parts, *change_phrases(update, "named: ")])


def change_phrases(update: Update, named: str = "") -> list[str]:
    """Return the effects that an update added, the named ones after a prefix, and the new grasp."""
    found = [f"{named}{wording.effect_names(update.named)}"] if update.named else []
    found += [f"supposed: {wording.effect_names(update.supposed)}"] if update.supposed else []
    return found + ([f"new grasp at {format_point(update.regrasp)}"] if update.regrasp is not None else [])


def format_seconds(time: float) -> str:
    """Return a time, with as many digits as multiples of 0.05 s need."""
    tenths = abs(round(time, 1) - time) < 1e-6
    return f"{format_fixed(time, 1 if tenths else 2)}{GAP}s"
