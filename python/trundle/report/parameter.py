"""Parameters for display: a number with its uncertainty, a vector, or a matrix."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from trundle.report.markup import Child, Html, tag
from trundle.report.quantity import format_estimate, format_fixed, is_nested
from trundle.report.series import finite

__all__ = ["format_parameter"]

_AXES = ("x", "y", "θ")


def format_parameter(value: Any) -> Child:
    """Format a parameter and its uncertainty; a parameter that is not identifiable has no number."""
    if not isinstance(value, Mapping):
        return format_estimate(value, None)
    if value.get("identifiable") is False:
        return tag("em", "not identifiable")
    mean, sd, unit = value.get("mean"), value.get("sd"), str(value.get("unit") or "")
    if is_nested(mean):
        return _array_cells(mean, sd, unit)
    return [*_estimate_parts(format_estimate(mean, sd, unit)), _degrees(mean) if unit == "rad" else None]


def _degrees(mean: object) -> str | None:
    angle = finite(mean)
    return None if angle is None else f" ({format_fixed(math.degrees(angle), 1)}°)"


def _array_cells(mean: Any, sd: Any, unit: str) -> Child:
    """Return a vector as a line and a matrix as a table."""
    spread = sd if is_nested(sd) and len(sd) == len(mean) else [None] * len(mean)
    if not any(is_nested(row) for row in mean):
        return [_line(mean, spread), f" {unit}"]
    widths = [
        width if is_nested(width) and len(width) == len(row) else [None] * len(row)
        for row, width in zip(mean, spread, strict=True)
    ]
    return [
        _matrix(mean, widths),
        tag("span", f"rows and columns x, y, θ; {_units(mean, unit)}", class_="unit"),
    ]


def _units(mean: Any, unit: str) -> str:
    """Return the unit, or the units of the blocks of a planar damping matrix."""
    if len(mean) == 3 and unit in ("", "SI", "N·s/m"):
        return "N·s/m; in row or column θ N·s; at θ, θ N·m·s"
    return unit


def _line(mean: Sequence[Any], spread: Sequence[Any]) -> str:
    return ", ".join(format_estimate(entry, width) for entry, width in zip(mean, spread, strict=True))


def _estimate_parts(text: str) -> list[Child]:
    """Split "mean ± sd" so that CSS can move the deviation to a second line on narrow screens."""
    centre, sign, spread = text.partition(" ± ")
    return [centre, tag("span", f" ± {spread}", class_="sd") if sign else None]


def _matrix(mean: Sequence[Any], spread: Sequence[Any]) -> Html:
    """Return a matrix as a table; rows are named x, y, θ if there are three."""
    names = _AXES if len(mean) == len(_AXES) else tuple(str(index + 1) for index in range(len(mean)))
    rows = [
        tag(
            "tr",
            tag("th", name, scope="row"),
            [tag("td", _estimate_parts(format_estimate(*cell))) for cell in zip(row, width, strict=True)],
        )
        for name, row, width in zip(names, mean, spread, strict=True)
    ]
    return tag("table", tag("tbody", rows), class_="matrix")
