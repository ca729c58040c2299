"""What a viewer shows: outlines, motions, arrows, curves and windows, as arrays in SI units.

Outlines, feet, wheels and arrows are in the object frame, m. Poses are (x, y, theta) in the world, m and rad.
Times are those of the episode's table, s.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "RAIL_SIZE_M",
    "Arrow",
    "Curve",
    "Episode",
    "Floats",
    "Motion",
    "Panel",
    "Scene",
    "Shape",
    "Wheel",
    "Window",
    "metres_per_newton",
    "scene_size",
]

Floats: TypeAlias = NDArray[np.float64]

FORCE_LENGTH = 0.6
"""Length of the arrow of the largest measured force, in sizes of the object."""
RAIL_SIZE_M = 0.1
"""Size of the mark of an object without an outline, m."""
FORCE_PERCENTILE = 99.5
"""Percentile of the measured forces that counts as the largest, so that one spike does not change it."""


@dataclass(frozen=True)
class Motion:
    """Poses (n, 3) over time (n,)."""

    t: Floats
    pose: Floats


@dataclass(frozen=True)
class Wheel:
    """A wheel: position (2,), and angle of its x axis, rad, both in the object frame."""

    position: Floats
    angle: float


@dataclass(frozen=True)
class Shape:
    """The object: closed outlines (n, 2), support points (k, 2), wheels, and named points (2,) on it."""

    outline: Sequence[Floats]
    feet: Floats
    wheels: Sequence[Wheel] = ()
    points: Mapping[str, Floats] = field(default_factory=dict)

    @property
    def size(self) -> float:
        """Largest extent of the outlines, m; 0 without an outline (on a rail)."""
        return float(np.ptp(np.concatenate(self.outline), axis=0).max()) if self.outline else 0.0


@dataclass(frozen=True)
class Arrow:
    """A wrench on the object over time (n,).

    Attributes
    ----------
    point : (n, 2) array
        Where the arrow of the force begins.
    wrench : (n, 3) array
        Force and torque about the object's origin, object axes, N, N, N·m.
    """

    t: Floats
    point: Floats
    wrench: Floats


@dataclass(frozen=True)
class Curve:
    """A quantity (n,) over time (n,), its source ("recorded", "before", "after", "missing"), and its name."""

    name: str
    source: str
    t: Floats
    values: Floats


@dataclass(frozen=True)
class Panel:
    """Curves in one plot: the title with the unit, and a key for the entity path."""

    key: str
    title: str
    curves: Sequence[Curve]


@dataclass(frozen=True)
class Window:
    """An interval of an episode, s, and its strength: −log10 of the p-value."""

    start: float
    end: float
    strength: float


@dataclass(frozen=True)
class Episode:
    """One episode.

    Attributes
    ----------
    name : str
    held_out : bool
    contact : float
        Time of first contact, s; NaN if unknown.
    table : mapping of str to (n,) array
        Numeric columns of the recording as stored, `t` first; NaN where a stream has no sample.
    shape : Shape
    motion : Motion
        Of the object.
    gripper : Motion or None
    arrows : mapping of str to Arrow
        Wrenches on the object by name: "measured", or the name of a missing effect.
    models : mapping of str to (Motion, wheels)
        Simulated motions of the object, by name: "before" and "after" the missing effects were added.
    panels : sequence of Panel
    windows : mapping of str to sequence of Window
        Intervals by what they mark: "mismatch" or "residual".
    estimates : sequence of (time, Wheel)
        Wheel that an agent estimates from each time on.
    obstacles : sequence of (k, 2) array
        Closed polygons in the world, m.
    goal : (3,) array or None
        Pose in the world that the object is pushed to.
    """

    name: str
    held_out: bool
    contact: float
    table: Mapping[str, Floats]
    shape: Shape
    motion: Motion
    gripper: Motion | None = None
    arrows: Mapping[str, Arrow] = field(default_factory=dict)
    models: Mapping[str, tuple[Motion, Sequence[Wheel]]] = field(default_factory=dict)
    panels: Sequence[Panel] = ()
    windows: Mapping[str, Sequence[Window]] = field(default_factory=dict)
    estimates: Sequence[tuple[float, Wheel]] = ()
    obstacles: Sequence[Floats] = ()
    goal: Floats | None = None

    @property
    def span(self) -> tuple[float, float]:
        """First and last time, s."""
        t = self.table.get("t", self.motion.t)
        return float(t[0]), float(t[-1])


@dataclass(frozen=True)
class Scene:
    """Episodes in the order in which they are shown, and a summary in Markdown."""

    name: str
    summary: str
    episodes: Sequence[Episode]


def scene_size(episodes: Sequence[Episode]) -> float:
    """Return the size of the largest object, m."""
    return max((episode.shape.size for episode in episodes), default=0.0) or RAIL_SIZE_M


def metres_per_newton(episodes: Sequence[Episode]) -> float:
    """Return the length of an arrow per force, m/N, the same for all episodes."""
    forces = [
        np.hypot(*each.arrows["measured"].wrench[:, :2].T) for each in episodes if "measured" in each.arrows
    ]
    largest = float(np.percentile(np.concatenate(forces), FORCE_PERCENTILE)) if forces else 0.0
    return FORCE_LENGTH * scene_size(episodes) / (largest or 1.0)
