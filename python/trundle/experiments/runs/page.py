"""The page of a run: the result, the belief after each fit, and how to reproduce it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from trundle import __version__
from trundle.experiments.results import Row
from trundle.experiments.runs import sentences
from trundle.experiments.runs.config import Settings
from trundle.experiments.runs.figures import scene, time, wheel
from trundle.experiments.runs.history import WHEEL, Episode, Update, select_stages
from trundle.experiments.runs.sentences import GAP, format_seconds
from trundle.report import wording
from trundle.report.jinja import render_template
from trundle.report.parameter import Quantity, format_parameter
from trundle.report.quantity import (
    ABSENT,
    format_estimate,
    format_fixed,
    format_point,
    format_quantity,
    join_words,
)

__all__ = ["render"]

MAX_STAGES = 6
"""Maximum number of fits that are drawn, unless more of them added a law."""


def render(settings: Settings, config: str, episodes: Sequence[Episode]) -> str:
    """Render the page of at least one episode; `config` is the name of the settings file.

    The page needs no network and works without scripts. The same input gives the same bytes.
    """
    hidden = settings.arguments.get("hidden")
    run = f"Run of {settings.environment}" + (f', hidden="{hidden}"' if hidden else "")
    result = sentences.headline(episodes[0]) if len(episodes) == 1 else sentences.summary(episodes)
    return render_template(
        "trundle.experiments.runs",
        "run.html",
        title=f"{run}: {result}",
        run=run,
        result=result,
        episodes=[episode_row(f"e{number}", episode) for number, episode in enumerate(episodes)],
        config=config,
        version=__version__,
        settings=settings.text.strip(),
        has_recording=settings.recording != "none",
    )


def episode_row(identity: str, episode: Episode) -> Row:
    """Return everything that the page shows of an episode."""
    has_estimate = any(update.wheel is not None for update in episode.updates)
    stages = select_stages(episode, MAX_STAGES) if has_estimate else []
    hidden = [
        each.name if each.at is None else f"{each.name} at {format_point(each.at)}" for each in episode.hidden
    ]
    estimated = [effect for update in episode.updates for effect in update.other_effects]
    marked = [*episode.hidden, *sorted(estimated, key=lambda effect: effect.name)]
    error = episode.wheel_error(episode.updates[-1]) if episode.updates else None
    return {
        "identity": identity,
        "episode": episode,
        "headline": sentences.headline(episode),
        "sentences": [sentences.wheel_sentence(episode), sentences.convergence_sentence(episode)],
        "hidden": join_words(hidden),
        "seconds": format_seconds(episode.outcome["seconds"]),
        "distance": format_quantity("m", episode.outcome["distance"]),
        "wheel_error": format_quantity("m", error),
        "scene": scene.draw(identity, episode),
        "frames": scene.frames(episode),
        "marked": join_words(list(dict.fromkeys(each.name for each in marked if each.at is not None))),
        "tiles": [wheel.draw(f"{identity}-tile{n}", episode, update) for n, update in enumerate(stages)],
        "curves": time.beliefs(identity, episode),
        "updates": [update_row(episode, update) for update in episode.updates],
        "estimates": estimate_rows(episode),
        "added": time.added(identity, episode),
        "push": time.push(identity, episode),
    }


def update_row(episode: Episode, update: Update) -> Row:
    """Return the row of an update, with the changes of the model."""

    def numbers(*names: str) -> list[Quantity]:
        found: list[Any] = [update.estimates.get(name, {}) for name in names]
        return [format_parameter({"mean": each.get("mean"), "sd": each.get("sd")}) for each in found]

    index = int(np.searchsorted(episode.t, update.time - 1e-9))
    return {
        "time": format_fixed(update.time, 2),
        "after": format_seconds(update.time),
        "named": [wording.capitalise(wording.effect_name(name)) for name in update.named],
        "supposed": wording.capitalise(wording.effect_names(update.supposed)),
        "changes": ", ".join(sentences.change_phrases(update)).replace(GAP, " "),
        "distance": format_fixed(float(episode.distance[index]), 2),
        "position": numbers(f"{WHEEL}.x", f"{WHEEL}.y"),
        "drag": numbers("least", "most"),
        "mass": numbers("body.mass"),
    }


def estimate_rows(episode: Episode) -> list[Row]:
    """Return a row for each estimate of the last belief: of the body, the wheel and the other effects."""
    found = episode.updates[-1].estimates if episode.updates else {}
    own = [name for name in found if not name.startswith(f"{WHEEL}.") and name not in time.WHEEL_TITLES]
    body = [name for name in own if name.startswith("body.")]
    wheel_names = [name for name in time.WHEEL_TITLES if name in found]
    rows = []
    for name in dict.fromkeys([*body, *wheel_names, *own]):
        estimate = found[name]
        true, mean, sd = episode.true_value(name), estimate["mean"], estimate["sd"]
        gap = None if true is None or mean is None else mean - true
        if name == "angle" and gap is not None:
            # Opposite directions of least drag are equal.
            gap = math.remainder(gap, math.pi)
            true = mean - gap
        rows.append(
            {
                "name": time.estimate_title(name),
                "estimate": format_parameter(estimate),
                "true_value": format_estimate(true, None, estimate["unit"]),
                "error": ABSENT if gap is None or not sd else format_fixed(abs(gap) / sd, 1),
            }
        )
    return rows
