"""Marks of the estimated and the true wheel on a map, and the top view of the object after a fit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trundle.experiments.runs.history import Effect, Episode, Update
from trundle.experiments.runs.sentences import format_seconds
from trundle.report.figures import wheels
from trundle.report.figures.canvas import WIDTH, Figure, figure
from trundle.report.figures.data import Data
from trundle.report.figures.ellipse import LENS_RADIUS, LENS_ZOOM, ellipse, ellipse_axes, lens
from trundle.report.figures.marks import plus
from trundle.report.figures.top_view import TopView
from trundle.report.quantity import format_point, format_quantity
from trundle.report.series import Array
from trundle.report.svg import Child, Markup, tag

__all__ = ["draw", "estimate_marks", "true_marks"]

MAX_MAGNIFIED_AXIS = 14.0
"""Largest half axis of an ellipse, user units, that is magnified."""


def draw(identity: str, episode: Episode, update: Update) -> Figure:
    """Return the top view of the object with the belief after a fit."""
    view = TopView.around([*episode.outline, episode.support])
    size = {"width": WIDTH, "height": view.height}
    content: Child = [
        [view.outline(corners, "footprint") for corners in episode.outline],
        [tag("circle", cx=x, cy=y, r=6.0, class_="support") for x, y in view.to_page(episode.support)],
        true_marks(view, episode),
        estimate_marks(view, update),
        magnifier(identity, view, episode, update),
    ]
    inner = tag("svg", content, viewBox=f"0 0 {WIDTH:.0f} {view.height:.2f}", **size)
    place = "no wheel" if update.wheel is None else format_point(update.wheel.at, update.wheel_sd)
    after = format_seconds(update.time)
    text = f"Top view of the object, object frame; estimated wheel: {place}."
    drawing = [inner, tag("rect", class_="box", **size)]
    caption = after, accuracy_text(episode, update)
    data = Data(("mark", "x, m", "y, m", "sd of x, m", "sd of y, m"), mark_rows(episode, update))
    return figure(identity, f"Belief after {after}", text, view.height, drawing, caption, data=data)


def mark_rows(episode: Episode, update: Update) -> list[tuple[str | float | None, ...]]:
    """Return the estimated and the true wheel, and the other effects with a position."""
    rows: list[tuple[str | float | None, ...]] = []
    if update.wheel is not None:
        sd = (None, None) if update.wheel_sd is None else update.wheel_sd.tolist()
        rows.append(("estimated wheel", *update.wheel.at.tolist(), *sd))
    if episode.wheel is not None:
        rows.append(("true wheel", *episode.wheel.at.tolist(), None, None))
    for kind, effects in (("estimated", update.other_effects), ("true", episode.hidden)):
        rows += [
            (f"{kind} {each.name}", *map(float, each.at), None, None)
            for each in effects
            if each.at is not None
        ]
    return rows


def estimate_marks(view: TopView, update: Update | None, reach: float = 2.0 * WIDTH) -> list[Markup]:
    """Return the estimated wheel with its 95 % ellipse, and a diagonal cross for each other effect."""
    if update is None:
        return []
    drawn: list[Markup] = []
    if update.wheel is not None:
        at, covariance = update.wheel.at, update.wheel_covariance
        drawn += [] if covariance is None else [ellipse(view, at, covariance, reach, "credible")]
        drawn.append(plus(view, at, "estimate"))
    for x, y in effect_points(view, update.other_effects):
        arms = f"M{x - 5:.1f} {y - 5:.1f}l10 10M{x - 5:.1f} {y + 5:.1f}l10 -10"
        drawn.append(tag("path", d=arms, class_="mark"))
    return drawn


def true_marks(view: TopView, episode: Episode) -> list[Markup | None]:
    """Return the true wheel, and a ring for each other hidden effect."""
    points = effect_points(view, episode.hidden)
    drawn: list[Markup | None] = [tag("circle", cx=x, cy=y, r=8.0, class_="mark hollow") for x, y in points]
    if episode.wheel is not None:
        drawn.append(wheels.draw(view, wheels.Wheel(episode.wheel.at, episode.wheel.angle), "true-wheel"))
    return drawn


def effect_points(view: TopView, effects: Sequence[Effect]) -> Array:
    """Return the positions (n, 2) of the effects that have one, in user units."""
    return view.to_page(np.array([each.at for each in effects if each.at is not None]).reshape(-1, 2))


def magnifier(identity: str, view: TopView, episode: Episode, update: Update) -> Child:
    """Return a lens over the true wheel; None if the ellipse is large enough to see."""
    covariance, error = update.wheel_covariance, episode.wheel_error(update)
    if episode.wheel is None or error is None or covariance is None:
        return None
    is_small = ellipse_axes(covariance, view.scale, WIDTH)[0] <= MAX_MAGNIFIED_AXIS
    if not is_small or error * view.scale * LENS_ZOOM > LENS_RADIUS:
        return None
    return lens(
        identity,
        view,
        episode.wheel.at,
        lambda zoomed: [true_marks(zoomed, episode), estimate_marks(zoomed, update)],
    )


def accuracy_text(episode: Episode, update: Update) -> str:
    """Return the accuracy of the wheel's position as text."""
    sd, error = update.wheel_sd, episode.wheel_error(update)
    if update.wheel is None:
        return ": no wheel in the model"
    if sd is not None and not np.isfinite(sd).all():
        return ": known along one axis" if np.isfinite(sd).any() else ": not identifiable yet"
    known = "" if sd is None else f", sd {format_quantity('m', float(sd.max()))}"
    return known if error is None else f": {format_quantity('m', error)} off{known}"
