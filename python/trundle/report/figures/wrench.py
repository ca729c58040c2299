"""Quasi-static pushes: the wrench that the model requires for the observed motion, and the recorded one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trundle.report.figures import lanes
from trundle.report.figures.canvas import WIDTH, Figure, dots, figure, label, ticks
from trundle.report.figures.curves import Curve, Lane
from trundle.report.figures.data import Data
from trundle.report.figures.residual import CHANNELS
from trundle.report.quantity import format_significant
from trundle.report.series import Array, Episode, Series, Wrench, held_out_first
from trundle.report.svg import Markup, join, tag

__all__ = ["agreement", "time_course"]

_PLOT_SIZE, _LEFT, _PLOT_GAP, _TOP = 134.0, 44.0, 36.0, 20.0
_MAX_POINTS = 500


def agreement(series: Series) -> list[Figure]:
    """Return one panel per channel: required versus recorded wrench of the held-out pushes."""
    episodes = [episode for episode in held_out_first(series.episodes) if episode.wrench is not None]
    judged = [episode for episode in episodes if episode.held_out] or episodes
    wrenches = [episode.wrench for episode in judged if episode.wrench is not None]
    kind = "held-out" if any(episode.held_out for episode in judged) else "fitted"
    return [_channel(channel, wrenches, kind) for channel in series.channels] if wrenches else []


def time_course(index: int, episode: Episode, wrench: Wrench, series: Series) -> Figure:
    """Return recorded and required wrench of one push over time."""
    rows = []
    for channel in series.channels:
        name, unit = CHANNELS[channel]
        sides = [(side, curve) for side, curve in _sides(wrench) if curve is not None]
        curves = [
            Curve(side, wrench.t, curve[:, channel])
            for side, curve in (("recorded", wrench.recorded), *sides)
        ]
        rows.append(Lane(f"{name}, {unit}", tuple(curves), height=80.0))
    kind = "held out" if episode.held_out else "fitted"
    text = "Recorded and required force and torque over time."
    return lanes.lane_figure(
        f"wrench-{index}",
        f"Wrench in {episode.name}",
        text,
        rows,
        (float(wrench.t[0]), float(wrench.t[-1])),
        (episode.name, f" ({kind})."),
    )


def _sides(wrench: Wrench) -> tuple[tuple[str, Array | None], ...]:
    return ("before", wrench.before), ("after", wrench.after)


def _channel(channel: int, wrenches: Sequence[Wrench], kind: str) -> Figure:
    name, unit = CHANNELS[channel]
    recorded = np.concatenate([wrench.recorded[:, channel] for wrench in wrenches])
    reach = float(np.abs(recorded[np.isfinite(recorded)]).max(initial=0.0)) * 1.25 or 1.0
    plots, errors, columns = [], [], {f"recorded, {unit}": recorded}
    single = all(wrench.before is None for wrench in wrenches)
    for place, side in enumerate(("before", "after")):
        required = np.concatenate([_required(wrench, side, channel) for wrench in wrenches])
        error = _rms(required - recorded)
        if error is not None:
            errors.append(f"{format_significant(error, 2)} {unit}{'' if single else f' {side}'}")
            columns[f"required {side}, {unit}"] = required
            plots.append(_scatter_plot(place, side, recorded, required, reach))
    text = f"RMS error: {', '.join(errors)}." if errors else "No model wrench."
    axes = label(f"recorded, {unit}", WIDTH - 8.0, _TOP + _PLOT_SIZE + 32.0, "tick", "end")
    described = f"Required versus recorded {name} on {kind} pushes. On the diagonal both agree. {text}"
    return figure(
        f"agreement-{channel}",
        f"Agreement in {name}",
        described,
        _TOP + _PLOT_SIZE + 40.0,
        [plots, axes],
        (name.capitalize(), f", {kind} pushes. {text}"),
        data=Data(tuple(columns), np.column_stack([*columns.values()])[_few(recorded)].tolist()),
    )


def _required(wrench: Wrench, side: str, channel: int) -> Array:
    curve: Array | None = getattr(wrench, side)
    return np.full(len(wrench.recorded), np.nan) if curve is None else curve[:, channel]


def _rms(error: Array) -> float | None:
    seen = error[np.isfinite(error)]
    return float(np.sqrt(np.mean(seen**2))) if len(seen) else None


def _scatter_plot(place: int, side: str, recorded: Array, required: Array, reach: float) -> Markup:
    left = _LEFT + place * (_PLOT_SIZE + _PLOT_GAP)
    values, places = ticks(-reach, reach, most=3)
    offsets = _project(np.array(values), reach)
    bottom = _TOP + _PLOT_SIZE
    grid = [
        join(
            [
                tag("line", x1=left + offset, x2=left + offset, y1=_TOP, y2=bottom, class_="grid"),
                tag(
                    "line",
                    x1=left,
                    x2=left + _PLOT_SIZE,
                    y1=bottom - offset,
                    y2=bottom - offset,
                    class_="grid",
                ),
                label(_signed(value, places), left + offset, bottom + 15.0, "tick", "middle"),
                None
                if place
                else label(_signed(value, places), left - 5.0, bottom - offset + 4.0, "tick", "end"),
            ]
        )
        for value, offset in zip(values, offsets, strict=True)
    ]
    box = tag("rect", x=left, y=_TOP, width=_PLOT_SIZE, height=_PLOT_SIZE, class_="box")
    diagonal = tag("line", x1=left, y1=bottom, x2=left + _PLOT_SIZE, y2=_TOP, class_="zero")
    return join(
        [
            label(f"required {side}", left, _TOP - 6.0, "lane"),
            box,
            grid,
            diagonal,
            _dots(left, side, recorded, required, reach),
        ]
    )


def _dots(left: float, side: str, recorded: Array, required: Array, reach: float) -> Markup:
    seen = np.isfinite(recorded) & np.isfinite(required)
    few = _few(recorded[seen])
    x = left + _project(recorded[seen][few], reach)
    y = _TOP + _PLOT_SIZE - _project(required[seen][few], reach)
    return dots(np.column_stack([x, y]), f"dots {side}")


def _few(values: Array) -> slice:
    """Return evenly spaced rows, about `_MAX_POINTS` of many."""
    return slice(None, None, max(1, len(values) // _MAX_POINTS))


def _project(values: Array, reach: float) -> Array:
    place: Array = _PLOT_SIZE * (np.clip(values / reach, -1.0, 1.0) + 1.0) / 2.0
    return place


def _signed(value: float, places: int) -> str:
    return f"{value:.{places}f}".replace("-", "\N{MINUS SIGN}") if value else "0"
