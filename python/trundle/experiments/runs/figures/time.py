"""Figures over time: estimates against true values, the accuracy of the wheel's position, and the push."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from trundle.experiments.runs.history import WHEEL, Episode
from trundle.report import wording
from trundle.report.figures.canvas import Figure
from trundle.report.figures.curves import Curve, Lane, Marks, bounds
from trundle.report.figures.ellipse import ellipse_axes
from trundle.report.figures.lanes import lane_figure
from trundle.report.quantity import key_to_words

__all__ = ["WHEEL_TITLES", "added", "beliefs", "estimate_title", "push"]

MIN_DISTANCE_M, MAX_DISTANCE_M = 1e-4, 1.0
"""Range of the distances that are drawn; an unknown position is drawn at the upper end."""
MIN_SPAN = 0.05
"""Smallest range of an axis, as a share of its largest value."""
CAPTION = "Line and band: estimate with two standard deviations, clipped to the frame. Dashes: true value."

WHEEL_TITLES = {
    f"{WHEEL}.x": "wheel, x",
    f"{WHEEL}.y": "wheel, y",
    "least": "least drag",
    "most": "most drag",
    "angle": "direction of least drag",
}
"""Titles of the wheel's estimates."""


def beliefs(identity: str, episode: Episode) -> list[Figure]:
    """Return the accuracy of the wheel's position, the position, and drag and mass over time."""
    place, rest = (f"{WHEEL}.x", f"{WHEEL}.y"), ("least", "most", "body.mass")
    found = (
        accuracy(identity, episode),
        estimates(f"{identity}-place", "The wheel's position over time", episode, place, height=98.0),
        estimates(f"{identity}-rest", "Drag and mass over time", episode, rest),
    )
    return [figure for figure in found if figure is not None]


def accuracy(identity: str, episode: Episode) -> Figure | None:
    """Return error and 95 % radius of the wheel's position; None without a true and an estimated wheel."""
    found = [
        (update.time, ellipse_axes(update.wheel_covariance, 1.0, MAX_DISTANCE_M)[0], error)
        for update in episode.updates
        if (error := episode.wheel_error(update)) is not None and update.wheel_covariance is not None
    ]
    if not found:
        return None
    t, radius, error = np.array(found).T
    radius, error = (np.log10(np.clip(values, MIN_DISTANCE_M, MAX_DISTANCE_M)) for values in (radius, error))
    limits = min(float(np.floor(min(radius.min(), error.min()))), -1.0), 0.0
    line = Curve("estimated", np.append(np.repeat(t, 2)[1:], episode.t[-1]), np.repeat(radius, 2))
    points = Curve("error", t, error, is_dotted=True)
    lane = Lane("distance from the true wheel", (line, points), limits, height=150.0, is_log_distance=True)
    caption = "Line: radius of the 95 % ellipse; points: error of the estimate."
    return draw(f"{identity}-closing", "Accuracy of the wheel's position", caption, [lane], episode)


def added(identity: str, episode: Episode) -> Figure | None:
    """Return estimates of added effects and of the body, except its mass, over time."""
    found = dict.fromkeys(name for update in episode.updates for name in update.estimates)
    names = [n for n in found if n not in (*WHEEL_TITLES, "body.mass") and not n.startswith(f"{WHEEL}.")]
    return estimates(f"{identity}-others", "Parameters of added effects over time", episode, names)


def estimate_title(name: str) -> str:
    """Return the title of an estimate."""
    kind, _, parameter = name.rpartition(".")
    words = key_to_words(parameter)
    return WHEEL_TITLES.get(name) or (words if kind == "body" else f"{wording.effect_name(kind)}, {words}")


def estimates(
    identity: str, title: str, episode: Episode, names: Iterable[str], height: float = 60.0
) -> Figure | None:
    """Return a lane for each estimate with a number; None without any."""
    found = [estimate_lane(episode, name, height) for name in names]
    rows = [lane for lane in found if lane is not None]
    if not rows:
        return None
    named = [(update.time, name) for update in episode.updates for name in update.named]
    notes = [f"{number}: {wording.effect_name(name)} added." for number, (_, name) in enumerate(named, 1)]
    marks = Marks(events=[(time, str(number)) for number, (time, _) in enumerate(named, 1)])
    return draw(identity, title, " ".join([CAPTION, *notes]), rows, episode, marks)


def estimate_lane(episode: Episode, name: str, height: float) -> Lane | None:
    """Return the lane of one number, constant between fits, with gaps where it is not identifiable."""
    none = {"mean": None, "sd": None, "unit": ""}
    found = [update.estimates.get(name, none) for update in episode.updates]
    mean, sd = (np.repeat(np.array([each[key] for each in found], float), 2) for key in ("mean", "sd"))
    if not np.isfinite(mean).any():
        return None
    end, true = episode.t[-1], episode.true_value(name)
    t = np.append(np.repeat([update.time for update in episode.updates], 2)[1:], end)
    band = Curve("interval", t, mean, 2.0 * np.nan_to_num(sd))
    real = [] if true is None else [Curve("true", np.array([0.0, end]), np.array([true, true]))]
    # The first estimate is often far off. It does not determine the limits.
    late = slice(2 if len(found) > 2 and np.isfinite(mean[2:]).any() else 0, None)
    low, high = bounds([Curve("interval", t[late], mean[late], 2.0 * np.nan_to_num(sd[late])), *real])
    widen = max(MIN_SPAN * max(abs(low), abs(high)) - (high - low), 0.0) / 2
    title = ", ".join(filter(None, [estimate_title(name), max(each["unit"] for each in found)]))
    return Lane(title, (band, *real, Curve("estimated", t, mean)), (low - widen, high + widen), height)


def push(identity: str, episode: Episode) -> list[Figure]:
    """Return the distance to the goal, and the wrench on the object, over time."""
    t, degrees = episode.t, np.abs(np.degrees(episode.heading_error))
    way = [
        Lane(name, (Curve("measured", t, values),), (0.0, 1.06 * max(float(np.nanmax(values)), 1e-6)))
        for name, values in (("distance to the goal, m", episode.distance), ("heading error, °", degrees))
    ]
    names = ("force along the object, N", "force across it, N", "torque about the gripper, N·m")
    wrench = [
        Lane(name, (Curve("measured", t, episode.wrench[:, column]),)) for column, name in enumerate(names)
    ]
    return [
        draw(f"{identity}-way", "Distance to the goal", "", way, episode),
        draw(f"{identity}-wrench", "Wrench on the object", "", wrench, episode),
    ]


def draw(
    identity: str,
    title: str,
    caption: str,
    rows: Sequence[Lane],
    episode: Episode,
    marks: Marks | None = None,
) -> Figure:
    """Return a figure of lanes over the episode."""
    text = f"{title}. {caption}" if caption else f"{title} over time."
    span = (0.0, float(episode.t[-1]))
    return lane_figure(identity, title, text, rows, span, ("", caption or text), marks=marks)
