"""Top view of the object with the estimated wheel after a fit, in the object's frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trundle.experiments.runs.figures.marks import box, cross, effect_marks, ellipse, ellipse_axes
from trundle.experiments.runs.history import Episode, Update
from trundle.experiments.runs.sentences import format_point, format_seconds, place_sd
from trundle.report.figures.canvas import WIDTH, figure
from trundle.report.figures.top_view import TopView
from trundle.report.markup import Child, Html, tag
from trundle.report.quantity import format_quantity, join_words
from trundle.report.series import Array

__all__ = ["draw", "legend"]

LENS_RADIUS, LENS_ZOOM = 74.0, 10.0
"""Radius of the magnified circle, user units, and its magnification."""
MAX_MAGNIFIED_AXIS = 14.0
"""Largest half axis of an ellipse, user units, that is magnified."""


def draw(identity: str, episode: Episode, update: Update) -> Html:
    """Return the belief after one fit."""
    plan = TopView.around([*episode.outline, episode.support])
    view = View(plan, np.zeros(2), 1.0)
    size = {"width": WIDTH, "height": plan.height}
    inner = tag(
        "svg",
        [plan.outline(corners, "footprint") for corners in episode.outline],
        [tag("circle", cx=x, cy=y, r=6.0, class_="support") for x, y in plan.to_page(episode.support)],
        effect_marks(update.other_effects, episode.hidden, view.at),
        view.wheel(episode, update),
        magnifier(identity, plan, episode, update),
        viewBox=f"0 0 {WIDTH:.0f} {plan.height:.2f}",
        **size,
    )
    place = "no wheel" if update.wheel is None else format_point(update.wheel.at, place_sd(update))
    text = f"Top view of the object, object frame; estimated wheel: {place}."
    caption = [tag("b", format_seconds(update.time)), accuracy_text(episode, update)]
    title = f"Belief after {format_seconds(update.time)}"
    return figure(identity, title, text, plan.height, [inner, tag("rect", class_="box", **size)], caption)


def accuracy_text(episode: Episode, update: Update) -> str:
    """Return the accuracy of the wheel's position as text."""
    sd, off = place_sd(update), episode.off(update)
    if update.wheel is None:
        return ": no wheel in the model"
    if sd is not None and not np.isfinite(sd).all():
        return ": known along one axis" if np.isfinite(sd).any() else ": not identifiable yet"
    known = "" if sd is None else f", sd {format_quantity('m', float(sd.max()))}"
    return known if off is None else f": {format_quantity('m', off)} off{known}"


def legend(episode: Episode) -> str:
    """Return the legend of the other marks, if there are any."""
    placed = [each.name for each in episode.hidden if each.at is not None]
    believed = {
        each.name for update in episode.updates for each in update.other_effects if each.at is not None
    }
    if not placed and not believed:
        return ""
    names = join_words(list(dict.fromkeys([*placed, *sorted(believed)])))
    return f" Ring: true position of {names}; diagonal cross: estimated position."


@dataclass(frozen=True)
class View:
    """The map, or a view of it magnified by `zoom` about a point (2,) m."""

    plan: TopView
    about: Array
    zoom: float

    def at(self, point: Array) -> Array:
        """Return a point (2,) m in user units."""
        about, place = self.plan.to_page(np.array([self.about, point]))
        seen: Array = about + self.zoom * (place - about)
        return seen

    def wheel(self, episode: Episode, update: Update) -> list[Child]:
        """Return the estimated and the true wheel."""
        true, found = episode.wheel, update.wheel
        drawn: list[Child] = [] if true is None else [box(self.at(true.at), true.angle)]
        if found is not None:
            shape = ellipse_axes(update.wheel_covariance, self.zoom * self.plan.scale, 2.0 * WIDTH)
            at = self.at(found.at)
            drawn = [None if shape is None else ellipse(at, shape), *drawn, cross(at)]
        return drawn


def magnifier(identity: str, plan: TopView, episode: Episode, update: Update) -> Child:
    """Return a magnified circle around the true wheel, if the ellipse is too small to see."""
    true, off, shape = (
        episode.wheel,
        episode.off(update),
        ellipse_axes(update.wheel_covariance, plan.scale, WIDTH),
    )
    if true is None or off is None or shape is None:
        return None
    if shape[0] > MAX_MAGNIFIED_AXIS or off * plan.scale * LENS_ZOOM > LENS_RADIUS:
        return None
    wheel = plan.to_page(true.at[None])[0]
    middle = lens_centre(wheel, np.array([WIDTH, plan.height]))
    glass = View(plan, true.at, LENS_ZOOM)
    shift = middle - wheel
    round_ = {"cx": middle[0], "cy": middle[1], "r": LENS_RADIUS}
    seen = tag("g", glass.wheel(episode, update), transform=f"translate({shift[0]:.2f} {shift[1]:.2f})")
    return [
        tag("line", x1=wheel[0], y1=wheel[1], x2=middle[0], y2=middle[1], class_="axis"),
        tag("clipPath", tag("circle", **round_), id=f"{identity}-lens"),
        tag("circle", class_="lens", **round_),
        tag("g", seen, clip_path=f"url(#{identity}-lens)"),
        tag("circle", class_="rim", **round_),
    ]


def lens_centre(wheel: Array, size: Array) -> Array:
    """Return the centre of a magnified circle that does not cover a wheel (2,), within a panel (2,)."""
    toward = size / 2.0 - wheel
    length = float(np.hypot(*toward))
    way = toward / length if length > 1.0 else np.array([1.0, 0.0])
    middle: Array = np.clip(wheel + 1.5 * LENS_RADIUS * way, LENS_RADIUS + 4.0, size - LENS_RADIUS - 4.0)
    return middle
