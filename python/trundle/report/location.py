"""Locations of effects: the `where` of diagnosis.json as points, regions, directions and events."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from trundle.report import wording
from trundle.report.quantity import format_estimate, format_fixed
from trundle.report.series import Array, finite

__all__ = [
    "Direction",
    "Event",
    "Place",
    "Point",
    "describe_region",
    "finite_pair",
    "locate_effects",
    "polygon",
]


@dataclass(frozen=True)
class Point:
    """An estimated point: mean (2,) and standard deviation (2,), m; the latter is zero if not stated."""

    mean: Array
    sd: Array

    def __str__(self) -> str:
        (x, y), (sx, sy) = self.mean, self.sd
        return f"({format_estimate(x, sx)}, {format_estimate(y, sy)})\N{NO-BREAK SPACE}m"


@dataclass(frozen=True)
class Event:
    """An instant: episode, time in its table, s, and standard deviation, s (None if not stated)."""

    episode: str
    time: float
    sd: float | None

    def __str__(self) -> str:
        return f"in {self.episode} at {format_estimate(self.time, self.sd)}\N{NO-BREAK SPACE}s"


@dataclass(frozen=True)
class Direction:
    """A direction in the world: unit vector (2,), and whether it is an axis without a sense (`both`)."""

    along: Array
    both: bool
    text: str


@dataclass(frozen=True)
class Place:
    """Location of one missing effect.

    Attributes
    ----------
    number
        Number of the effect's card, from 1.
    name
        Name of the effect in the report.
    body, world
        Point in the object frame and in the world.
    region
        Polygon (n, 2) on the floor, m.
    event, direction
        When, and along which direction.
    unknown
        Beginnings of sentences on points that the data do not determine.
    """

    number: int
    name: str
    body: Point | None = None
    world: Point | None = None
    region: Array | None = None
    event: Event | None = None
    direction: Direction | None = None
    unknown: tuple[str, ...] = ()

    @property
    def on_floor(self) -> bool:
        """Whether the effect has a mark on the map of the floor."""
        return any(part is not None for part in (self.world, self.region, self.event, self.direction))

    def sentences(self) -> list[str]:
        """Return one sentence for each part of the location."""
        found = [f"{start} a point that the data do not determine." for start in self.unknown]
        if self.body is not None:
            found.append(f"On the object at {self.body}.")
        if self.world is not None:
            found.append(f"In the world at {self.world}.")
        if self.region is not None:
            found.append(f"On the floor in {describe_region(self.region)}.")
        if self.event is not None:
            found.append(f"{wording.capitalise(str(self.event))}.")
        return found + ([] if self.direction is None else [f"{self.direction.text}."])


def locate_effects(missing: Sequence[Mapping[str, Any]]) -> list[Place]:
    """Return the location of each entry of `missing`, in the given order."""
    return [_place(number, effect) for number, effect in enumerate(missing, 1)]


def _place(number: int, effect: Mapping[str, Any]) -> Place:
    given = effect.get("where")
    where: Mapping[str, Any] = given if isinstance(given, Mapping) else {}
    named = (("body_point", "On the object at"), ("world_point", "In the world at"))
    return Place(
        number,
        wording.effect_name(effect.get("effect")),
        _point(where.get("body_point")),
        _point(where.get("world_point")),
        polygon(where.get("world_region")),
        _event(where.get("event")),
        _direction(effect),
        tuple(start for key, start in named if key in where and _point(where[key]) is None),
    )


def finite_pair(given: object) -> Array | None:
    """Return two finite numbers as an array (2,); None for anything else."""
    if not isinstance(given, Sequence | np.ndarray) or isinstance(given, str) or len(given) != 2:
        return None
    numbers = [finite(value) for value in given]
    return None if None in numbers else np.array(numbers, dtype=np.float64)


def polygon(given: object) -> Array | None:
    """Return a polygon (n, 2) of at least three corners; None for anything else."""
    if not isinstance(given, Sequence | np.ndarray) or isinstance(given, str):
        return None
    corners = [corner for corner in map(finite_pair, given) if corner is not None]
    return np.array(corners) if len(corners) >= 3 and len(corners) == len(given) else None


def describe_region(corners: Array) -> str:
    """Return a phrase on the size and the centre of a region (n, 2)."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    size, middle = (
        [format_fixed(value, 2) for value in values] for values in (high - low, (low + high) / 2.0)
    )
    gap = "\N{NO-BREAK SPACE}"
    return f"a region of {' by '.join(size)}{gap}m about ({', '.join(middle)}){gap}m"


def _point(given: object) -> Point | None:
    if not isinstance(given, Mapping) or (mean := finite_pair(given.get("mean"))) is None:
        return None
    sd = finite_pair(given.get("sd"))
    return Point(mean, np.zeros(2) if sd is None else sd)


def _event(given: object) -> Event | None:
    if not isinstance(given, Mapping) or not isinstance(given.get("time"), Mapping):
        return None
    time = finite(given["time"].get("mean"))
    return None if time is None else Event(str(given.get("episode")), time, finite(given["time"].get("sd")))


def _direction(effect: Mapping[str, Any]) -> Direction | None:
    """Return the direction of a sloping or grained floor; None for other effects."""
    given = effect.get("parameters") or {}
    means = {name: finite(value.get("mean")) for name, value in given.items() if isinstance(value, Mapping)}
    kind = effect.get("effect")
    if kind == "floor_grain" and (angle := means.get("angle")) is not None:
        along = np.array([np.cos(angle), np.sin(angle)])
        return Direction(along, True, "The floor resists along the arrow on the map")
    slope = finite_pair([means.get("accel_x"), means.get("accel_y")]) if kind == "floor_slope" else None
    if slope is None or not np.hypot(*slope) > 0.0:
        return None
    return Direction(slope / np.hypot(*slope), False, "The arrow on the map points downhill")
