"""Slow pushes: the wrench that the model needs for the motion that was seen, against the one recorded."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trundle.report.figures import lanes
from trundle.report.figures.canvas import WIDTH, figure, label, ticks
from trundle.report.figures.lanes import Curve, Lane
from trundle.report.figures.residual import CHANNELS
from trundle.report.given import Array, Episode, Series, Wrench, held_out_first
from trundle.report.markup import Html, join, number, tag
from trundle.report.quantity import significant

__all__ = ["agreement", "in_time"]

_SIDE, _LEFT, _BETWEEN, _TOP = 142.0, 44.0, 22.0, 20.0
_MOST_POINTS = 500


def agreement(series: Series) -> list[Html]:
    """One panel a channel: needed against recorded wrench over the held-out pushes, before and after."""
    episodes = [episode for episode in held_out_first(series.episodes) if episode.wrench is not None]
    judged = [episode for episode in episodes if episode.held_out] or episodes
    wrenches = [episode.wrench for episode in judged if episode.wrench is not None]
    kind = "held-out" if any(episode.held_out for episode in judged) else "fitted"
    return [_channel(channel, wrenches, kind) for channel in series.channels] if wrenches else []


def in_time(index: int, episode: Episode, wrench: Wrench, series: Series) -> Html:
    """Return recorded and needed wrench of one push in time."""
    rows = []
    for channel in series.channels:
        name, unit = CHANNELS[channel]
        sides = [(side, curve) for side, curve in _sides(wrench) if curve is not None]
        curves = [
            Curve(side, wrench.t, curve[:, channel])
            for side, curve in (("recorded", wrench.recorded), *sides)
        ]
        rows.append(Lane(f"{name}, {unit}", tuple(curves), height=80.0))
    graph, height = lanes.draw(rows, (float(wrench.t[0]), float(wrench.t[-1])))
    kind = "held out" if episode.held_out else "fitted"
    text = "Recorded force and torque in time, and those that the model needs."
    return figure(
        f"wrench-{index}",
        f"Wrench in {episode.name}",
        text,
        height,
        graph,
        [tag("b", episode.name), f" ({kind})."],
    )


def _sides(wrench: Wrench) -> tuple[tuple[str, Array | None], ...]:
    return ("before", wrench.before), ("after", wrench.after)


def _channel(channel: int, wrenches: Sequence[Wrench], kind: str) -> Html:
    name, unit = CHANNELS[channel]
    recorded = np.concatenate([wrench.recorded[:, channel] for wrench in wrenches])
    reach = float(np.abs(recorded[np.isfinite(recorded)]).max(initial=0.0)) * 1.25 or 1.0
    squares, words = [], []
    single = all(wrench.before is None for wrench in wrenches)
    for place, side in enumerate(("before", "after")):
        needed = np.concatenate([_needed(wrench, side, channel) for wrench in wrenches])
        error = _rms(needed - recorded)
        if error is not None:
            words.append(f"{significant(error, 2)} {unit}{'' if single else f' {side}'}")
            squares.append(_square(place, side, recorded, needed, reach))
    text = f"Off by (rms) {', '.join(words)}." if words else "No model wrench."
    axes = label(f"recorded, {unit}", WIDTH - 8.0, _TOP + _SIDE + 32.0, "tick", "end")
    described = f"Needed against recorded {name} on {kind} pushes; on the diagonal both agree. {text}"
    caption = [tag("b", name.capitalize()), f", {kind} pushes. {text}"]
    return figure(
        f"agreement-{channel}",
        f"Agreement in {name}",
        described,
        _TOP + _SIDE + 40.0,
        join([squares, axes]),
        caption,
    )


def _needed(wrench: Wrench, side: str, channel: int) -> Array:
    curve: Array | None = getattr(wrench, side)
    return np.full(len(wrench.recorded), np.nan) if curve is None else curve[:, channel]


def _rms(error: Array) -> float | None:
    seen = error[np.isfinite(error)]
    return float(np.sqrt(np.mean(seen**2))) if len(seen) else None


def _square(place: int, side: str, recorded: Array, needed: Array, reach: float) -> Html:
    left = _LEFT + place * (_SIDE + _BETWEEN)
    values, places = ticks(-reach, reach, most=3)
    spots = _project(np.array(values), reach)
    bottom = _TOP + _SIDE
    grid = [
        join(
            [
                tag("line", x1=left + spot, x2=left + spot, y1=_TOP, y2=bottom, class_="grid"),
                tag("line", x1=left, x2=left + _SIDE, y1=bottom - spot, y2=bottom - spot, class_="grid"),
                label(_signed(value, places), left + spot, bottom + 15.0, "tick", "middle"),
                None
                if place
                else label(_signed(value, places), left - 5.0, bottom - spot + 4.0, "tick", "end"),
            ]
        )
        for value, spot in zip(values, spots, strict=True)
    ]
    box = tag("rect", x=left, y=_TOP, width=_SIDE, height=_SIDE, class_="box")
    diagonal = tag("line", x1=left, y1=bottom, x2=left + _SIDE, y2=_TOP, class_="zero")
    return join(
        [
            label(f"needed {side}", left, _TOP - 6.0, "lane"),
            box,
            grid,
            diagonal,
            _dots(left, side, recorded, needed, reach),
        ]
    )


def _dots(left: float, side: str, recorded: Array, needed: Array, reach: float) -> Html:
    seen = np.isfinite(recorded) & np.isfinite(needed)
    few = slice(None, None, max(1, int(seen.sum()) // _MOST_POINTS))
    x = left + _project(recorded[seen][few], reach)
    y = _TOP + _SIDE - _project(needed[seen][few], reach)
    spots = "".join(f"M{number(a)} {number(b)}h0" for a, b in zip(x, y, strict=True))
    return tag("path", d=spots, class_=f"dots {side}")


def _project(values: Array, reach: float) -> Array:
    place: Array = _SIDE * (np.clip(values / reach, -1.0, 1.0) + 1.0) / 2.0
    return place


def _signed(value: float, places: int) -> str:
    return f"{value:.{places}f}".replace("-", "\N{MINUS SIGN}") if value else "0"
