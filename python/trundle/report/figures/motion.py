"""Recorded and simulated motion of one episode: from above, or in time on a rail, and the error in time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trundle.report.figures import lanes, marks
from trundle.report.figures.canvas import figure, label
from trundle.report.figures.lanes import Curve, Lane, Marks
from trundle.report.figures.plan import Plan, placed
from trundle.report.given import Array, Episode, Series
from trundle.report.markup import Child, Html, join, tag
from trundle.report.quantity import Scale, shown, suited
from trundle.report.where import Event, Place

__all__ = ["draw", "events_in", "moment", "poses_at"]

_SIDES = ("before", "after")
_MAP = 250.0


def draw(index: int, episode: Episode, series: Series, named: Sequence[Place]) -> Html:
    """Return the panel of one episode; `index` makes its name in the page."""
    rail = "theta" not in series.dof
    plan = None if rail else _plan(episode, series, named)
    top = 0.0 if plan is None else plan.total
    rows = [_position(episode)] if rail else []
    span = (float(episode.t[0]), float(episode.t[-1]))
    graph, height = lanes.draw(rows + _errors(episode, rail), span, Marks(events=events_in(episode, named)))
    view = None if plan is None else _view(plan, episode, series, named)
    drawing = join([view, tag("g", graph, transform=f"translate(0 {top:.2f})")])
    kind = "held out" if episode.held_out else "fitted"
    seen = "Position in time" if rail else "Path from above with the outline at start and end"
    text = f"{seen}, recorded and simulated; below it the error in time. {_ends(episode)}"
    caption = [tag("b", episode.name), f" ({kind}). ", _ends(episode)]
    return figure(
        f"motion-{index}", f"Motion in {episode.name}, {kind}", text, top + height, drawing, caption
    )


def events_in(episode: Episode, named: Sequence[Place]) -> list[tuple[float, str]]:
    """Return the events that the diagnosis puts into an episode: time s and number."""
    events = [(place.event, str(place.number)) for place in named if place.event is not None]
    return [(event.time, number) for event, number in events if event.episode == episode.name]


def moment(event: Event | None, episode: Episode) -> Array | None:
    """Return the recorded pose (3,) at an event in this episode, linear between samples."""
    if event is None or event.episode != episode.name:
        return None
    pose = poses_at(np.array([event.time]), episode)[0]
    return pose if np.isfinite(pose).all() else None


def poses_at(t: Array, episode: Episode) -> Array:
    """Return the recorded poses (n, 3) at some times (n,), linear between samples, or NaN."""
    seen = np.isfinite(episode.observed).all(axis=1) & np.isfinite(episode.t)
    if not seen.any():
        return np.full((len(t), 3), np.nan)
    x, y, theta = episode.observed[seen].T
    return np.column_stack([np.interp(t, episode.t[seen], column) for column in (x, y, np.unwrap(theta))])


def _simulated(episode: Episode) -> list[tuple[str, Array]]:
    return [(side, curve) for side in _SIDES if (curve := getattr(episode, side)) is not None]


def _plan(episode: Episode, series: Series, named: Sequence[Place]) -> Plan:
    """Return a map of the recorded motion, stretched somewhat for simulations and places that leave it."""
    shapes = [placed(polygon, pose) for pose in _ends_of(episode.observed) for polygon in series.footprint]
    recorded = np.concatenate([episode.observed[:, :2], *shapes])
    recorded = recorded[np.isfinite(recorded).all(axis=1)]
    if not len(recorded):
        return Plan.around([], _MAP)
    low, high = recorded.min(axis=0), recorded.max(axis=0)
    reach = float((high - low).max()) * 0.6
    others = [curve[:, :2] for _, curve in _simulated(episode)]
    others += [
        placed(polygon, _ends_of(curve)[-1])
        for _, curve in _simulated(episode)
        for polygon in series.footprint
    ]
    others += [place.world.mean[None] for place in named if place.world is not None]
    return Plan.around([recorded, *(np.clip(other, low - reach, high + reach) for other in others)], _MAP)


def _ends_of(poses: Array) -> Array:
    """Return the first and the last pose that are known, (2, 3) or (0, 3)."""
    seen = poses[np.isfinite(poses).all(axis=1)]
    return seen[[0, -1]] if len(seen) else seen


def _view(plan: Plan, episode: Episode, series: Series, named: Sequence[Place]) -> list[Child]:
    ends = _ends_of(episode.observed)
    start, stop = ends[:1], ends[1:]
    return plan.framed(
        [plan.outline(place.region, "region") for place in named if place.region is not None],
        [plan.outline(placed(shape, pose), "start") for pose in start for shape in series.footprint],
        [plan.outline(placed(shape, pose), "stop") for pose in stop for shape in series.footprint],
        plan.path(episode.observed[:, :2], "recorded"),
        [
            [
                plan.outline(placed(shape, pose), f"{side} thin")
                for pose in _ends_of(curve)[1:]
                for shape in series.footprint
            ]
            for side, curve in _simulated(episode)
        ],
        [plan.path(curve[:, :2], side) for side, curve in _simulated(episode)],
        [marks.cross(plan, place.world) for place in named if place.world is not None],
        [_start(plan, pose) for pose in start],
        _events(plan, episode, named),
    )


def _start(plan: Plan, pose: Array) -> Html:
    x, y = plan.at(pose[None, :2])[0]
    return join(
        [tag("circle", cx=x, cy=y, r=3.5, class_="dot"), label("start", x, y - 8.0, "tick halo", "middle")]
    )


def _events(plan: Plan, episode: Episode, named: Sequence[Place]) -> list[Child]:
    """Return rings where the object was when something changed, with the number of the effect."""
    found = [(place.number, moment(place.event, episode)) for place in named]
    rings = [(number, pose[:2]) for number, pose in found if pose is not None]
    return [
        [marks.ring(plan, spot) for _, spot in rings],
        marks.numbers(plan, [(number, spot, 0.0) for number, spot in rings]),
    ]


def _position(episode: Episode) -> Lane:
    scale = suited("m", *episode.observed[:, 0])
    curves = [Curve("recorded", episode.t, episode.observed[:, 0] * scale.factor)]
    curves += [Curve(side, episode.t, curve[:, 0] * scale.factor) for side, curve in _simulated(episode)]
    return Lane(f"position, {scale.unit}", tuple(curves), height=96.0)


def _errors(episode: Episode, rail: bool) -> list[Lane]:
    pairs = [(side, *_misfit(episode, curve, rail)) for side, curve in _simulated(episode)]
    distance = suited("m", *(_peak(gap) for _, gap, _ in pairs))
    rows = [
        _error_lane(
            f"position error, {distance.unit}", episode.t, distance, [(s, gap) for s, gap, _ in pairs]
        )
    ]
    if not rail:
        degrees = suited("rad", 1.0)
        rows.append(_error_lane("heading error, °", episode.t, degrees, [(s, turn) for s, _, turn in pairs]))
    return rows


def _error_lane(title: str, t: Array, scale: Scale, misfits: Sequence[tuple[str, Array]]) -> Lane:
    curves = tuple(Curve(side, t, values * scale.factor) for side, values in misfits)
    low, high = lanes.bounds([*curves, Curve("", t[:1], np.zeros(1))])
    return Lane(title, curves, (low if low < -0.1 * high else 0.0, high))


def _misfit(episode: Episode, curve: Array, rail: bool) -> tuple[Array, Array]:
    """Distance (signed on a rail) (n,) m and angle (n,) rad, 0 to pi, from the recorded pose."""
    gap = curve - episode.observed
    angle = np.abs(np.arctan2(np.sin(gap[:, 2]), np.cos(gap[:, 2])))
    return gap[:, 0] if rail else np.hypot(gap[:, 0], gap[:, 1]), angle


def _peak(values: Array) -> float:
    seen = values[np.isfinite(values)]
    return float(np.abs(seen).max()) if len(seen) else 0.0


def _ends(episode: Episode) -> str:
    """Return the error at the end in words."""
    found = []
    for side, curve in _simulated(episode):
        gap = _misfit(episode, curve, rail=False)[0]
        seen = gap[np.isfinite(gap)]
        if len(seen):
            found.append((side, float(seen[-1])))
    if not found:
        return "No simulated motion."
    words = ", ".join(f"{shown('m', gap)}{f' {side}' if len(found) > 1 else ''}" for side, gap in found)
    return f"Off at the end by {words}."
