"""Samples that are held until the next one, such as commands and switches."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["TIME_TOLERANCE", "held_means"]

Floats = NDArray[np.float64]

TIME_TOLERANCE = 1e-3
"""Share of the interval between samples by which a time may precede a sample and still have its value.

Clocks of simulations accumulate rounding errors."""


def held_means(times: Floats, values: Floats, t: Floats) -> Floats:
    """Return the means of held samples over the interval from each of uniform times to the next.

    A simulation that holds such a mean exerts the impulse of the recorded command, also where the uniform
    times are a little before those of the samples.

    Parameters
    ----------
    times, values : (K,) arrays
        Samples. The first value also holds before its time.
    t : (T,) array
        Uniform times, s.

    Examples
    --------
    >>> import numpy as np
    >>> from trundle.held_samples import held_means
    >>> held_means(np.array([0.0, 1.0, 2.0]), np.array([3.0, 5.0, 1.0]), np.array([0.0, 1.0 - 1e-9])).round(6)
    array([3., 5.])
    """
    interval = (t[-1] - t[0]) / (len(t) - 1) if len(t) > 1 else 0.0
    edges = np.r_[t, t[-1] + interval]
    rows = np.clip(np.searchsorted(times, edges, side="right") - 1, 0, None)
    held: Floats = values[rows]
    if not interval:
        return held[: len(t)]
    integral = np.r_[0.0, np.cumsum(values[:-1] * np.diff(times))]
    impulses = np.diff(integral[rows] + held * (edges - times[rows]))
    # Where no sample begins within the interval, its value is exact.
    means: Floats = np.where(np.diff(rows) > 0, impulses / np.diff(edges), held[: len(t)])
    return means
