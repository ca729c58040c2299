"""Markers and transforms, from which Foxglove and RViz draw a recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from trundle._native import Recording, TrundleError
from trundle.viewing.recorded import close, parse_shape, recorded_episodes
from trundle.viewing.scene import Arrow, Floats, Shape, metres_per_newton

__all__ = ["MARKERS", "TRANSFORMS", "Marker", "arrow_markers", "marker_array", "scene_markers", "transforms"]

MARKERS = "visualization_msgs/msg/MarkerArray"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
Colour = tuple[float, float, float, float]

OUTLINE: Colour = (0.78, 0.82, 0.85, 1.0)
OBSTACLE: Colour = (0.55, 0.58, 0.63, 1.0)
FORCE: Colour = (1.0, 0.6, 0.34, 1.0)
LINE_M, FOOT_M, SHAFT_M, HEAD_M = 0.01, 0.04, 0.02, 0.05
"""Widths of lines and arrows, m, for an object of 1 m."""


@dataclass(frozen=True)
class Marker:
    """A shape in Foxglove's 3D panel.

    Attributes
    ----------
    namespace, number : str, int
        Identity: a later marker with the same identity replaces an earlier one.
    kind : {"LINE_STRIP", "SPHERE_LIST", "ARROW"}
    frame : str
        Frame of the points; the marker moves with it.
    points : (n, 2) array
        Corners, centres, or the two ends of an arrow, m.
    scale : (x, y, z)
        Width of a line, diameter of a sphere, or diameters of an arrow's shaft and head and the length of
        its head, m.
    colour : (r, g, b, a)
        From 0 to 1.
    """

    namespace: str
    number: int
    kind: Literal["LINE_STRIP", "SPHERE_LIST", "ARROW"]
    frame: str
    points: Floats
    scale: tuple[float, float, float]
    colour: Colour


def scene_markers(metadata: Mapping[str, Any]) -> list[Marker]:
    """Return the outlines and support points of the object, and the obstacles, of `recording.toml`."""
    shape = parse_shape(metadata["object"])
    line = (LINE_M * (shape.size or 1.0), 0.0, 0.0)
    found = [
        Marker("outline", number, "LINE_STRIP", "object", outline, line, OUTLINE)
        for number, outline in enumerate(shape.outline)
    ]
    if len(shape.feet):
        size = FOOT_M * (shape.size or 1.0)
        found.append(Marker("feet", 0, "SPHERE_LIST", "object", shape.feet, (size, size, size), OUTLINE))
    obstacles = metadata.get("scene", {}).get("obstacle", ())
    return found + [
        Marker("obstacle", number, "LINE_STRIP", "world", close(each["polygon"]), line, OBSTACLE)
        for number, each in enumerate(obstacles)
    ]


def arrow_markers(recording: Recording) -> dict[str, dict[float, Marker]]:
    """Return the tared force on the object as an arrow, by episode and time, s.

    The result is empty for a recording whose wrench cannot be tared or transformed to the object.
    """
    try:
        episodes = recorded_episodes(recording)
    except TrundleError:
        return {}
    scale = metres_per_newton(episodes)
    return {each.name: episode_arrows(each.arrows["measured"], each.shape, scale) for each in episodes}


def episode_arrows(measured: Arrow, shape: Shape, scale: float) -> dict[float, Marker]:
    """Return the arrows of an episode by time, s; `scale` is their length, m/N."""
    size = shape.size or 1.0
    widths = (SHAFT_M * size, HEAD_M * size, HEAD_M * size)
    tips = measured.point + measured.wrench[:, :2] * scale
    return {
        t: Marker("force", 0, "ARROW", "object", np.array([foot, tip]), widths, FORCE)
        for t, foot, tip in zip(measured.t.tolist(), measured.point, tips, strict=True)
    }


def marker_array(make: Mapping[str, Any], stamp: Any, markers: Sequence[Marker]) -> Any:
    """Return the message of markers; `make` contains the message types, `stamp` is their time."""
    return make[MARKERS]([_marker(make, stamp, each) for each in markers])


def _marker(make: Mapping[str, Any], stamp: Any, marker: Marker) -> Any:
    point = make["geometry_msgs/msg/Point"]
    kind = make["visualization_msgs/msg/Marker"]
    pose = make["geometry_msgs/msg/Pose"](point(0.0, 0.0, 0.0), _quaternion(make, 1.0, 0.0, 0.0, 0.0))
    image = make["sensor_msgs/msg/CompressedImage"]
    header = make["std_msgs/msg/Header"]
    nothing = np.zeros(0, dtype=np.uint8)
    return kind(
        header=header(stamp, marker.frame),
        ns=marker.namespace,
        id=marker.number,
        type=getattr(kind, marker.kind),
        action=kind.ADD,
        pose=pose,
        scale=make["geometry_msgs/msg/Vector3"](*marker.scale),
        color=make["std_msgs/msg/ColorRGBA"](*marker.colour),
        lifetime=make["builtin_interfaces/msg/Duration"](0, 0),
        frame_locked=True,
        points=[point(x, y, 0.0) for x, y in marker.points.tolist()],
        colors=[],
        texture_resource="",
        texture=image(header(stamp, ""), "", nothing),
        uv_coordinates=[],
        text="",
        mesh_resource="",
        mesh_file=make["visualization_msgs/msg/MeshFile"]("", nothing),
        mesh_use_embedded_materials=False,
    )


def transforms(make: Mapping[str, Any], header: Any, child: str, pose: Sequence[float]) -> Any:
    """Return the message that places the frame `child` in that of the header: x, y, z, qw, qx, qy, qz."""
    place = make["geometry_msgs/msg/Transform"](
        make["geometry_msgs/msg/Vector3"](*pose[:3]), _quaternion(make, *pose[3:])
    )
    return make[TRANSFORMS]([make["geometry_msgs/msg/TransformStamped"](header, child, place)])


def _quaternion(make: Mapping[str, Any], w: float, x: float, y: float, z: float) -> Any:
    return make["geometry_msgs/msg/Quaternion"](x, y, z, w)
