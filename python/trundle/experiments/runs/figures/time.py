"""Figures over time: estimates against true values, and the push."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from trundle.experiments.runs.history import WHEEL, Episode, named_effects
from trundle.report import wording
from trundle.report.figures import lanes
from trundle.report.figures.canvas import figure
from trundle.report.figures.lanes import Curve, Lane, Marks
from trundle.report.markup import Html
from trundle.report.quantity import key_to_words
from trundle.report.series import Array

__all__ = ["beliefs", "others", "push", "wheel"]

Numbers = Sequence[tuple[str, str]]
"""Names of estimates, and their titles with units."""

PLACE_NUMBERS: Numbers = ((f"{WHEEL}.x", "wheel, x, m"), (f"{WHEEL}.y", "wheel, y, m"))
DRAG_NUMBERS: Numbers = (
    ("least", "least drag, N·s/m"),
    ("most", "most drag, N·s/m"),
    ("body.mass", "mass, kg"),
)
CAPTION = "Line and band: estimate with two standard deviations, clipped to the frame. Dashes: true value."


def wheel(identity: str, episode: Episode) -> Html | None:
    """Return the wheel's position over time."""
    return draw_lanes(
        f"{identity}-place", "The wheel's position over time", episode, PLACE_NUMBERS, height=98.0
    )


def beliefs(identity: str, episode: Episode) -> Html | None:
    """Return the wheel's drag and the mass over time."""
    return draw_lanes(f"{identity}-rest", "Drag and mass over time", episode, DRAG_NUMBERS)


def others(identity: str, episode: Episode) -> Html | None:
    """Return estimates of added effects and of the body, except its mass, over time."""
    known = {"body.mass", *(f"{WHEEL}.{name}" for name in ("x", "y", "angle", "mu_x", "mu_y"))}
    units = {each.name: each.unit for update in episode.updates for each in update.estimates}
    titles = [(name, f"{parameter_title(name)}{f', {unit}' if unit else ''}") for name, unit in units.items()]
    chosen = [(name, text) for name, text in titles if name not in known]
    return draw_lanes(f"{identity}-others", "Parameters of added effects over time", episode, chosen)


def parameter_title(name: str) -> str:
    """Return a parameter's title."""
    kind, _, parameter = name.rpartition(".")
    return (
        key_to_words(parameter)
        if kind == "body"
        else f"{wording.effect_name(kind)}, {key_to_words(parameter)}"
    )


def draw_lanes(
    identity: str, name: str, episode: Episode, numbers: Numbers, height: float = 60.0
) -> Html | None:
    """Return a lane for each estimated number; None without any."""
    lanes_of = (estimate_lane(episode, key, text, height) for key, text in numbers)
    found = [lane for lane in lanes_of if lane is not None]
    if not found:
        return None
    added = named_effects(episode)
    caption = " ".join(
        [CAPTION, *(f"{n}: {wording.effect_name(kind)} added." for n, (_, kind) in enumerate(added, 1))]
    )
    marks = Marks(events=[(time, str(number)) for number, (time, _) in enumerate(added, 1)])
    drawing, total = lanes.draw(found, time_span(episode), marks)
    return figure(identity, name, f"{name}. {caption}", total, drawing, caption)


def estimate_lane(episode: Episode, key: str, text: str, height: float) -> Lane | None:
    """Return the lane of one number."""
    pieces = list(estimate_pieces(episode, key))
    if not pieces:
        return None
    end = episode.t[-1]
    bands = [Curve("held", t, mean, 2.0 * sd) for t, mean, sd in pieces]
    curves = [Curve("believed", t, mean) for t, mean, _ in pieces]
    true = episode.true_value(key)
    real = [] if true is None else [Curve("true", np.array([0.0, end]), np.array([true, true]))]
    # The first estimate is often far off. It does not determine the limits.
    later = bands if len(episode.updates) < 3 else list(bands_since(bands, episode.updates[1].time))
    return Lane(text, (*bands, *real, *curves), widen_limits(*lanes.bounds([*later, *real])), height)


def widen_limits(low: float, high: float) -> tuple[float, float]:
    """Return limits that are at least 5 % of the value apart."""
    lacking = max(0.05 * max(abs(low), abs(high)) - (high - low), 0.0)
    return low - lacking / 2, high + lacking / 2


def bands_since(bands: Sequence[Curve], since: float) -> Iterator[Curve]:
    """Return the parts of bands from a time on."""
    for band in bands:
        late = band.t >= since - 1e-9
        if late.any() and band.width is not None:
            yield Curve(band.style, band.t[late], band.y[late], band.width[late])


def estimate_pieces(episode: Episode, key: str) -> Iterator[tuple[Array, Array, Array]]:
    """Return time, mean and standard deviation where a number was identifiable, constant between updates."""
    ends = [*(update.time for update in episode.updates), float(episode.t[-1])][1:]
    piece: list[tuple[float, float, float]] = []
    for update, end in zip(episode.updates, ends, strict=True):
        held = update.value(key)
        if held is None or held.mean is None:
            yield from as_arrays(piece)
            piece = []
        else:
            piece += [(update.time, held.mean, held.sd or 0.0), (end, held.mean, held.sd or 0.0)]
    yield from as_arrays(piece)


def as_arrays(piece: Sequence[tuple[float, float, float]]) -> Iterator[tuple[Array, Array, Array]]:
    """Yield a piece as arrays if it is not empty."""
    if piece:
        t, mean, sd = np.array(piece).T
        yield t, mean, sd


def push(identity: str, episode: Episode) -> list[Html]:
    """Return the distance to the goal, and the wrench on the object, over time."""
    t = episode.t
    degrees = np.abs(np.degrees(episode.heading_error))
    way = (
        Lane(
            "distance to the goal, m",
            (Curve("done", t, episode.distance),),
            limits_from_zero(episode.distance),
        ),
        Lane("heading error, °", (Curve("done", t, degrees),), limits_from_zero(degrees)),
    )
    forces = (
        Lane("force along the object, N", (Curve("done", t, episode.wrench[:, 0]),)),
        Lane("force across it, N", (Curve("done", t, episode.wrench[:, 1]),)),
        Lane("torque about the gripper, N·m", (Curve("done", t, episode.wrench[:, 2]),)),
    )
    found = []
    for key, name, rows in (("way", "Distance to the goal", way), ("wrench", "Wrench on the object", forces)):
        drawing, height = lanes.draw(rows, time_span(episode))
        text = f"{name} over time."
        found.append(figure(f"{identity}-{key}", name, text, height, drawing, text))
    return found


def limits_from_zero(values: Array) -> tuple[float, float]:
    """Return limits from zero on."""
    return 0.0, 1.06 * max(float(np.nanmax(values)), 1e-6)


def time_span(episode: Episode) -> tuple[float, float]:
    """Return the time range of the figures, s."""
    return 0.0, float(episode.t[-1])
