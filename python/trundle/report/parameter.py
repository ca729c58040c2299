"""Parameters for display: a number with its uncertainty, a vector, or a matrix."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from trundle.report.quantity import format_estimate, format_fixed, is_nested
from trundle.report.series import finite

__all__ = ["Quantity", "format_parameter"]

_AXES = ("x", "y", "θ")


@dataclass(frozen=True)
class Quantity:
    """A formatted parameter, which the macro `quantity` shows.

    Attributes
    ----------
    mean, sd
        Formatted numbers; `sd` may be empty. CSS moves it to a second line on narrow screens.
    unit
        Text after the numbers, or below a matrix.
    rows
        Rows of a matrix: name and entries.
    is_identifiable
        Whether there is a number.
    """

    mean: str = ""
    sd: str = ""
    unit: str = ""
    rows: tuple[tuple[str, tuple[Quantity, ...]], ...] = ()
    is_identifiable: bool = True


def format_parameter(value: Any) -> Quantity:
    """Format a parameter and its uncertainty; a parameter that is not identifiable has no number."""
    if not isinstance(value, Mapping):
        return Quantity(format_estimate(value, None))
    if value.get("identifiable") is False:
        return Quantity(is_identifiable=False)
    mean, sd, unit = value.get("mean"), value.get("sd"), str(value.get("unit") or "")
    if is_nested(mean):
        return _format_array(mean, sd, unit)
    return _estimate(mean, sd, unit, _degrees(mean) if unit == "rad" else "")


def _degrees(mean: object) -> str:
    angle = finite(mean)
    return "" if angle is None else f" ({format_fixed(math.degrees(angle), 1)}°)"


def _estimate(mean: object, sd: object, unit: str = "", note: str = "") -> Quantity:
    """Return an estimate; its unit belongs to the last number."""
    centre, _, spread = format_estimate(mean, sd, unit).partition(" ± ")
    return Quantity(centre, spread, note)


def _format_array(mean: Any, sd: Any, unit: str) -> Quantity:
    """Return a vector as a line and a matrix as rows, which are named x, y, θ if there are three."""
    spread = _matching(sd, mean)
    if not any(is_nested(row) for row in mean):
        line = ", ".join(format_estimate(entry, width) for entry, width in zip(mean, spread, strict=True))
        return Quantity(line, unit=f" {unit}")
    names = _AXES if len(mean) == len(_AXES) else tuple(str(index + 1) for index in range(len(mean)))
    rows = tuple(
        (name, tuple(_estimate(*cell) for cell in zip(row, _matching(width, row), strict=True)))
        for name, row, width in zip(names, mean, spread, strict=True)
    )
    # A planar damping matrix has blocks with different units.
    planar = len(mean) == len(_AXES) and unit in ("", "SI", "N·s/m")
    return Quantity(unit="N·s/m; in row or column θ N·s; at θ, θ N·m·s" if planar else unit, rows=rows)


def _matching(sd: Any, mean: Sequence[Any]) -> Sequence[Any]:
    """Return standard deviations, or None for each entry if they do not match `mean`."""
    return sd if is_nested(sd) and len(sd) == len(mean) else [None] * len(mean)
