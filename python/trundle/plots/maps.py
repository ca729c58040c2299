"""Maps of a diagnosis: the object and the floor, with the places of the missing effects."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from trundle import palette
from trundle._optional import require
from trundle.picture import place_outline
from trundle.plots import top_view
from trundle.plots.style import legend
from trundle.report.figures.marks import WITHIN_95
from trundle.report.figures.motion import pose_at_event
from trundle.report.figures.object_map import hint_point
from trundle.report.figures.wheels import Wheel, known_wheels
from trundle.report.location import Place, Point, locate_effects, polygon
from trundle.report.series import Array, Series

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw_floor", "draw_object", "has_floor_marks", "has_object_marks"]

_NUMBER_OFFSETS = ((7, 5), (-15, 5), (7, -14), (-15, -14))
"""Places of numbers relative to their marks, points, so that those of nearby marks do not overlap."""


def draw_object(axes: Axes, answer: Mapping[str, Any], series: Series) -> None:
    """Draw the object in its own frame with wheels, support points and located effects."""
    named = [(place, place.body) for place in locate_effects(answer.get("missing") or ()) if place.body]
    hint, corners = hint_point(answer), np.concatenate(series.footprint)
    size = float(np.ptp(corners, axis=0).max())
    top_view.draw_outlines(axes, series.footprint, np.zeros(3), palette.INK, fill=palette.SOFT)
    for feet in series.feet:
        style: dict[str, Any] = {
            "marker": "o",
            "markersize": 6,
            "markerfacecolor": palette.PAPER,
            "linestyle": "none",
        }
        axes.plot(feet[:, 0], feet[:, 1], color=palette.MUTED, label="support points", **style)
    wheels = [
        wheel for wheel in known_wheels(answer.get("nominal") or {}) if _is_near(wheel.position, corners)
    ]
    for wheel in wheels:
        _draw_wheel(axes, wheel, 0.09 * size)
    if wheels:
        axes.plot([], [], color=palette.INK, linewidth=4, label="fitted wheel")
    spots = [point.mean for _, point in named] + ([] if hint is None else [hint])
    _draw_points(axes, named)
    if hint is not None:
        _draw_hint(axes, hint)
    inside = [spot[None] for spot in spots if _is_near(spot, corners)]
    top_view.finish(axes, "object", [corners, *series.feet, *inside, *(w.position[None] for w in wheels)])
    axes.set_title("object from above", loc="left", fontsize=9)
    _legend_below(axes, 2)


def _draw_hint(axes: Axes, at: Array) -> None:
    """Mark a location that belongs to no named effect."""
    style: dict[str, Any] = {"markersize": 9, "markerfacecolor": "none", "markeredgewidth": 1.8}
    axes.plot(*at, "D", color=palette.MARK, label="where the residual acts", **style)


def _is_near(spot: Array, corners: Array) -> bool:
    """Return whether a point is within twice the size of the object from its centre."""
    reach = 2.0 * float(np.ptp(corners, axis=0).max())
    return bool(np.abs(spot - corners.mean(axis=0)).max() < reach)


def _draw_wheel(axes: Axes, wheel: Wheel, length: float) -> None:
    """Draw a wheel; its long side is the rolling direction."""
    half = 0.5 * np.array([length, 0.4 * length])
    corners = half * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    pose = np.array([*wheel.position, wheel.angle])
    top_view.draw_outlines(axes, [corners], pose, palette.INK, fill=palette.MUTED)


def _draw_points(axes: Axes, named: Sequence[tuple[Place, Point]]) -> None:
    """Mark points with crosses, 95 % ellipses and the numbers and names of their effects."""
    patches = require("matplotlib.patches", "plots", "plots")
    for place, point in named:
        if np.isfinite(point.sd).all():
            width, height = 2.0 * WITHIN_95 * point.sd
            axes.add_patch(
                patches.Ellipse(tuple(point.mean), width, height, color=palette.MARK, alpha=0.25, linewidth=0)
            )
        label = f"{place.number}: {place.name}"
        style: dict[str, Any] = {"marker": "+", "markersize": 13, "markeredgewidth": 2.0, "linestyle": "none"}
        axes.plot(*point.mean, color=palette.MARK, label=label, **style)
        _number(axes, place.number, point.mean)


def _legend_below(axes: Axes, columns: int) -> None:
    """Add a legend below the label of the x axis."""
    below: dict[str, Any] = {"loc": "upper center", "bbox_to_anchor": (0.5, 0.0), "borderaxespad": 5.0}
    legend(axes, 7.5, ncols=columns, **below)


def _number(axes: Axes, number: int, at: Array) -> None:
    offset = _NUMBER_OFFSETS[(number - 1) % len(_NUMBER_OFFSETS)]
    style: dict[str, Any] = {
        "textcoords": "offset points",
        "color": palette.MARK,
        "fontsize": 11,
        "weight": "bold",
    }
    axes.annotate(str(number), tuple(at), offset, **style)


def has_object_marks(answer: Mapping[str, Any]) -> bool:
    """Return whether the diagnosis locates an effect or the residual on the object."""
    named = locate_effects(answer.get("missing") or ())
    return hint_point(answer) is not None or any(place.body is not None for place in named)


def has_floor_marks(answer: Mapping[str, Any], series: Series) -> bool:
    """Return whether the diagnosis locates an effect on the floor."""
    named = locate_effects(answer.get("missing") or ())
    seen = any(np.isfinite(each.observed).all(axis=1).sum() > 1 for each in series.episodes)
    on_floor = any(place.on_floor for place in named) or _hint_region(answer) is not None
    return "theta" in series.dof and seen and on_floor


def _hint_region(answer: Mapping[str, Any]) -> Array | None:
    unexplained = answer.get("verdict") == "unexplained"
    return polygon((answer.get("mismatch") or {}).get("world_region")) if unexplained else None


def draw_floor(axes: Axes, answer: Mapping[str, Any], series: Series) -> None:
    """Draw the recorded paths in the world, and effects with a place, a region, a direction or an event."""
    around: list[Array] = []
    for episode in series.episodes:
        label = "recorded paths" if not around else "_"
        top_view.draw_path(axes, episode.observed, palette.RECORDED, linewidth=1.2, label=label)
        around.append(episode.observed[:, :2])
    named = [place for place in locate_effects(answer.get("missing") or ()) if place.on_floor]
    _draw_points(axes, [(place, place.world) for place in named if place.world is not None])
    around += [place.world.mean[None] for place in named if place.world is not None]
    hint = _hint_region(answer)
    regions = [(f"{place.number}: {place.name}", place.region) for place in named if place.region is not None]
    for label, region in [*regions, *([] if hint is None else [("where the residual acts", hint)])]:
        style: dict[str, Any] = {"facecolor": palette.MARK, "alpha": 0.18, "linewidth": 0}
        axes.fill(region[:, 0], region[:, 1], label=label, **style)
        around.append(region)
    for place in named:
        around += _draw_event(axes, place, series)
        _draw_direction(axes, place)
    top_view.finish(axes, "world", around)
    axes.set_title("floor from above", loc="left", fontsize=9)
    _legend_below(axes, 1)


def _draw_event(axes: Axes, place: Place, series: Series) -> list[Array]:
    """Mark the recorded pose at an event, and return the points of its outline."""
    found = (pose_at_event(place.event, episode) for episode in series.episodes)
    pose = next((each for each in found if each is not None), None)
    if pose is None:
        return []
    top_view.draw_outlines(axes, series.footprint, pose, palette.MARK, "--")
    style: dict[str, Any] = {
        "marker": "o",
        "markersize": 9,
        "markerfacecolor": "none",
        "markeredgewidth": 1.8,
    }
    label = f"{place.number}: {place.name}"
    axes.plot(*pose[:2], color=palette.MARK, linestyle="none", label=label, **style)
    _number(axes, place.number, pose[:2])
    return [place_outline(shape, pose) for shape in series.footprint]


def _draw_direction(axes: Axes, place: Place) -> None:
    """Draw the direction of an effect through the middle of the map."""
    if place.direction is None:
        return
    half = 0.3 * place.direction.along
    style: dict[str, Any] = {
        "arrowstyle": "<->" if place.direction.both else "->",
        "color": palette.MARK,
        "linewidth": 2.2,
    }
    tail, head = (tuple(0.5 + sign * half) for sign in (-1.0, 1.0))
    axes.annotate(
        "", xy=head, xytext=tail, xycoords="axes fraction", textcoords="axes fraction", arrowprops=style
    )
    axes.plot([], [], color=palette.MARK, linewidth=2.2, label=f"{place.number}: {place.direction.text}")
