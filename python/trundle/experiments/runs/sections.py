"""Sections of a run's page about one episode."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from trundle.experiments.runs.figures import closing, scene, time, wheel
from trundle.experiments.runs.history import Episode, Estimate, Update, select_stages
from trundle.experiments.runs.sentences import GAP, format_point, headline, lead
from trundle.report import wording
from trundle.report.markup import Child, Html, tag
from trundle.report.parameter import format_parameter
from trundle.report.quantity import ABSENT, format_estimate, format_fixed
from trundle.report.section import collapsible, section
from trundle.report.series import finite
from trundle.report.tables import table

__all__ = ["Part", "answer", "parts"]

Part = tuple[str, str, Html]
"""Identifier in the page, title, and content."""

MAX_STAGES = 6


def answer(identity: str, episode: Episode, kicker: Child, links: Child, title: str = "h1") -> Html:
    """Return the result in sentences, and the animated scene."""
    text = tag(
        "div",
        tag("p", kicker, class_="kicker"),
        tag(title, headline(episode), id=identity),
        [tag("p", sentence, class_="lead") for sentence in lead(episode)],
        links,
    )
    style = "answer consistent" if episode.outcome["is_success"] else "answer"
    return tag("header", text, scene.draw(identity, episode), class_=style)


def parts(identity: str, episode: Episode) -> list[Part]:
    """Return the sections of an episode."""
    found = (
        ("wheel", "The wheel, fit after fit", learning_section(identity, episode)),
        ("numbers", "Estimates and true values", estimates_section(identity, episode)),
        ("push", "The push", [tag("div", time.push(identity, episode), class_="panels")]),
    )
    return [
        (f"{identity}-{key}", name, section(f"{identity}-{key}", name, *children))
        for key, name, children in found
        if children
    ]


def learning_section(identity: str, episode: Episode) -> list[Child]:
    """Return the section about the belief of the wheel."""
    shown = (
        select_stages(episode, MAX_STAGES)
        if any(update.wheel is not None for update in episode.updates)
        else []
    )
    tiles = [wheel.draw(f"{identity}-tile{number}", episode, each) for number, each in enumerate(shown)]
    drawn = (closing.draw(identity, episode), time.wheel(identity, episode), time.beliefs(identity, episode))
    figures = [each for each in drawn if each]
    if not tiles and not episode.updates:
        return []
    left_out = len(episode.updates) - len(shown)
    some = (
        " The figures show the first and the last fit, those that added a law, and some others."
        if tiles and left_out
        else ""
    )
    glass = " Small ellipses are magnified ten times." if tiles else ""
    text = (
        "Top view of the object in its own frame after a fit: cross and ellipse (95 %) for the estimated "
        f"wheel, box for the true one.{wheel.legend(episode)}{glass}{some}"
    )
    return [
        tag("p", text) if tiles else None,
        tag("div", tiles, class_="tiles") if tiles else None,
        tag("div", figures, class_="panels") if figures else None,
        collapsible(f"All {len(episode.updates)} fits in numbers", updates_table(episode)),
    ]


def estimates_section(identity: str, episode: Episode) -> list[Child]:
    """Return the section with estimates and true values, at the end and over time."""
    added = time.others(identity, episode)
    rows = final_rows(episode)
    if not rows:
        return []
    text = "Final estimates with one standard deviation; a dash for numbers that are not identifiable."
    listed = tag("div", tag("p", text), table(("", "estimate", "true", "error, in sd"), rows, "stacked"))
    return [tag("div", listed, added, class_="beside")]


def final_rows(episode: Episode) -> list[list[Child]]:
    """Return a row for each estimate of the last belief."""
    last = episode.last
    if last is None:
        return []
    scaled = [name for name in ("least", "most", "angle") if last.value(name) is not None and last.wheel]
    own = [each.name for each in last.estimates if not each.name.startswith("viscous_wheel.")]
    at = [each.name for each in last.estimates if each.name in ("viscous_wheel.x", "viscous_wheel.y")]
    names = [*(name for name in own if name.startswith("body.")), *at, *scaled]
    names += [name for name in own if name not in names]
    return [estimate_row(episode, name, held) for name in names if (held := last.value(name)) is not None]


NAMED = {"least": "least drag", "most": "most drag", "angle": "direction of least drag"}
PLACES = {"viscous_wheel.x": "wheel, x", "viscous_wheel.y": "wheel, y"}


def estimate_row(episode: Episode, name: str, held: Estimate) -> list[Child]:
    """Return an estimate, its true value, and their difference in standard deviations."""
    true = episode.true_value(name)
    title = NAMED.get(name) or PLACES.get(name) or time.parameter_title(name)
    if held.mean is None:
        return [title, ABSENT, format_true(true, held.unit), ABSENT]
    gap = None if true is None else held.mean - true
    if name == "angle" and gap is not None:
        # Opposite directions of least drag are equal.
        gap = math.remainder(gap, math.pi)
        true = held.mean - gap
    apart = ABSENT if gap is None or not held.sd else format_fixed(abs(gap) / held.sd, 1)
    return [
        title,
        format_parameter({"mean": held.mean, "sd": held.sd, "unit": held.unit}),
        format_true(true, held.unit),
        apart,
    ]


def format_true(value: float | None, unit: str) -> str:
    """Return a true value as text."""
    return ABSENT if finite(value) is None else format_estimate(value, None, unit)


def updates_table(episode: Episode) -> Html:
    """Return the table of all updates."""
    head = ("after, s", "to go, m", "wheel at, m", "drag, N·s/m", "mass, kg")
    return table(head, [update_row(episode, each) for each in episode.updates], "stacked")


def update_row(episode: Episode, update: Update) -> list[Child]:
    """Return the row of an update, with changes of the model below its time."""
    index = int(np.searchsorted(episode.t, update.time - 1e-9))
    changed = changes_text(update)
    return [
        [format_fixed(update.time, 2), tag("span", changed, class_="unit") if changed else None],
        format_fixed(float(episode.distance[index]), 2),
        stacked([update.value(f"viscous_wheel.{axis}") for axis in "xy"]),
        stacked([update.value(name) for name in ("least", "most")]),
        stacked([update.value("body.mass")]),
    ]


def stacked(values: Sequence[Estimate | None]) -> list[Child]:
    """Return numbers below each other."""
    return [
        tag("div", ABSENT if each is None else format_parameter({"mean": each.mean, "sd": each.sd}))
        for each in values
    ]


def changes_text(update: Update) -> str:
    """Return the effects that the diagnoser added, and the new grasp."""
    found = [wording.effect_names(update.named)] if update.named else []
    found += [f"supposed: {wording.effect_names(update.supposed)}"] if update.supposed else []
    found += [f"new grasp at {format_point(update.regrasp)}"] if update.regrasp is not None else []
    return ", ".join(found).replace(GAP, " ")
