"""Numbers as people write them: rounded to what is known, in a unit that suits their size."""

from __future__ import annotations

import math
from dataclasses import dataclass

from trundle.report.given import finite

__all__ = [
    "ABSENT",
    "Scale",
    "fixed",
    "interval",
    "listed",
    "measured",
    "nested",
    "readable",
    "shown",
    "significant",
    "suited",
]

ABSENT = "\N{EN DASH}"
"""What stands where there is no number."""

_MINUS = "\N{MINUS SIGN}"
_THIN = "\N{NARROW NO-BREAK SPACE}"


@dataclass(frozen=True)
class Scale:
    """A unit for display: `shown = factor · SI`."""

    factor: float
    unit: str

    def text(self, value: object, digits: int | None = None) -> str:
        """Value and unit, or a dash; with two digits, three from ten on, if not said otherwise."""
        number = finite(value)
        if number is None:
            return ABSENT
        gap = "" if self.unit in ("°", "") else "\N{NO-BREAK SPACE}"
        size = number * self.factor
        return f"{significant(size, digits or (3 if abs(size) >= 10.0 else 2))}{gap}{self.unit}"


def suited(unit: str, *values: object) -> Scale:
    """Return the unit in which the greatest of some SI values reads best; metres and radians have several."""
    sizes = [abs(number) for number in map(finite, values) if number is not None]
    size = max(sizes, default=0.0)
    if unit == "m":
        return Scale(1e3, "mm") if size < 0.01 else Scale(1e2, "cm") if size < 1.0 else Scale(1.0, "m")
    return Scale(math.degrees(1.0), "°") if unit == "rad" else Scale(1.0, unit)


def shown(unit: str, value: object) -> str:
    """Return an SI value in the unit that suits it alone."""
    return suited(unit, value).text(value)


def interval(start: float, end: float) -> str:
    """Return a stretch of time, s."""
    return f"{fixed(start, 2)}\N{EN DASH}{fixed(end, 2)}\N{NO-BREAK SPACE}s"


def significant(value: float, digits: int = 3) -> str:
    """Return a number with so many significant digits; powers of ten only beyond 10⁻⁴ … 10⁷."""
    if value == 0.0:
        return "0"
    exponent = math.floor(math.log10(abs(value)))
    if not -4 <= exponent < 7:
        return _powered(value, digits)
    return fixed(value, max(0, digits - 1 - exponent))


def measured(mean: object, sd: object, unit: str = "") -> str:
    """`14.2 ± 0.3 N`, rounded to the first digit of the standard deviation (the second if the first is 1)."""
    centre, spread = finite(mean), finite(sd)
    tail = f" {unit}" if unit and unit != "1" else ""
    if centre is None:
        return ABSENT
    if spread is None or spread <= 0.0:
        return _short(significant(centre, 4)) + tail
    exponent = math.floor(math.log10(spread))
    if max(exponent, math.floor(math.log10(max(abs(centre), spread)))) >= 7 or exponent < -6:
        return f"{significant(centre)} ± {significant(spread, 2)}{tail}"
    places = -exponent + (1 if spread < 2.0 * 10.0**exponent else 0)
    return f"{fixed(centre, places)} ± {fixed(spread, places)}{tail}"


def readable(key: str) -> str:
    """Return a key of diagnosis.json as words."""
    return key.replace("_", " ")


def listed(words: list[str], last: str = "and") -> str:
    """Return `a`, `a and b`, `a, b and c`."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} {last} {words[-1]}" if words else ""


def nested(value: object) -> bool:
    """Whether a parameter is a vector or matrix."""
    return isinstance(value, list | tuple)


def _short(text: str) -> str:
    return text.rstrip("0").rstrip(".") if "." in text and "·" not in text else text


def fixed(value: float, places: int) -> str:
    """So many decimals (tens or hundreds if negative), thousands apart from 10 000 on."""
    text = f"{round(value, places):,.{max(0, places)}f}"
    whole = text.replace(",", _THIN if abs(value) >= 1e4 else "")
    return (
        (_MINUS + whole[1:] if value < 0.0 else whole) if float(text.replace(",", "")) else whole.lstrip("-")
    )


def _powered(value: float, digits: int) -> str:
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    raised = str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"{mantissa.replace('-', _MINUS)}·10{raised}"
