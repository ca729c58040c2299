"""Units of columns whose names have none: the SI unit if the values agree with it, else a question."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trundle.importers.layout import Floats
from trundle.importers.units import UNITS

__all__ = ["UnitGuess", "guess_time_unit", "guess_unit"]

MAX_POSITION_M = 20.0
"""Larger positions without a unit are probably not in metres."""
MAX_WRAPPED_RAD = 2.0 * np.pi + 1e-6
"""Larger angles without a unit are unwrapped radians, or degrees."""
MAX_FORCE_N = 2000.0
"""Larger forces without a unit are probably not in newtons."""
MAX_LEVER_ARM_M = 5.0
"""Largest ratio of torque to force of a wrench in N m."""
EPOCH_S = (1.0e9, 3.0e9)
"""Range of Unix time, s: from 2001 to 2065."""
MAX_PERIOD_S = 0.2
"""Longest sample period of a time in seconds."""


@dataclass(frozen=True)
class UnitGuess:
    """A unit, or the choices if the values do not decide it.

    Attributes
    ----------
    unit : str or None
    basis : str
        What the unit rests on, or why it is not decided.
    choices : tuple of str
        Units in the order of probability; empty if `unit` is decided.
    """

    unit: str | None
    basis: str
    choices: tuple[str, ...] = ()


def guess_unit(dimension: str, values: Floats, lever: float = 0.0) -> UnitGuess:
    """Return the unit of a length, angle, force or torque without one in its name.

    Parameters
    ----------
    dimension : str
        As in `UNITS`.
    values : (n,) array
        Finite values of the column.
    lever : float
        Ratio of the largest torque to the largest force, for a torque.
    """
    units = UNITS[dimension]
    largest = float(np.max(np.abs(values), initial=0.0))
    si = next(iter(units))
    limits = {"length": MAX_POSITION_M, "angle": MAX_WRAPPED_RAD, "force": MAX_FORCE_N}
    doubtful = lever > MAX_LEVER_ARM_M if dimension == "torque" else largest > limits.get(dimension, np.inf)
    if doubtful:
        others = {"length": ("mm", "cm", "m"), "angle": ("deg", "rad"), "torque": ("N mm", "N cm", "N m")}
        choices = others.get(dimension, (si, *(unit for unit in units if unit != si)))
        return UnitGuess(None, f"no unit in the name, and values reach {largest:.4g}", choices)
    return UnitGuess(si, f"no unit in the name; {si}, because values reach {largest:.3g}")


def guess_time_unit(values: Floats) -> UnitGuess:
    """Return the unit of times without one in their name, from Unix time or from the sample period."""
    largest = float(np.max(np.abs(values), initial=0.0))
    for unit, size in UNITS["time"].items():
        if EPOCH_S[0] < largest * size < EPOCH_S[1] and (unit != "s" or _period(values) <= MAX_PERIOD_S):
            return UnitGuess(unit, f"no unit in the name; {unit}, because the values are Unix time")
    period = _period(values)
    if 1e-5 <= period <= MAX_PERIOD_S:
        return UnitGuess("s", f"no unit in the name; s, because the samples are {period:.3g} apart")
    likely = "ms" if period < 1e3 else "us" if period < 1e6 else "ns"
    others = tuple(unit for unit in UNITS["time"] if unit != likely)
    return UnitGuess(None, f"no unit in the name, and the samples are {period:.4g} apart", (likely, *others))


def _period(values: Floats) -> float:
    steps = np.abs(np.diff(values))
    steps = steps[steps > 0]
    return float(np.median(steps)) if len(steps) else float("inf")
