"""The floor from above: the recorded paths, and the places in the world that the diagnosis names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from trundle.report.figures import lack, marks
from trundle.report.figures.canvas import WIDTH, figure
from trundle.report.figures.motion import moment
from trundle.report.figures.plan import Plan, placed
from trundle.report.given import Array, Episode, Series
from trundle.report.markup import Child, Html, tag
from trundle.report.quantity import significant
from trundle.report.where import Event, Place, places, region

__all__ = ["draw"]


def draw(diagnosis: Mapping[str, Any], series: Series) -> Html | None:
    """Return the map where there is something to mark on the floor; None otherwise and on a rail."""
    named = [place for place in places(diagnosis.get("missing") or ()) if place.on_floor]
    unnamed = diagnosis.get("verdict") == "unexplained"
    hint = region((diagnosis.get("mismatch") or {}).get("world_region")) if unnamed else None
    drawn = [episode for episode in series.episodes if _moves(episode)]
    if "theta" not in series.dof or not drawn or not (named or unnamed):
        return None
    moments = [(place, found) for place in named if (found := _moment(place.event, drawn)) is not None]
    ghosts = [placed(shape, pose) for _, pose in moments for shape in series.footprint]
    plan = Plan.around([*(episode.observed[:, :2] for episode in drawn), *ghosts, *_corners(named, hint)])
    arrows, longest = lack.arrows(plan, drawn) if unnamed else ([], 0.0)
    drawing = plan.framed(
        [plan.outline(corners, "region") for corners in _regions(named, hint)],
        [plan.path(episode.observed[:, :2], _style(episode, named)) for episode in drawn],
        arrows,
        [plan.outline(ghost, "ghost") for ghost in ghosts],
        [marks.ring(plan, pose[:2]) for _, pose in moments],
        [marks.cross(plan, place.world) for place in named if place.world is not None],
        [_direction(plan, place) for place in named],
        marks.numbers(plan, _numbered(plan, named, moments)),
    )
    caption = _caption(named, hint, longest, bool(moments))
    text = f"Recorded paths of all episodes in the world frame. {' '.join(_words(named, hint, longest))}"
    return figure("floor", "The floor from above", text, plan.total, drawing, caption)


def _moment(event: Event | None, episodes: Sequence[Episode]) -> Array | None:
    found = (moment(event, episode) for episode in episodes)
    return next((pose for pose in found if pose is not None), None)


def _moves(episode: Episode) -> bool:
    return int(np.isfinite(episode.observed).all(axis=1).sum()) > 1


def _style(episode: Episode, named: Sequence[Place]) -> str:
    """Return how a path is drawn: that of an event stands out."""
    inside = any(place.event is not None and place.event.episode == episode.name for place in named)
    return "trace strong" if inside else "trace"


def _corners(named: Sequence[Place], hint: Array | None) -> list[Array]:
    worlds = [place.world.mean[None] for place in named if place.world is not None]
    return [*worlds, *_regions(named, hint)]


def _regions(named: Sequence[Place], hint: Array | None) -> list[Array]:
    return [corners for corners in (*(place.region for place in named), hint) if corners is not None]


def _direction(plan: Plan, place: Place) -> Html | None:
    if place.direction is None:
        return None
    middle, half = np.array([WIDTH / 2.0, plan.height / 2.0]), 0.36 * plan.height
    reach = half * place.direction.along * np.array([1.0, -1.0])
    return marks.arrow(middle - reach, middle + reach, "mark", head=13.0, both=place.direction.both)


def _numbered(
    plan: Plan, named: Sequence[Place], moments: Sequence[tuple[Place, Array]]
) -> list[tuple[int, Array, float]]:
    found = [
        (place.number, place.world.mean, float(marks.WITHIN_95 * place.world.sd[0] * plan.scale))
        for place in named
        if place.world is not None
    ]
    found += [(place.number, place.region.mean(axis=0), 0.0) for place in named if place.region is not None]
    found += [(place.number, pose[:2], 0.0) for place, pose in moments]
    return found + [(place.number, plan.centre, 0.0) for place in named if place.direction is not None]


def _words(named: Sequence[Place], hint: Array | None, longest: float) -> list[str]:
    found = [f"{place.number}, {place.name}: {' '.join(place.sentences())}" for place in named]
    if hint is not None:
        found.append("Shaded: the region to which what is missing is tied.")
    if longest > 0.0:
        size = f"{significant(longest, 2)}\N{NO-BREAK SPACE}N"
        found.append(f"Arrows: the missing force where it is clear of noise, at most {size}.")
    return found


def _caption(named: Sequence[Place], hint: Array | None, longest: float, rings: bool) -> list[Child]:
    lines: list[Child] = [[tag("b", f"{place.number} "), f"{place.name}. ", _way(place)] for place in named]
    rest = [f"{sentence} " for sentence in _words((), hint, longest)]
    ghost = "; rings: where it was at that moment" if rings else ""
    return [lines, rest, f"From above, world frame; lines: the recorded paths{ghost}."]


def _way(place: Place) -> str | None:
    return None if place.direction is None else f"{place.direction.words}. "
