"""Curves over time and the lanes that show them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from trundle.report.figures.data import Table, tabulate
from trundle.report.series import Array

__all__ = ["Curve", "Lane", "Marks", "bounds", "table"]

_WIDTH_NAME = "two standard deviations"
"""Column of a band's half width."""


@dataclass(frozen=True)
class Curve:
    """A curve over time, (n,) each.

    `style` is a CSS class, of which the first word names the curve. With `width` (n,) the curve is a band
    y ± width. With `is_dotted` its points are drawn as dots.
    """

    style: str
    t: Array
    y: Array
    width: Array | None = None
    is_dotted: bool = False

    @property
    def name(self) -> str:
        """Name of the curve in the data and next to the values under the pointer."""
        return _WIDTH_NAME if self.width is not None else self.style.split()[0]


@dataclass(frozen=True)
class Lane:
    """Curves over one value axis.

    With `limits` None the axis fits the curves. With `is_log_distance` values are common logarithms of
    distances in m, and the axis is labelled with distances.
    """

    title: str
    curves: tuple[Curve, ...]
    limits: tuple[float, float] | None = None
    height: float = 60.0
    is_log_distance: bool = False

    def columns(self) -> Iterator[tuple[str, Array, Array]]:
        """Yield name, times and values of each curve; of a band, its half width."""
        is_single = len(self.curves) == 1
        for curve in self.curves:
            values = curve.y if curve.width is None else curve.width
            yield (
                self.title if is_single else f"{self.title}: {curve.name}",
                curve.t,
                np.power(10.0, values) if self.is_log_distance else values,
            )


@dataclass(frozen=True)
class Marks:
    """Marks on the time axis, s: shaded windows, and events (time, name) as lines."""

    windows: Sequence[tuple[float, float]] = field(default=())
    events: Sequence[tuple[float, str]] = field(default=())


def table(lanes: Sequence[Lane]) -> Table:
    """Return the data of lanes: a column for each curve, in order."""
    columns = [column for lane in lanes for column in lane.columns()]
    return tabulate([name for name, *_ in columns], [(t, values) for _, t, values in columns])


def bounds(curves: Sequence[Curve]) -> tuple[float, float]:
    """Return limits that contain all curves with a margin; they are never equal."""
    values = np.concatenate([np.empty(0), *(part for curve in curves for part in _edges(curve))])
    values = values[np.isfinite(values)]
    if not len(values):
        return -1.0, 1.0
    low, high = float(values.min()), float(values.max())
    margin = 0.06 * (high - low) or max(abs(high), 1.0) * 0.5
    return low - margin, high + margin


def _edges(curve: Curve) -> Iterator[Array]:
    width = np.zeros(1) if curve.width is None else curve.width
    yield from (curve.y - width, curve.y + width)
