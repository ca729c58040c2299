"""What happened, in sentences."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trundle.experiments.runs.told import Episode, Update, named, supposed
from trundle.report import wording
from trundle.report.quantity import display_scale, format_estimate, format_fixed, format_quantity, join_words
from trundle.report.series import Array

__all__ = ["believed", "headline", "lead", "line", "summary"]

NEAR = 0.02
"""Distance from the true wheel, m, from which on the page calls it found."""
FINE = 0.005
"""Standard deviation, m, up to which millimetres are written."""
LAWLESS = "learnt without laws"
"""What is said of a regression, whose coefficients have no names."""
GAP = "\N{NO-BREAK SPACE}"


def headline(episode: Episode) -> str:
    """Return how an episode ended."""
    ended = episode.outcome
    after = f"after {seconds(ended['seconds'])}"
    if ended["is_success"]:
        return f"Reached the goal {after}."
    if ended["lost"]:
        return f"Lost the object {after}."
    off = ended["distance"]
    return f"Time was up {after}, {display_scale('m', off).text(off, 2)} from the goal."


def lead(episode: Episode) -> list[str]:
    """Return what was learnt, and what else is to be said, most important first."""
    return [
        text
        for text in (found(episode), pace(episode), hidden(episode), *additions(episode), obstacle(episode))
        if text
    ]


def found(episode: Episode) -> str:
    """Return where the wheel was found, and where it is."""
    last = episode.last
    if last is None:
        return "The agent kept to its first belief."
    if last.wheel is None:
        return (
            "It learnt without laws: nothing is said of a wheel." if not last.held else "It found no wheel."
        )
    off = episode.off(last)
    verb = "found" if off is None or off <= NEAR else "believed"
    text = f"The wheel was {verb} at {place(last.wheel.at, deviation(last))}"
    return (
        f"{text}; it is at {place(episode.wheel.at, np.zeros(2))}."
        if episode.wheel is not None
        else f"{text}."
    )


def pace(episode: Episode) -> str | None:
    """Return from which fit on the wheel was known."""
    offs = [episode.off(update) for update in episode.updates]
    known = [off is not None and off <= NEAR for off in offs]
    count = len(known)
    total = f"{count}{GAP}fit{'s' if count != 1 else ''}"
    if not count or episode.wheel is None:
        return f"It learnt from {total}." if count else None
    since = max((index + 1 for index, near in enumerate(known) if not near), default=0)
    if since == count:
        last = offs[-1]
        return (
            None if last is None else f"After {total} the belief was still {format_quantity('m', last)} off."
        )
    when = seconds(episode.updates[since].time)
    within = f"within {display_scale('m', NEAR).text(NEAR, 1)} of the truth"
    return f"From fit {since + 1} of {count} on, {when} after the start, the belief was {within}."


def hidden(episode: Episode) -> str | None:
    """Return what else was hidden."""
    parts = [each.name if each.at is None else f"{each.name} at {place(each.at)}" for each in episode.hidden]
    return f"Hidden beside the wheel: {join_words(parts)}." if parts else None


def additions(episode: Episode) -> list[str]:
    """Return what was named or supposed, and when."""
    found = [
        f"{wording.capitalise(wording.effect_name(name))} was named after {seconds(time)} "
        "and added to the model."
        for time, name in named(episode)
    ]
    return found + [
        f"{wording.capitalise(wording.effect_names(effects))} was supposed after {seconds(time)}: "
        "the diagnosis does not vouch for it, but with it the model predicts better."
        for time, effects in supposed(episode)
    ]


def obstacle(episode: Episode) -> str | None:
    """Return how often an obstacle was touched."""
    if not episode.obstacles:
        return None
    times = int(episode.outcome["touched"])
    return (
        f"The obstacle was touched {times} times."
        if times > 1
        else ("The obstacle was touched once." if times else "The obstacle was not touched.")
    )


def summary(episodes: Sequence[Episode]) -> str:
    """Return how several episodes ended."""
    reached = [each for each in episodes if each.outcome["is_success"]]
    text = f"Reached the goal in {len(reached)} of {len(episodes)} episodes"
    if not reached:
        return f"{text}."
    times = [each.outcome["seconds"] for each in reached]
    return f"{text}, after {seconds(float(np.median(times)))} (the median)."


def line(episode: Episode) -> str:
    """Return an episode in one line."""
    return f"{headline(episode)} {found(episode)}"


def believed(update: Update) -> str:
    """Return what is believed, in a line for the terminal."""
    if update.wheel is None:
        parts = [
            join_words([each.name for each in update.others]) or ("rolls freely" if update.held else LAWLESS)
        ]
    else:
        drags = [update.value(name) for name in ("least", "most")]
        known = [
            format_estimate(each.mean, each.sd) for each in drags if each is not None and each.sd is not None
        ]
        parts = [f"wheel at {place(update.wheel.at, deviation(update))}"]
        parts += [f"drag {join_words(known)} N·s/m"] if known else []
    mass = update.value("body.mass")
    parts += [f"mass {format_estimate(mass.mean, mass.sd, 'kg')}"] if mass is not None and mass.mean else []
    parts += [f"named: {wording.effect_names(update.named)}"] if update.named else []
    parts += [f"supposed: {wording.effect_names(update.supposed)}"] if update.supposed else []
    parts += [f"goes to hold it at {place(update.regrasp)}"] if update.regrasp is not None else []
    return " · ".join(parts)


def deviation(update: Update) -> Array | None:
    """Return the standard deviation (2,) of the wheel's place, m."""
    return None if update.spread is None else np.sqrt(np.diag(update.spread))


def place(at: Array, sd: Array | None = None) -> str:
    """Return a point, and how well it is known: `(0.50, −0.30) m ± 1 cm`, `?` where nothing is known."""
    known = np.full(2, True) if sd is None else np.isfinite(sd)
    worst = None if sd is None or not known.any() else float(sd[known].max())
    places = 2 if worst is None or worst > FINE else 3
    texts = [format_fixed(value, places) if held else "?" for value, held in zip(at, known, strict=True)]
    point = f"({', '.join(texts)}){GAP}m"
    return point if not worst else f"{point} ± {display_scale('m', worst).text(worst, 1)}"


def seconds(time: float) -> str:
    """Return a time; an action takes 0.05 s."""
    tenths = abs(round(time, 1) - time) < 1e-6
    return f"{format_fixed(time, 1 if tenths else 2)}{GAP}s"
