"""Map of the floor: recorded paths, and the locations in the world that the diagnosis gives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from trundle.picture import place_outline
from trundle.report.figures import marks, missing_force
from trundle.report.figures.canvas import WIDTH, Caption, Figure, figure
from trundle.report.figures.data import Data
from trundle.report.figures.motion import pose_at_event
from trundle.report.figures.top_view import TopView
from trundle.report.location import Event, Place, locate_effects, polygon
from trundle.report.quantity import format_significant
from trundle.report.series import Array, Episode, Series
from trundle.report.svg import Markup

__all__ = ["draw"]

_MAX_PATH_POINTS = 60
"""About the largest number of points of each path in the data."""


def draw(diagnosis: Mapping[str, Any], series: Series) -> Figure | None:
    """Return the map; None if there is nothing to mark on the floor, and on a rail."""
    named = [place for place in locate_effects(diagnosis.get("missing") or ()) if place.on_floor]
    is_unexplained = diagnosis.get("verdict") == "unexplained"
    hint = polygon((diagnosis.get("mismatch") or {}).get("world_region")) if is_unexplained else None
    drawn = [episode for episode in series.episodes if _is_drawable(episode)]
    if "theta" not in series.dof or not drawn or not (named or is_unexplained):
        return None
    moments = [(place, found) for place in named if (found := _event_pose(place.event, drawn)) is not None]
    ghosts = [place_outline(shape, pose) for _, pose in moments for shape in series.footprint]
    view = TopView.around([*(episode.observed[:, :2] for episode in drawn), *ghosts, *_corners(named, hint)])
    arrows, longest = missing_force.arrows(view, drawn) if is_unexplained else ([], 0.0)
    drawing = view.with_frame(
        [view.outline(corners, "region") for corners in _regions(named, hint)],
        [view.path(episode.observed[:, :2], _style(episode, named)) for episode in drawn],
        arrows,
        [view.outline(ghost, "ghost") for ghost in ghosts],
        [marks.ring(view, pose[:2]) for _, pose in moments],
        [marks.cross(view, place.world) for place in named if place.world is not None],
        [_direction(view, place) for place in named],
        marks.numbers(view, _numbered(view, named, moments)),
    )
    caption = _caption(named, hint, longest, bool(moments))
    text = f"Recorded paths of all episodes in the world frame. {' '.join(_sentences(named, hint, longest))}"
    title, data = "Top view of the floor", _data(drawn, named, hint)
    return figure("floor", title, text, view.total_height, drawing, *caption, data=data)


def _data(drawn: Sequence[Episode], named: Sequence[Place], hint: Array | None) -> Data:
    """Return the corners of marked regions, marked points, and evenly spaced points of every path."""
    rows: list[tuple[str | float | None, ...]] = [
        ("corner of a region", None, x, y) for corners in _regions(named, hint) for x, y in corners.tolist()
    ]
    rows += [(each.name, None, *each.world.mean.tolist()) for each in named if each.world is not None]
    for episode in drawn:
        few = slice(None, None, max(1, len(episode.t) // _MAX_PATH_POINTS))
        path = np.column_stack([episode.t, episode.observed[:, :2]])[few].tolist()
        rows += [(episode.name, *point) for point in path]
    return Data(("mark or episode", "time, s", "x, m", "y, m"), rows)


def _event_pose(event: Event | None, episodes: Sequence[Episode]) -> Array | None:
    found = (pose_at_event(event, episode) for episode in episodes)
    return next((pose for pose in found if pose is not None), None)


def _is_drawable(episode: Episode) -> bool:
    return int(np.isfinite(episode.observed).all(axis=1).sum()) > 1


def _style(episode: Episode, named: Sequence[Place]) -> str:
    """Return the style of a path; the path of an episode with an event is emphasised."""
    inside = any(place.event is not None and place.event.episode == episode.name for place in named)
    return "trace strong" if inside else "trace"


def _corners(named: Sequence[Place], hint: Array | None) -> list[Array]:
    worlds = [place.world.mean[None] for place in named if place.world is not None]
    return [*worlds, *_regions(named, hint)]


def _regions(named: Sequence[Place], hint: Array | None) -> list[Array]:
    return [corners for corners in (*(place.region for place in named), hint) if corners is not None]


def _direction(view: TopView, place: Place) -> Markup | None:
    if place.direction is None:
        return None
    middle, half = np.array([WIDTH / 2.0, view.height / 2.0]), 0.36 * view.height
    reach = half * place.direction.along * np.array([1.0, -1.0])
    return marks.arrow(middle - reach, middle + reach, "mark", head=13.0, both=place.direction.both)


def _numbered(
    view: TopView, named: Sequence[Place], moments: Sequence[tuple[Place, Array]]
) -> list[tuple[int, Array, float]]:
    found = [
        (place.number, place.world.mean, float(marks.WITHIN_95 * place.world.sd[0] * view.scale))
        for place in named
        if place.world is not None
    ]
    found += [(place.number, place.region.mean(axis=0), 0.0) for place in named if place.region is not None]
    found += [(place.number, pose[:2], 0.0) for place, pose in moments]
    return found + [(place.number, view.centre, 0.0) for place in named if place.direction is not None]


def _sentences(named: Sequence[Place], hint: Array | None, longest: float) -> list[str]:
    found = [f"{place.number}, {place.name}: {' '.join(place.sentences())}" for place in named]
    if hint is not None:
        found.append("Shaded: the region where the missing wrench acts.")
    if longest > 0.0:
        size = f"{format_significant(longest, 2)}\N{NO-BREAK SPACE}N"
        found.append(f"Arrows: the missing force where it exceeds the noise, at most {size}.")
    return found


def _caption(named: Sequence[Place], hint: Array | None, longest: float, rings: bool) -> list[Caption]:
    lines = [(f"{place.number} ", f"{place.name}. {_direction_sentence(place)}") for place in named]
    rest = [*_sentences((), hint, longest), "World frame. Lines: recorded paths."]
    rest += ["Rings: position at the event."] if rings else []
    return [*lines, ("", " ".join(rest))]


def _direction_sentence(place: Place) -> str:
    return "" if place.direction is None else f"{place.direction.text}. "
