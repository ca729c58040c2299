"""Curves over time in stacked lanes: each lane has its own value axis, all share the time axis."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from trundle.report.decimate import envelope
from trundle.report.figures.canvas import (
    WIDTH,
    Caption,
    Figure,
    dots,
    figure,
    finite_runs,
    label,
    polyline,
    ticks,
)
from trundle.report.figures.curves import Curve, Lane, Marks, bounds, table
from trundle.report.quantity import display_scale
from trundle.report.series import Array
from trundle.report.svg import Markup, format_number, join, tag

__all__ = ["draw", "lane_figure"]

TIME_AXIS = "time, s"
"""Title of the time axis."""

_LEFT, _RIGHT = 50.0, 12.0
_TITLE, _GAP, _AXIS = 18.0, 9.0, 32.0
_PLOT_WIDTH = WIDTH - _LEFT - _RIGHT
_MIN_LABEL_SPACING = 26.0


def draw(
    lanes: Sequence[Lane], span: tuple[float, float], marks: Marks | None = None, axis: str = TIME_AXIS
) -> tuple[Markup, float]:
    """Draw lanes over a time span, s, or a span in the unit of `axis`; return the drawing and its height.

    The script of the page finds the time span, the frame and the columns of the data in attributes.
    """
    marks = marks or Marks()
    height = sum(_TITLE + lane.height + _GAP for lane in lanes) + _AXIS
    parts: list[Markup] = []
    top, column = 0.0, 1
    for index, lane in enumerate(lanes):
        frame = _Frame(span, lane, top + _TITLE, column)
        parts.append(frame.draw(marks))
        parts += frame.names(marks.events) if index == 0 else []
        top += _TITLE + lane.height + _GAP
        column += len(lane.curves)
    parts.append(tag("g", _time_axis(span, top - _GAP, axis), class_="time-axis", data_y=top - _GAP))
    frame_numbers = " ".join(f"{value:.6g}" for value in (*span, _LEFT, _PLOT_WIDTH, top - _GAP))
    return tag("g", parts, class_="lanes", data_frame=frame_numbers), height


def lane_figure(
    identity: str,
    title: str,
    description: str,
    lanes: Sequence[Lane],
    span: tuple[float, float],
    *caption: Caption,
    marks: Marks | None = None,
    axis: str = TIME_AXIS,
) -> Figure:
    """Return a figure of lanes over a time span, s, or a span in the unit of `axis`."""
    drawing, height = draw(lanes, span, marks, axis)
    data = table(lanes).data(axis)
    return figure(identity, title, description, height, drawing, *caption, data=data)


@dataclass(frozen=True)
class _Frame:
    """One lane on the page: converts time and value to user units; `column` is the first one of its data."""

    span: tuple[float, float]
    lane: Lane
    top: float
    column: int

    @property
    def limits(self) -> tuple[float, float]:
        return self.lane.limits or bounds(self.lane.curves)

    def x(self, t: Array) -> Array:
        return _time_to_x(self.span, t)

    def y(self, value: Array) -> Array:
        low, high = self.limits
        share = np.clip((value - low) / (high - low), 0.0, 1.0)
        place: Array = self.top + self.lane.height * (1.0 - share)
        return place

    def draw(self, marks: Marks) -> Markup:
        size = {"x": _LEFT, "y": self.top, "width": _PLOT_WIDTH, "height": self.lane.height}
        plot = tag(
            "svg",
            [self._window(*window) for window in marks.windows],
            [self._curve(curve) for curve in self.lane.curves],
            [self._event(time) for time, _ in marks.events],
            viewBox=" ".join(format_number(value) for value in size.values()),
            preserveAspectRatio="none",
            class_="plot",
            **size,
        )
        return join(
            [
                label(self.lane.title, _LEFT, self.top - 5.0, "lane"),
                self._readout(),
                tag("rect", class_="box", **size),
                self._value_axis(),
                plot,
            ]
        )

    def _readout(self) -> Markup:
        """Return the empty text in which the script shows the values at the pointer."""
        named = enumerate(self.lane.curves, self.column)
        columns = "|".join(f"{column}:{curve.name}" for column, curve in named if curve.width is None)
        place = {"x": _LEFT + _PLOT_WIDTH, "y": self.top - 5.0}
        return tag("text", class_="readout", text_anchor="end", data_columns=columns, **place)

    def names(self, events: Sequence[tuple[float, str]]) -> Iterator[Markup]:
        """Yield the names of events next to their lines; names of close events share a label."""
        groups: list[tuple[float, list[str]]] = []
        for time, name in sorted(events):
            x = float(self.x(np.array([time]))[0])
            if groups and x - groups[-1][0] < _MIN_LABEL_SPACING:
                groups[-1][1].append(name)
            else:
                groups.append((x, [name]))
        for x, names in groups:
            right = x > WIDTH - 60.0
            place = x - 5.0 if right else x + 5.0
            yield label(", ".join(names), place, self.top + 14.0, "number small", "end" if right else None)

    def _value_axis(self) -> Iterator[Markup]:
        if self.lane.is_log_distance:
            low, high = self.limits
            values = [float(power) for power in range(math.ceil(low), math.floor(high) + 1)]
            texts = [display_scale("m", 10.0**power).text(10.0**power, 1) for power in values]
        else:
            values, places = ticks(*self.limits, most=3)
            texts = [_tick(value, places) for value in values]
        for value, text, place in zip(values, texts, self.y(np.array(values)), strict=True):
            style = "zero" if abs(value) < 1e-12 and not self.lane.is_log_distance else "grid"
            yield tag("line", x1=_LEFT, x2=_LEFT + _PLOT_WIDTH, y1=place, y2=place, class_=style)
            baseline = float(np.clip(place + 4.0, self.top + 8.0, self.top + self.lane.height + 4.0))
            yield label(text, _LEFT - 5.0, baseline, "tick", "end")

    def _curve(self, curve: Curve) -> Markup:
        if curve.width is not None:
            return self._band(curve, curve.width)
        if curve.is_dotted:
            return dots(np.column_stack([self.x(curve.t), self.y(curve.y)]), curve.style)
        t, y = envelope(curve.t, curve.y, int(_PLOT_WIDTH))
        return polyline(np.column_stack([self.x(t), self.y(y)]), curve.style)

    def _band(self, curve: Curve, width: Array) -> Markup:
        few = slice(None, None, max(1, len(curve.t) // 150))
        rows = np.column_stack([curve.t[few], curve.y[few], np.nan_to_num(width[few])])
        return join(self._area(run, curve.style) for run in finite_runs(rows))

    def _area(self, rows: Array, style: str) -> Markup:
        t, y, half = rows.T
        upper = np.column_stack([self.x(t), self.y(y + half)])
        lower = np.column_stack([self.x(t), self.y(y - half)])
        return polyline(np.vstack([upper, lower[::-1], upper[:1]]), style)

    def _window(self, start: float, end: float) -> Markup:
        left, right = self.x(np.array([start, end]))
        area = {"x": left, "width": max(1.0, right - left), "y": self.top, "height": self.lane.height}
        edges = (
            tag("line", x1=x, x2=x, y1=self.top, y2=self.top + self.lane.height, class_="edge")
            for x in (left, right)
        )
        return join([tag("rect", class_="window", **area), edges])

    def _event(self, time: float) -> Markup:
        x = float(self.x(np.array([time]))[0])
        return tag("line", x1=x, x2=x, y1=self.top, y2=self.top + self.lane.height, class_="event")


def _time_to_x(span: tuple[float, float], t: Array) -> Array:
    share = np.clip((t - span[0]) / (span[1] - span[0]), 0.0, 1.0)
    place: Array = _LEFT + _PLOT_WIDTH * share
    return place


def _time_axis(span: tuple[float, float], y: float, axis: str) -> Iterator[Markup]:
    values, places = ticks(*span, most=6)
    for value, x in zip(values, _time_to_x(span, np.array(values)), strict=True):
        yield tag("line", x1=x, x2=x, y1=y, y2=y + 4.0, class_="axis")
        yield label(_tick(value, places), x, y + 16.0, "tick", "middle")
    yield label(axis, _LEFT + _PLOT_WIDTH, y + 30.0, "tick", "end")


def _tick(value: float, places: int) -> str:
    text = f"{value:.{places}f}"
    return text.lstrip("-") if float(text) == 0.0 else text.replace("-", "\N{MINUS SIGN}")
