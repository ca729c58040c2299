"""Checks of motions of the recorded joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trundle._native import TrundleError

__all__ = ["check_motion"]

Floats = NDArray[np.float64]


def check_motion(
    joints: Sequence[str], q: ArrayLike, v: ArrayLike, a: ArrayLike
) -> tuple[Floats, Floats, Floats]:
    """Return positions, velocities and accelerations as arrays.

    Raises
    ------
    TrundleError
        If shapes differ or a value is not finite.
    """
    arrays = [np.asarray(each, dtype=float) for each in (q, v, a)]
    for name, values in zip("qva", arrays, strict=True):
        if values.ndim != 2 or values.shape != (len(arrays[0]), len(joints)):
            raise TrundleError(
                f"{name}: shape {values.shape}; q, v and a need one row per sample and {len(joints)} columns"
            )
        if not np.isfinite(values).all():
            row, column = np.argwhere(~np.isfinite(values))[0]
            raise TrundleError(
                f"{name}: row {row}, joint {joints[column]!r}: {values[row, column]} is not a finite number"
            )
    return arrays[0], arrays[1], arrays[2]
