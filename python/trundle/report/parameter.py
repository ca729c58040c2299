"""A parameter as people read it: a number with what is known of it, a vector, a matrix."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from trundle.report.given import finite
from trundle.report.markup import Child, Html, tag
from trundle.report.quantity import fixed, measured, nested

__all__ = ["parameter"]

_AXES = ("x", "y", "θ")


def parameter(value: Any) -> Child:
    """Return a parameter with what is known of it; never a number where the data do not hold one."""
    if not isinstance(value, Mapping):
        return measured(value, None)
    if value.get("identifiable") is False:
        return tag("em", "not identifiable")
    mean, sd, unit = value.get("mean"), value.get("sd"), str(value.get("unit") or "")
    if nested(mean):
        return _cells(mean, sd, unit)
    return [*_spread(measured(mean, sd, unit)), _degrees(mean) if unit == "rad" else None]


def _degrees(mean: object) -> str | None:
    angle = finite(mean)
    return None if angle is None else f" ({fixed(math.degrees(angle), 1)}°)"


def _cells(mean: Any, sd: Any, unit: str) -> Child:
    """Return a vector in a line, a matrix as a table."""
    spread = sd if nested(sd) and len(sd) == len(mean) else [None] * len(mean)
    if not any(nested(row) for row in mean):
        return [_line(mean, spread), f" {unit}"]
    widths = [
        width if nested(width) and len(width) == len(row) else [None] * len(row)
        for row, width in zip(mean, spread, strict=True)
    ]
    return [
        _matrix(mean, widths),
        tag("span", f"rows and columns x, y, θ; {_units(mean, unit)}", class_="unit"),
    ]


def _units(mean: Any, unit: str) -> str:
    """Return the units of a damping matrix: they differ from block to block."""
    if len(mean) == 3 and unit in ("", "SI", "N·s/m"):
        return "N·s/m; in row or column θ N·s; at θ, θ N·m·s"
    return unit


def _line(mean: Sequence[Any], spread: Sequence[Any]) -> str:
    return ", ".join(measured(entry, width) for entry, width in zip(mean, spread, strict=True))


def _spread(text: str) -> list[Child]:
    """Return a number with its deviation apart, so that it can go below where there is little room."""
    centre, sign, spread = text.partition(" ± ")
    return [centre, tag("span", f" ± {spread}", class_="sd") if sign else None]


def _matrix(mean: Sequence[Any], spread: Sequence[Any]) -> Html:
    """Return rows and columns, named by axes where there are three."""
    names = _AXES if len(mean) == len(_AXES) else tuple(str(index + 1) for index in range(len(mean)))
    rows = [
        tag(
            "tr",
            tag("th", name, scope="row"),
            [tag("td", _spread(measured(*cell))) for cell in zip(row, width, strict=True)],
        )
        for name, row, width in zip(names, mean, spread, strict=True)
    ]
    return tag("table", tag("tbody", rows), class_="matrix")
