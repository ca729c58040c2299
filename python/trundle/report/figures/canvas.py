"""Elements that all figures share: the frame, text, polylines and ticks."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from trundle.report.figures.data import Data
from trundle.report.series import Array
from trundle.report.svg import Child, Markup, format_number, join, tag

__all__ = [
    "WIDTH",
    "Caption",
    "Figure",
    "dots",
    "figure",
    "finite_runs",
    "label",
    "polyline",
    "round_down_125",
    "ticks",
]

WIDTH = 360.0
"""Width of every panel, user units: about that of a phone in CSS pixels."""

Caption = tuple[str, str]
"""Part of a caption: bold text, then plain text."""


@dataclass(frozen=True)
class Figure:
    """A drawing with a caption, which the macro `figure` shows.

    Attributes
    ----------
    identity
        Unique in the page.
    title, description
        Accessible title, a few words, and description, a sentence.
    view_box
        Size in user units; the width is `WIDTH`.
    drawing
        Content of the SVG.
    caption
        Parts of the caption.
    data
        The drawn data, for the link in the caption.
    """

    identity: str
    title: str
    description: str
    view_box: str
    drawing: Markup
    caption: tuple[Caption, ...]
    data: Data


def figure(
    identity: str,
    title: str,
    description: str,
    height: float,
    drawing: Child,
    *caption: Caption,
    data: Data,
) -> Figure:
    """Return a figure of some height, user units."""
    view_box = f"0 0 {format_number(WIDTH)} {format_number(height)}"
    return Figure(identity, title, description, view_box, join([drawing]), caption, data)


def label(text: str, x: float, y: float, style: str = "", anchor: str | None = None) -> Markup:
    """Return text with its baseline at (x, y); `anchor` is "middle", "end" or None (start)."""
    return tag("text", text, x=x, y=y, class_=style or None, text_anchor=anchor)


def polyline(points: Array, style: str) -> Markup:
    """Return a line through points (n, 2) in user units, interrupted where a point is NaN."""
    parts = [
        "M" + "L".join(f"{format_number(x)} {format_number(y)}" for x, y in run)
        for run in finite_runs(points)
    ]
    return tag("path", d="".join(parts), class_=style)


def dots(points: Array, style: str) -> Markup:
    """Return dots at points (n, 2) in user units; the line width is their diameter."""
    moves = (f"M{format_number(x)} {format_number(y)}h0" for x, y in points)
    return tag("path", d="".join(moves), class_=style)


def finite_runs(points: Array) -> list[Array]:
    """Return the runs of rows (n, k) without NaN that have at least two rows."""
    seen = np.isfinite(points).all(axis=1)
    edges = np.flatnonzero(np.diff(seen)) + 1
    parts = zip(np.split(points, edges), np.split(seen, edges), strict=True)
    return [part for part, good in parts if len(part) > 1 and good[0]]


def round_down_125(span: float) -> float:
    """Return the largest 1, 2 or 5 times a power of ten that does not exceed `span`."""
    power = 10.0 ** math.floor(math.log10(span))
    return max(factor * power for factor in (1.0, 2.0, 5.0) if factor * power <= span * (1.0 + 1e-9))


def ticks(low: float, high: float, most: int) -> tuple[list[float], int]:
    """Return round values in an interval, as many as possible up to `most`, and their number of decimals."""
    power = 10.0 ** math.floor(math.log10((high - low) / most))
    multiples = (
        (step, range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1))
        for step in (factor * power for factor in (1.0, 2.0, 4.0, 5.0, 10.0, 20.0, 40.0))
    )
    step, inside = next((step, inside) for step, inside in multiples if len(inside) <= most)
    return [index * step for index in inside], max(0, -math.floor(math.log10(step) + 1e-9))
