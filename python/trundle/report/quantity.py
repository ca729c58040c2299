"""Numbers for display: rounded to their uncertainty, in a unit that suits their magnitude."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from trundle.report.series import Array, finite

__all__ = [
    "ABSENT",
    "Scale",
    "display_scale",
    "format_estimate",
    "format_fixed",
    "format_interval",
    "format_point",
    "format_quantity",
    "format_significant",
    "is_nested",
    "join_words",
    "key_to_words",
]

ABSENT = "\N{EN DASH}"
"""Text in place of an absent number."""

_MAX_SD_IN_MILLIMETRES = 0.005
"""Standard deviation, m, up to which points are given in millimetres."""
_MINUS = "\N{MINUS SIGN}"
_THIN = "\N{NARROW NO-BREAK SPACE}"


@dataclass(frozen=True)
class Scale:
    """A unit for display: `shown = factor · SI`."""

    factor: float
    unit: str

    def text(self, value: object, digits: int | None = None) -> str:
        """Format an SI value with its unit, or return a dash for None.

        By default two significant digits, three for displayed values of ten or more.
        """
        number = finite(value)
        if number is None:
            return ABSENT
        gap = "" if self.unit in ("°", "") else "\N{NO-BREAK SPACE}"
        size = number * self.factor
        return f"{format_significant(size, digits or (3 if abs(size) >= 10.0 else 2))}{gap}{self.unit}"


def display_scale(unit: str, *values: object) -> Scale:
    """Return the display unit for the largest of some SI values: mm, cm or m for "m", degrees for "rad"."""
    sizes = [abs(number) for number in map(finite, values) if number is not None]
    size = max(sizes, default=0.0)
    if unit == "m":
        return Scale(1e3, "mm") if size < 0.01 else Scale(1e2, "cm") if size < 1.0 else Scale(1.0, "m")
    return Scale(math.degrees(1.0), "°") if unit == "rad" else Scale(1.0, unit)


def format_quantity(unit: str, value: object) -> str:
    """Format one SI value in its display unit."""
    return display_scale(unit, value).text(value)


def format_interval(start: float, end: float) -> str:
    """Format a time interval in s."""
    return f"{format_fixed(start, 2)}\N{EN DASH}{format_fixed(end, 2)}\N{NO-BREAK SPACE}s"


def format_point(at: Array, sd: Array | None = None) -> str:
    """Format a point (2,), m, with the larger standard deviation: `(0.50, −0.30) m ± 1 cm`.

    A coordinate with an infinite standard deviation is a question mark.
    """
    known = np.full(2, True) if sd is None else np.isfinite(sd)
    worst = None if sd is None or not known.any() else float(sd[known].max())
    places = 2 if worst is None or worst > _MAX_SD_IN_MILLIMETRES else 3
    texts = [format_fixed(value, places) if seen else "?" for value, seen in zip(at, known, strict=True)]
    point = f"({', '.join(texts)})\N{NO-BREAK SPACE}m"
    return f"{point} ± {display_scale('m', worst).text(worst, 1)}" if worst else point


def format_significant(value: float, digits: int = 3) -> str:
    """Format a number to `digits` significant digits, in scientific notation outside 10⁻⁴ to 10⁷."""
    if value == 0.0:
        return "0"
    exponent = math.floor(math.log10(abs(value)))
    if not -4 <= exponent < 7:
        return _format_power(value, digits)
    return format_fixed(value, max(0, digits - 1 - exponent))


def format_estimate(mean: object, sd: object, unit: str = "") -> str:
    """Format an estimate as `14.2 ± 0.3 N`.

    It is rounded to the first significant digit of the standard deviation, to the second if the first is 1.
    """
    centre, spread = finite(mean), finite(sd)
    tail = f" {unit}" if unit and unit != "1" else ""
    if centre is None:
        return ABSENT
    if spread is None or spread <= 0.0:
        return _strip_zeros(format_significant(centre, 4)) + tail
    exponent = math.floor(math.log10(spread))
    if max(exponent, math.floor(math.log10(max(abs(centre), spread)))) >= 7 or exponent < -6:
        return f"{format_significant(centre)} ± {format_significant(spread, 2)}{tail}"
    places = -exponent + (1 if spread < 2.0 * 10.0**exponent else 0)
    return f"{format_fixed(centre, places)} ± {format_fixed(spread, places)}{tail}"


def key_to_words(key: str) -> str:
    """Return a key of diagnosis.json with spaces for underscores."""
    return key.replace("_", " ")


def join_words(words: list[str], last: str = "and") -> str:
    """Return `a`, `a and b` or `a, b and c`."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} {last} {words[-1]}" if words else ""


def is_nested(value: object) -> bool:
    """Return whether a parameter is a vector or a matrix."""
    return isinstance(value, list | tuple)


def _strip_zeros(text: str) -> str:
    return text.rstrip("0").rstrip(".") if "." in text and "·" not in text else text


def format_fixed(value: float, places: int) -> str:
    """Format a number to `places` decimals (negative: tens, hundreds), with separators from 10 000 on."""
    text = f"{round(value, places):,.{max(0, places)}f}"
    whole = text.replace(",", _THIN if abs(value) >= 1e4 else "")
    return (
        (_MINUS + whole[1:] if value < 0.0 else whole) if float(text.replace(",", "")) else whole.lstrip("-")
    )


def _format_power(value: float, digits: int) -> str:
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    raised = str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"{mantissa.replace('-', _MINUS)}·10{raised}"
