"""Where and when effects act: the `where` of diagnosis.json as points, regions, directions and moments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from trundle.report import words
from trundle.report.given import Array, finite
from trundle.report.quantity import fixed, measured

__all__ = ["Direction", "Event", "Place", "Spot", "extent", "pair", "places", "region"]


@dataclass(frozen=True)
class Spot:
    """A point: mean (2,) and standard deviation (2,) m (zero where not stated)."""

    mean: Array
    sd: Array

    def __str__(self) -> str:
        (x, y), (sx, sy) = self.mean, self.sd
        return f"({measured(x, sx)}, {measured(y, sy)})\N{NO-BREAK SPACE}m"


@dataclass(frozen=True)
class Event:
    """A moment: episode, the table's time s, its standard deviation (None where not stated)."""

    episode: str
    time: float
    sd: float | None

    def __str__(self) -> str:
        return f"in {self.episode} at {measured(self.time, self.sd)}\N{NO-BREAK SPACE}s"


@dataclass(frozen=True)
class Direction:
    """A direction in the world: unit vector (2,); along both ways where it has no sense of its own."""

    along: Array
    both: bool
    words: str


@dataclass(frozen=True)
class Place:
    """Where one missing effect acts; `number` is that of its card, from 1."""

    number: int
    name: str
    body: Spot | None = None
    world: Spot | None = None
    region: Array | None = None
    event: Event | None = None
    direction: Direction | None = None
    unknown: tuple[str, ...] = ()

    @property
    def on_floor(self) -> bool:
        """Whether a map of the floor has something to mark."""
        return any(part is not None for part in (self.world, self.region, self.event, self.direction))

    def sentences(self) -> list[str]:
        """Return the places in words, one sentence each."""
        found = [f"{start} a place that the data do not hold." for start in self.unknown]
        if self.body is not None:
            found.append(f"On the object at {self.body}.")
        if self.world is not None:
            found.append(f"In the world at {self.world}.")
        if self.region is not None:
            found.append(f"On the floor in {extent(self.region)}.")
        if self.event is not None:
            found.append(f"{words.capitalised(str(self.event))}.")
        return found + ([] if self.direction is None else [f"{self.direction.words}."])


def places(missing: Sequence[Mapping[str, Any]]) -> list[Place]:
    """Return where each missing effect acts, in the order given."""
    return [_place(number, effect) for number, effect in enumerate(missing, 1)]


def _place(number: int, effect: Mapping[str, Any]) -> Place:
    given = effect.get("where")
    where: Mapping[str, Any] = given if isinstance(given, Mapping) else {}
    named = (("body_point", "On the object at"), ("world_point", "In the world at"))
    return Place(
        number,
        words.effect(effect.get("effect")),
        _spot(where.get("body_point")),
        _spot(where.get("world_point")),
        region(where.get("world_region")),
        _event(where.get("event")),
        _direction(effect),
        tuple(start for key, start in named if key in where and _spot(where[key]) is None),
    )


def pair(given: object) -> Array | None:
    """Return two finite numbers as an array (2,), or None."""
    if not isinstance(given, Sequence | np.ndarray) or isinstance(given, str) or len(given) != 2:
        return None
    numbers = [finite(value) for value in given]
    return None if None in numbers else np.array(numbers, dtype=np.float64)


def region(given: object) -> Array | None:
    """Return a polygon (n, 2) of three corners at least, or None."""
    if not isinstance(given, Sequence | np.ndarray) or isinstance(given, str):
        return None
    corners = [corner for corner in map(pair, given) if corner is not None]
    return np.array(corners) if len(corners) >= 3 and len(corners) == len(given) else None


def extent(corners: Array) -> str:
    """Return size and middle of a region (n, 2) in words."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    size, middle = ([fixed(value, 2) for value in values] for values in (high - low, (low + high) / 2.0))
    gap = "\N{NO-BREAK SPACE}"
    return f"a region of {' by '.join(size)}{gap}m about ({', '.join(middle)}){gap}m"


def _spot(given: object) -> Spot | None:
    if not isinstance(given, Mapping) or (mean := pair(given.get("mean"))) is None:
        return None
    sd = pair(given.get("sd"))
    return Spot(mean, np.zeros(2) if sd is None else sd)


def _event(given: object) -> Event | None:
    if not isinstance(given, Mapping) or not isinstance(given.get("time"), Mapping):
        return None
    time = finite(given["time"].get("mean"))
    return None if time is None else Event(str(given.get("episode")), time, finite(given["time"].get("sd")))


def _direction(effect: Mapping[str, Any]) -> Direction | None:
    """Return the direction that the parameters of an effect of the floor name."""
    given = effect.get("parameters") or {}
    held = {name: finite(value.get("mean")) for name, value in given.items() if isinstance(value, Mapping)}
    kind = effect.get("effect")
    if kind == "floor_grain" and (angle := held.get("angle")) is not None:
        along = np.array([np.cos(angle), np.sin(angle)])
        return Direction(along, True, "The floor resists along the arrow on the map")
    slope = pair([held.get("accel_x"), held.get("accel_y")]) if kind == "floor_slope" else None
    if slope is None or not np.hypot(*slope) > 0.0:
        return None
    return Direction(slope / np.hypot(*slope), False, "The arrow on the map points downhill")
