"""A caller's own simulator as the simulation under test: what is told of its parameters."""

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
    """What is known of a parameter; only `start` must be there."""

    start: float
    """Where the fit begins."""
    lower: float
    """Smallest value that makes sense; 0 if left out and `start` is positive."""
    upper: float
    """Largest value that makes sense."""
    sd: float
    """Standard deviation of what you believe, in the parameter's unit."""
    unit: str


Parameters: TypeAlias = "Mapping[str, float | Sequence[float] | Parameter]"

KEYS = ("start", "lower", "upper", "sd", "unit")


def parse_parameters(parameters: Parameters | None) -> tuple[list[dict[str, Any]], bool]:
    """Return each parameter with its bounds, and whether all are numbers that the simulation is used with."""
    if not isinstance(parameters, Mapping):
        raise TrundleError("step: name the parameters of your simulator, as parameters={'mass': 20.0, ...}")
    given = bool(parameters) and all(is_number(value) for value in parameters.values())
    return [parse_parameter(str(name), value) for name, value in parameters.items()], given


def is_number(value: object) -> bool:
    """Tell whether a value is one number."""
    return isinstance(value, int | float | np.integer | np.floating)


def parse_parameter(name: str, value: Any) -> dict[str, Any]:
    """Return a parameter as the native half reads it, checked."""
    told = to_table(name, value)
    start = parse_number(name, "start", told.get("start"))
    positive = start > 0.0 and "lower" not in told
    lower = 0.0 if positive else parse_number(name, "lower", told.get("lower", -math.inf))
    upper = parse_number(name, "upper", told.get("upper", math.inf))
    sd = None if told.get("sd") is None else parse_number(name, "sd", told["sd"])
    if not lower <= start <= upper or lower >= upper:
        raise TrundleError(f"parameters: {name} = {start}: must lie in [{lower}, {upper}]")
    if sd is not None and not (sd > 0.0 and (lower < 0.0 or start > 0.0)):
        raise TrundleError(
            f"parameters: {name}: sd = {sd} must be positive, and so the start of a positive one"
        )
    if sd is None and not (math.isfinite(lower) and math.isfinite(upper)) and start <= 0.0:
        raise TrundleError(
            f"parameters: {name} = {start}: tell how far it may be off, as (start, lower, upper) or "
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
        "unit": told.get("unit", ""),
    }


def to_table(name: str, value: Any) -> dict[str, Any]:
    """Return a description as a dict: from a number, (start, lower, upper), or a dict."""
    if is_number(value):
        return {"start": value}
    if isinstance(value, Mapping):
        unknown = [key for key in value if key not in KEYS]
        if unknown or "start" not in value:
            wrong = f"there is no {unknown[0]!r}" if unknown else "`start` is missing"
            raise TrundleError(f"parameters: {name}: {wrong}; known are {', '.join(KEYS)}")
        return dict(value)
    if isinstance(value, Sequence | np.ndarray) and not isinstance(value, str) and len(value) == 3:
        return dict(zip(KEYS, value, strict=False))
    raise TrundleError(f"parameters: {name} = {value!r}: give a number, (start, lower, upper), or a dict")


def parse_number(name: str, key: str, value: Any) -> float:
    """Return a number, or say which is none."""
    try:
        found = float(value)
    except (TypeError, ValueError):
        found = math.nan
    if math.isnan(found):
        raise TrundleError(f"parameters: {name}: {key} = {value!r} is no number")
    return found
