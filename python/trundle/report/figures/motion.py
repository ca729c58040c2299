"""Recorded and simulated motion of one episode: top view, or over time on a rail, and the error over time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trundle.picture import place_outline
from trundle.report.figures import lanes, marks
from trundle.report.figures.canvas import Figure, figure, label
from trundle.report.figures.curves import Curve, Lane, Marks, bounds, table
from trundle.report.figures.data import Data
from trundle.report.figures.top_view import TopView
from trundle.report.location import Event, Place
from trundle.report.quantity import Scale, display_scale, format_quantity
from trundle.report.series import Array, Episode, Series, pose_error
from trundle.report.svg import Child, Markup, join, tag

__all__ = ["draw", "events_in", "interpolate_poses", "pose_at_event"]

_SIDES = ("before", "after")
_MAP_HEIGHT = 250.0


def draw(index: int, episode: Episode, series: Series, named: Sequence[Place]) -> Figure:
    """Return the panel of one episode; `index` makes its id unique in the page."""
    on_rail = "theta" not in series.dof
    view = None if on_rail else _plan(episode, series, named)
    top = 0.0 if view is None else view.total_height
    rows = ([_position(episode)] if on_rail else []) + _errors(episode, on_rail)
    span = (float(episode.t[0]), float(episode.t[-1]))
    graph, height = lanes.draw(rows, span, Marks(events=events_in(episode, named)))
    data, tracks = _data(episode, rows, on_rail)
    drawn_map = None if view is None else _map(view, episode, series, named, tracks)
    drawing = [drawn_map, tag("g", graph, transform=f"translate(0 {top:.2f})")]
    kind = "held out" if episode.held_out else "fitted"
    shown = "Position over time" if on_rail else "Top view of the path with the outline at start and end"
    text = f"{shown}, recorded and simulated. Below: error over time. {_final_error(episode)}"
    caption = episode.name, f" ({kind}). {_final_error(episode)}"
    title = f"Motion in {episode.name}, {kind}"
    return figure(f"motion-{index}", title, text, top + height, drawing, caption, data=data)


def _data(episode: Episode, rows: Sequence[Lane], on_rail: bool) -> tuple[Data, str]:
    """Return the data of an episode, and the columns of the points that the map marks at a time."""
    found = table(rows)
    if on_rail:
        return found.data(), ""
    tracks = []
    for side, poses in (("recorded", episode.observed), *_simulated(episode)):
        column = len(found.names) + 1
        tracks.append(f"{side}:{column}:{column + 1}")
        found = found.with_columns([f"{side} x, m", f"{side} y, m", f"{side} heading, rad"], poses)
    return found.data(), "|".join(tracks)


def events_in(episode: Episode, named: Sequence[Place]) -> list[tuple[float, str]]:
    """Return the events of the diagnosis in an episode: time, s, and number of the effect."""
    events = [(place.event, str(place.number)) for place in named if place.event is not None]
    return [(event.time, number) for event, number in events if event.episode == episode.name]


def pose_at_event(event: Event | None, episode: Episode) -> Array | None:
    """Return the recorded pose (3,) at an event, interpolated linearly; None for other episodes."""
    if event is None or event.episode != episode.name:
        return None
    pose = interpolate_poses(np.array([event.time]), episode)[0]
    return pose if np.isfinite(pose).all() else None


def interpolate_poses(t: Array, episode: Episode) -> Array:
    """Return the recorded poses (n, 3) at times (n,), interpolated linearly; NaN without any sample."""
    seen = np.isfinite(episode.observed).all(axis=1) & np.isfinite(episode.t)
    if not seen.any():
        return np.full((len(t), 3), np.nan)
    x, y, theta = episode.observed[seen].T
    return np.column_stack([np.interp(t, episode.t[seen], column) for column in (x, y, np.unwrap(theta))])


def _simulated(episode: Episode) -> list[tuple[str, Array]]:
    return [(side, curve) for side in _SIDES if (curve := getattr(episode, side)) is not None]


def _plan(episode: Episode, series: Series, named: Sequence[Place]) -> TopView:
    """Return a map of the recorded motion, enlarged up to a limit for simulations and points outside it."""
    shapes = [
        place_outline(polygon, pose)
        for pose in _first_and_last(episode.observed)
        for polygon in series.footprint
    ]
    recorded = np.concatenate([episode.observed[:, :2], *shapes])
    recorded = recorded[np.isfinite(recorded).all(axis=1)]
    if not len(recorded):
        return TopView.around([], _MAP_HEIGHT)
    low, high = recorded.min(axis=0), recorded.max(axis=0)
    reach = float((high - low).max()) * 0.6
    others = [curve[:, :2] for _, curve in _simulated(episode)]
    others += [
        place_outline(polygon, _first_and_last(curve)[-1])
        for _, curve in _simulated(episode)
        for polygon in series.footprint
    ]
    others += [place.world.mean[None] for place in named if place.world is not None]
    return TopView.around(
        [recorded, *(np.clip(other, low - reach, high + reach) for other in others)], _MAP_HEIGHT
    )


def _first_and_last(poses: Array) -> Array:
    """Return the first and the last finite pose, (2, 3) or (0, 3)."""
    seen = poses[np.isfinite(poses).all(axis=1)]
    return seen[[0, -1]] if len(seen) else seen


def _map(view: TopView, episode: Episode, series: Series, named: Sequence[Place], tracks: str) -> list[Child]:
    ends = _first_and_last(episode.observed)
    start, stop = ends[:1], ends[1:]
    return view.with_frame(
        [view.outline(place.region, "region") for place in named if place.region is not None],
        [view.outline(place_outline(shape, pose), "start") for pose in start for shape in series.footprint],
        [view.outline(place_outline(shape, pose), "stop") for pose in stop for shape in series.footprint],
        view.path(episode.observed[:, :2], "recorded"),
        [
            [
                view.outline(place_outline(shape, pose), f"{side} thin")
                for pose in _first_and_last(curve)[1:]
                for shape in series.footprint
            ]
            for side, curve in _simulated(episode)
        ],
        [view.path(curve[:, :2], side) for side, curve in _simulated(episode)],
        [marks.cross(view, place.world) for place in named if place.world is not None],
        [_start(view, pose) for pose in start],
        _events(view, episode, named),
        tracks=tracks,
    )


def _start(view: TopView, pose: Array) -> Markup:
    x, y = view.to_page(pose[None, :2])[0]
    return join(
        [tag("circle", cx=x, cy=y, r=3.5, class_="dot"), label("start", x, y - 8.0, "tick halo", "middle")]
    )


def _events(view: TopView, episode: Episode, named: Sequence[Place]) -> list[Child]:
    """Return rings at the recorded positions of events, with the numbers of the effects."""
    found = [(place.number, pose_at_event(place.event, episode)) for place in named]
    rings = [(number, pose[:2]) for number, pose in found if pose is not None]
    return [
        [marks.ring(view, point) for _, point in rings],
        marks.numbers(view, [(number, point, 0.0) for number, point in rings]),
    ]


def _position(episode: Episode) -> Lane:
    scale = display_scale("m", *episode.observed[:, 0])
    curves = [Curve("recorded", episode.t, episode.observed[:, 0] * scale.factor)]
    curves += [Curve(side, episode.t, curve[:, 0] * scale.factor) for side, curve in _simulated(episode)]
    return Lane(f"position, {scale.unit}", tuple(curves), height=96.0)


def _errors(episode: Episode, on_rail: bool) -> list[Lane]:
    pairs = [(side, *pose_error(episode, curve, on_rail)) for side, curve in _simulated(episode)]
    distance = display_scale("m", *(_peak(gap) for _, gap, _ in pairs))
    rows = [
        _error_lane(
            f"position error, {distance.unit}", episode.t, distance, [(s, gap) for s, gap, _ in pairs]
        )
    ]
    if not on_rail:
        degrees = display_scale("rad", 1.0)
        rows.append(_error_lane("heading error, °", episode.t, degrees, [(s, turn) for s, _, turn in pairs]))
    return rows


def _error_lane(title: str, t: Array, scale: Scale, misfits: Sequence[tuple[str, Array]]) -> Lane:
    curves = tuple(Curve(side, t, values * scale.factor) for side, values in misfits)
    low, high = bounds([*curves, Curve("", t[:1], np.zeros(1))])
    return Lane(title, curves, (low if low < -0.1 * high else 0.0, high))


def _peak(values: Array) -> float:
    seen = values[np.isfinite(values)]
    return float(np.abs(seen).max()) if len(seen) else 0.0


def _final_error(episode: Episode) -> str:
    """Return a sentence on the final position error."""
    found = []
    for side, curve in _simulated(episode):
        gap = pose_error(episode, curve, on_rail=False)[0]
        seen = gap[np.isfinite(gap)]
        if len(seen):
            found.append((side, float(seen[-1])))
    if not found:
        return "No simulated motion."
    sizes = ", ".join(
        f"{format_quantity('m', gap)}{f' {side}' if len(found) > 1 else ''}" for side, gap in found
    )
    return f"Final position error: {sizes}."
