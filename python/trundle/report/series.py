"""The curves of a report as arrays. Absent values are NaN, absent curves are None."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["Array", "Episode", "Residual", "Series", "Wrench", "finite", "held_out_first", "pose_error"]

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Residual:
    """Missing wrench on the object, object axes: time (n,) in s; other arrays (n, 3) in N, N, N·m."""

    t: Array
    before: Array | None
    after: Array | None
    sd: Array | None
    sd_after: Array | None = None


@dataclass(frozen=True)
class Wrench:
    """Recorded and required wrench of a quasi-static push, object axes; units as in `Residual`."""

    t: Array
    recorded: Array
    before: Array | None
    after: Array | None


@dataclass(frozen=True)
class Episode:
    """One episode: time (n,) in s; poses (n, 3), world frame, x, y in m, theta in rad.

    `before` and `after` are open-loop simulations without and with the missing effects.
    """

    name: str
    held_out: bool
    contact: float
    t: Array
    observed: Array
    before: Array | None
    after: Array | None
    residual: Residual | None
    wrench: Wrench | None


@dataclass(frozen=True)
class Series:
    """The curves of a diagnosis. Footprint polygons and support points are (k, 2), object frame, in m.

    `discrepancy_inputs` describes the inputs of the model discrepancy, if the model "after" contains one.
    `is_black_box` tells that a caller's `step` function simulates the motion.
    """

    footprint: tuple[Array, ...]
    support: Array
    dof: tuple[str, ...]
    quasi_static: bool
    episodes: tuple[Episode, ...]
    discrepancy_inputs: tuple[str, ...] = ()
    is_black_box: bool = False

    @property
    def channels(self) -> tuple[int, ...]:
        """Indices of the axes along which the object moves: 0 x, 1 y, 2 theta."""
        return tuple(index for index, name in enumerate(("x", "y", "theta")) if name in self.dof)

    @property
    def feet(self) -> list[Array]:
        """Support points as a list of one array; an empty list if they are unknown."""
        return [self.support] if len(self.support) else []

    @property
    def pushes(self) -> str:
        """Name of the episodes in the report: "pushes", or "runs" on a rail."""
        return "pushes" if "theta" in self.dof else "runs"

    @classmethod
    def parse(cls, given: Mapping[str, Any], single: bool = False) -> Series:
        """Parse lists or arrays, in which any value may be None or NaN.

        Parameters
        ----------
        given
            The `series` of a diagnosis.
        single
            There is one simulation: use "after", or "before" where "after" is absent.
        """
        polygons = [_table(polygon, 2) for polygon in _or_empty(given.get("footprint"))]
        return cls(
            footprint=tuple(polygon for polygon in polygons if len(polygon) and np.isfinite(polygon).all()),
            support=_table(_or_empty(given.get("support")), 2),
            dof=tuple(given.get("dof") or ("x", "y", "theta")),
            quasi_static=bool(given.get("quasi_static")),
            episodes=tuple(_episode(episode, single) for episode in given.get("episodes") or ()),
            discrepancy_inputs=tuple(str(text) for text in given.get("unnamed") or ()),
            is_black_box=bool(given.get("black_box")),
        )


def finite(value: object) -> float | None:
    """Return a finite number as a float; None for anything else."""
    if isinstance(value, bool) or not isinstance(value, int | float | np.floating | np.integer):
        return None
    return float(value) if np.isfinite(value) else None


def held_out_first(episodes: Sequence[Episode]) -> list[Episode]:
    """Return held-out episodes, then training episodes, each in the given order."""
    return sorted(episodes, key=lambda episode: not episode.held_out)


def pose_error(episode: Episode, curve: Array, on_rail: bool) -> tuple[Array, Array]:
    """Return distance (signed on a rail), m, and angle in [0, pi], rad, from the recorded pose, (n,) each."""
    gap = curve - episode.observed
    angle = np.abs(np.arctan2(np.sin(gap[:, 2]), np.cos(gap[:, 2])))
    return gap[:, 0] if on_rail else np.hypot(gap[:, 0], gap[:, 1]), angle


def _episode(given: Mapping[str, Any], single: bool) -> Episode:
    contact = finite(given.get("contact"))
    before, after = _sides(given, single)
    return Episode(
        name=str(given.get("name", "")),
        held_out=bool(given.get("held_out")),
        contact=np.nan if contact is None else contact,
        t=_vector(given.get("t")),
        observed=_table(_or_empty(given.get("observed")), 3),
        before=before,
        after=after,
        residual=_residual(given.get("residual"), single),
        wrench=_wrench(given.get("wrench"), single),
    )


def _residual(given: Mapping[str, Any] | None, single: bool) -> Residual | None:
    if not given:
        return None
    return Residual(
        _vector(given.get("t")),
        *_sides(given, single),
        _curve(given.get("sd")),
        _curve(given.get("sd_after")),
    )


def _wrench(given: Mapping[str, Any] | None, single: bool) -> Wrench | None:
    if not given:
        return None
    recorded = _table(_or_empty(given.get("recorded")), 3)
    return Wrench(_vector(given.get("t")), recorded, *_sides(given, single))


def _sides(given: Mapping[str, Any], single: bool) -> tuple[Array | None, Array | None]:
    """Return the curves before and after; with `single`, the one that exists as the curve after."""
    before, after = _curve(given.get("before")), _curve(given.get("after"))
    return (None, before if after is None else after) if single else (before, after)


def _or_empty(given: Any) -> Any:
    return () if given is None else given


def _vector(given: Any) -> Array:
    return np.asarray(_or_empty(given), dtype=np.float64).reshape(-1)


def _table(given: Any, columns: int) -> Array:
    """Return an array (n, columns); a row that is None becomes a row of NaN."""
    if isinstance(given, np.ndarray):
        rows: Any = given
    else:
        rows = [[np.nan] * columns if row is None else row for row in given]
    return np.asarray(rows, dtype=np.float64).reshape(-1, columns)


def _curve(given: Any) -> Array | None:
    table = _table(_or_empty(given), 3)
    return table if np.isfinite(table).any() else None
