"""Drives of a simulated mechanism: recorded efforts, and controllers of position."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trundle._native import TrundleError
from trundle.display.card import Card, Displayed
from trundle.held_samples import TIME_TOLERANCE

__all__ = ["Drive", "EffortDrive", "PositionDrive", "SwitchedDrive"]

Floats = NDArray[np.float64]


class Drive(Protocol):
    """What exerts efforts on the recorded joints."""

    def __call__(self, t: float, q: Floats, v: Floats) -> tuple[Floats, Floats]:
        """Return effort and damping, (n,) each: the drive exerts effort - damping·v.

        The damping is a part of its own so that the simulation can be implicit in it.
        """
        ...


class EffortDrive(Displayed):
    """Efforts given over time.

    Parameters
    ----------
    times : (K,) array_like
        Strictly increasing, s.
    efforts : (K, n) array_like
        N·m or N. Before the first and after the last time, the nearest value acts.
    hold : bool
        Whether a value acts until the next time, as for commands. Otherwise values are interpolated.

    Examples
    --------
    >>> import numpy as np
    >>> from trundle.mechanism import EffortDrive
    >>> drive = EffortDrive([0.0, 1.0], [[0.0], [2.0]])
    >>> float(drive(0.25, np.zeros(1), np.zeros(1))[0][0])
    0.5
    """

    def __init__(self, times: ArrayLike, efforts: ArrayLike, *, hold: bool = False) -> None:
        self.series = Series(times, efforts, hold)

    def _card(self) -> Card:
        return Card("trundle.mechanism.EffortDrive", [self.series.fact()])

    def __call__(self, t: float, q: Floats, v: Floats) -> tuple[Floats, Floats]:
        """Return the effort at a time, without damping."""
        effort = self.series(t)
        return effort, np.zeros_like(effort)


class PositionDrive(Displayed):
    """A controller of position: effort = stiffness·(target - q) - damping·v, limited.

    Parameters
    ----------
    times : (K,) array_like
        Strictly increasing, s.
    targets : (K, n) array_like
        Rad or m, each held until the next.
    stiffness, damping : (n,) array_like
        N·m/rad and N·m·s/rad, or N/m and N·s/m.
    limit : (n,) array_like
        Largest effort, infinite by default.

    Examples
    --------
    >>> import numpy as np
    >>> from trundle.mechanism import PositionDrive
    >>> servo = PositionDrive([0.0], [[1.0]], stiffness=[30.0], damping=[2.0], limit=[10.0])
    >>> servo(0.0, np.array([0.9]), np.zeros(1))  # within the limit
    (array([3.]), array([2.]))
    >>> servo(0.0, np.array([0.0]), np.zeros(1))  # saturated
    (array([10.]), array([0.]))
    """

    def __init__(
        self,
        times: ArrayLike,
        targets: ArrayLike,
        stiffness: ArrayLike,
        damping: ArrayLike,
        limit: ArrayLike = np.inf,
    ) -> None:
        self.series = Series(times, targets, hold=True)
        self.stiffness, self.damping = np.asarray(stiffness, float), np.asarray(damping, float)
        self.limit = np.asarray(limit, float)

    def _card(self) -> Card:
        gains = [("stiffness", str(self.stiffness.tolist())), ("damping", str(self.damping.tolist()))]
        return Card("trundle.mechanism.PositionDrive", [self.series.fact(), *gains])

    def __call__(self, t: float, q: Floats, v: Floats) -> tuple[Floats, Floats]:
        """Return effort and damping, which is zero where the drive is saturated."""
        effort = self.stiffness * (self.series(t) - q)
        wanted = effort - self.damping * v
        free = np.abs(wanted) <= self.limit
        limited = np.clip(wanted, -self.limit, self.limit)
        return np.where(free, effort, limited), np.where(free, self.damping, 0.0)


class SwitchedDrive(Displayed):
    """A drive that is switched on and off; off, it exerts nothing.

    Parameters
    ----------
    drive : callable
        The drive while it is on.
    times : (K,) array_like
        Strictly increasing, s.
    on : (K, n) array_like
        0 or 1, held until the next time.

    Examples
    --------
    >>> import numpy as np
    >>> from trundle.mechanism import EffortDrive, SwitchedDrive
    >>> drive = SwitchedDrive(EffortDrive([0.0], [[2.0]]), [0.0, 1.0], [[1.0], [0.0]])
    >>> [float(drive(t, np.zeros(1), np.zeros(1))[0][0]) for t in (0.5, 1.5)]
    [2.0, 0.0]
    """

    def __init__(self, drive: Drive, times: ArrayLike, on: ArrayLike) -> None:
        self.drive, self.series = drive, Series(times, on, hold=True)

    def _card(self) -> Card:
        return Card(
            "trundle.mechanism.SwitchedDrive", [("drive", type(self.drive).__name__), self.series.fact()]
        )

    def __call__(self, t: float, q: Floats, v: Floats) -> tuple[Floats, Floats]:
        """Return effort and damping of the drive where it is on."""
        on = self.series(t)
        effort, damping = self.drive(t, q, v)
        return effort * on, damping * on


class Series:
    """Values over time, held or interpolated.

    Raises
    ------
    TrundleError
        If times do not increase, or shapes differ.
    """

    def __init__(self, times: ArrayLike, values: ArrayLike, hold: bool) -> None:
        self.times, self.values = np.asarray(times, float), np.asarray(values, float)
        self.hold = hold
        if self.values.ndim != 2 or self.times.shape != self.values.shape[:1] or not len(self.times):
            raise TrundleError(
                f"times of shape {self.times.shape} and values of shape {self.values.shape}: "
                "give one row of values for each time"
            )
        if not (np.isfinite(self.values).all() and np.all(np.diff(self.times) > 0)):
            raise TrundleError("times must increase, and all values must be finite numbers")
        intervals = np.diff(self.times)
        self.tolerance = TIME_TOLERANCE * float(np.median(intervals)) if hold and len(intervals) else 0.0

    def __call__(self, t: float) -> Floats:
        """Return the values, (n,), at a time."""
        row = int(np.searchsorted(self.times, t + self.tolerance, side="right")) - 1
        if row < 0:
            return self._row(0)
        if self.hold or row + 1 >= len(self.times):
            return self._row(row)
        share = float((t - self.times[row]) / (self.times[row + 1] - self.times[row]))
        mixed: Floats = self.values[row] * (1 - share) + self.values[row + 1] * share
        return mixed

    def fact(self) -> tuple[str, str]:
        """Return the number of times and columns, for a card."""
        count, joints = self.values.shape
        return "values", f"{count} times, {joints} joints, {self.times[0]:g} to {self.times[-1]:g} s"

    def _row(self, row: int) -> Floats:
        values: Floats = self.values[row]
        return values
