"""Contents of a picture of a push, in metres and radians."""

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
    """A disc.

    Parameters
    ----------
    centre : pair of float
        Centre in the frame of the shape, m.
    radius : float
        Radius, m.
    """

    centre: Point
    radius: float


@dataclass(frozen=True)
class Shape:
    """Top view of an object in its own frame.

    Parameters
    ----------
    fixtures : tuple of polygons and discs
        Parts of the object. Polygons are simple and may be concave.
    wheels : tuple of pairs of float
        Positions of the wheels.
    """

    fixtures: tuple[Polygon | Disc, ...]
    wheels: tuple[Point, ...] = ()

    @property
    def reach(self) -> float:
        """Maximum x of the object, m."""
        ends = [p.centre[0] + p.radius if isinstance(p, Disc) else max(p)[0] for p in self.fixtures]
        return max(ends, default=0.0)


@dataclass(frozen=True)
class View:
    """Contents of a picture. Only `revealed` is hidden from the agent.

    Fields are tuples because drawings of the static parts are cached, which needs hashable values.

    Parameters
    ----------
    object : triple of float
        Pose in the world.
    goal : triple of float or None
        Goal pose of the object.
    shape : Shape
        Shape of the object.
    obstacles : tuple of polygons
        Simple polygons in the world.
    path : tuple of pairs of float
        Path to follow.
    gripper : triple of float or None
        Pose in the world.
    holds : bool
        Whether the gripper grasps the object; else it is a point contact.
    wrench : triple of float
        Wrench at the gripper in gripper axes: N, N, N m.
    trail : tuple of pairs of float
        Past positions of the object.
    arena : float
        Half the side of the square, m.
    force_scale : float
        Force, N, with an arrow of 0.8 m. This force times 0.4 m is the torque with an arrow of 270°.
    revealed : tuple of (x, y, angle, label)
        Hidden wheels to show, object frame.
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
