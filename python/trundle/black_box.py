"""Black-box simulators: the parameters of a caller's own simulator under test."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trundle._native import TrundleError

__all__ = ["Parameter", "Parameters", "Step", "parse_parameters"]

Vector: TypeAlias = NDArray[np.float64]
Step: TypeAlias = Callable[[Vector, Vector, float, dict[str, float]], ArrayLike]


class Parameter(TypedDict, total=False):
    """Description of a parameter; only `start` is required."""

    start: float
    """Initial value of the fit."""
    lower: float
    """Lower bound; by default 0 if `start` is positive, else none."""
    upper: float
    """Upper bound; by default none."""
    sd: float
    """Prior standard deviation, in the unit of the parameter."""
    unit: str
    """SI unit, for display."""


Parameters: TypeAlias = "Mapping[str, float | Sequence[float] | Parameter]"

KEYS = ("start", "lower", "upper", "sd", "unit")


def parse_parameters(parameters: Parameters | None) -> tuple[list[dict[str, Any]], bool]:
    """Return the parameters for the native module, and whether all of them are given as plain numbers."""
    if not isinstance(parameters, Mapping):
        raise TrundleError("step: give the parameters of your simulator, as parameters={'mass': 20.0, ...}")
    given = bool(parameters) and all(is_number(value) for value in parameters.values())
    return [parse_parameter(str(name), value) for name, value in parameters.items()], given


def is_number(value: object) -> bool:
    """Return whether a value is a number."""
    return isinstance(value, int | float | np.integer | np.floating)


def parse_parameter(name: str, value: Any) -> dict[str, Any]:
    """Validate a parameter and return it as the native module expects it."""
    given = to_table(name, value)
    start = parse_number(name, "start", given.get("start"))
    positive = start > 0.0 and "lower" not in given
    lower = 0.0 if positive else parse_number(name, "lower", given.get("lower", -math.inf))
    upper = parse_number(name, "upper", given.get("upper", math.inf))
    sd = None if given.get("sd") is None else parse_number(name, "sd", given["sd"])
    if not lower <= start <= upper or lower >= upper:
        raise TrundleError(f"parameters: {name} = {start}: must lie in [{lower}, {upper}]")
    if sd is not None and not (sd > 0.0 and (lower < 0.0 or start > 0.0)):
        raise TrundleError(
            f"parameters: {name}: sd = {sd}: must be positive; with lower >= 0, start must be positive too"
        )
    if sd is None and not (math.isfinite(lower) and math.isfinite(upper)) and start <= 0.0:
        raise TrundleError(
            f"parameters: {name} = {start}: give its uncertainty, as (start, lower, upper) or "
            "{'start': ..., 'sd': ...}"
        )
    if not math.isfinite(start):
        raise TrundleError(f"parameters: {name} = {start}: must be finite")
    return {
        "name": name,
        "start": start,
        "lower": lower,
        "upper": upper,
        "sd": sd,
        "unit": given.get("unit", ""),
    }


def to_table(name: str, value: Any) -> dict[str, Any]:
    """Convert a number, (start, lower, upper) or a mapping to a dictionary."""
    if is_number(value):
        return {"start": value}
    if isinstance(value, Mapping):
        unknown = [key for key in value if key not in KEYS]
        if unknown or "start" not in value:
            error = f"unknown key {unknown[0]!r}" if unknown else "`start` is missing"
            raise TrundleError(f"parameters: {name}: {error}; the keys are {', '.join(KEYS)}")
        return dict(value)
    if isinstance(value, Sequence | np.ndarray) and not isinstance(value, str) and len(value) == 3:
        return dict(zip(KEYS, value, strict=False))
    raise TrundleError(f"parameters: {name} = {value!r}: give a number, (start, lower, upper), or a dict")


def parse_number(name: str, key: str, value: Any) -> float:
    """Convert a value to float; the error names the parameter and the key."""
    try:
        found = float(value)
    except (TypeError, ValueError):
        found = math.nan
    if math.isnan(found):
        raise TrundleError(f"parameters: {name}: {key} = {value!r}: must be a number")
    return found
