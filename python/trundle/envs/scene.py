"""What there is to see of a push: plain values, in metres and radians."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Disc", "HiddenWheel", "Point", "Polygon", "Pose", "Shape", "View"]

Point = tuple[float, float]
Polygon = tuple[Point, ...]
Pose = tuple[float, float, float]
HiddenWheel = tuple[float, float, float, str]
"""A hidden wheel: x, y and the angle it rolls along, object frame, and a label."""


@dataclass(frozen=True)
class Disc:
    """A round part.

    Parameters
    ----------
    centre : pair of float
        In the frame of what it is a part of, m.
    radius : float
        m.
    """

    centre: Point
    radius: float


@dataclass(frozen=True)
class Shape:
    """What an object looks like from above, in its own frame.

    Parameters
    ----------
    fixtures : tuple of polygons and discs
        What it is made of; a polygon is simple and need not be convex.
    wheels : tuple of pairs of float
        Where it stands.
    """

    fixtures: tuple[Polygon | Disc, ...]
    wheels: tuple[Point, ...] = ()

    @property
    def reach(self) -> float:
        """How far it extends ahead, along its x, m."""
        ends = [p.centre[0] + p.radius if isinstance(p, Disc) else max(p)[0] for p in self.fixtures]
        return max(ends, default=0.0)


@dataclass(frozen=True)
class View:
    """What there is to see; nothing of it is hidden but `revealed`.

    What stays for an episode is drawn once and kept, which needs tuples: a list is not hashable.

    Parameters
    ----------
    object : triple of float
        Pose in the world.
    goal : triple of float or None
        Pose that the object is to reach.
    shape : Shape
        What the object looks like.
    obstacles : tuple of polygons
        Simple, in the world.
    path : tuple of pairs of float
        The line to be followed.
    gripper : triple of float or None
        Pose in the world.
    holds : bool
        Whether the gripper grasps; else it touches with a tip.
    wrench : triple of float
        At the gripper, in its axes: N, N, N m.
    trail : tuple of pairs of float
        Where the object has been.
    arena : float
        Half the side of the square, m.
    force_scale : float
        The force, N, whose arrow is 0.8 m long; 0.4 m times it is the torque of three quarters of a turn.
    revealed : tuple of (x, y, angle, label)
        Hidden wheels, object frame, where they may be shown.
    """

    object: Pose
    shape: Shape
    goal: Pose | None = None
    obstacles: tuple[Polygon, ...] = ()
    path: tuple[Point, ...] = ()
    gripper: Pose | None = None
    holds: bool = True
    wrench: tuple[float, float, float] = (0.0, 0.0, 0.0)
    trail: tuple[Point, ...] = ()
    arena: float = 2.5
    force_scale: float = 100.0
    revealed: tuple[HiddenWheel, ...] = ()
