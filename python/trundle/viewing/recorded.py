"""The scene of a recording: the object, the gripper, and the measured wrench."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from trundle.importers.rotations import heading
from trundle.inspection import prepare
from trundle.picture import outlines
from trundle.recording import Recording
from trundle.viewing.scene import Arrow, Curve, Episode, Floats, Motion, Panel, Scene, Shape

__all__ = ["parse_shape", "recorded_episodes", "recorded_scene"]

AXES = ("x", "y")


def recorded_scene(recording: Recording) -> Scene:
    """Return the scene of a recording.

    Raises
    ------
    TrundleError
        If the wrench cannot be tared or transformed to the object.
    """
    episodes = recorded_episodes(recording)
    held_out = sum(each.held_out for each in episodes)
    summary = f"# {recording.name}\n\n{len(episodes)} episodes, {held_out} held out."
    return Scene(recording.name, summary, episodes)


def recorded_episodes(recording: Recording) -> list[Episode]:
    """Return the episodes of a recording in its order."""
    prepared = prepare(recording)
    metadata = recording.metadata
    shape = parse_shape(metadata["object"])
    obstacles = [close(each["polygon"]) for each in metadata.get("scene", {}).get("obstacle", ())]
    return [
        recorded_episode(name, table, prepared[name], shape, obstacles)
        for name, table in recording.episodes.items()
    ]


def recorded_episode(
    name: str, table: Mapping[str, Any], prepared: Mapping[str, Any], shape: Shape, obstacles: list[Floats]
) -> Episode:
    """Return an episode from its table and its prepared streams."""
    motion = Motion(prepared["pose_t"], prepared["pose"])
    measured = Arrow(prepared["wrench_t"], prepared["frame"][:, :2], prepared["on_object"])
    return Episode(
        name=name,
        held_out=prepared["held_out"],
        contact=prepared["contact"],
        table={key: column for key, column in table.items() if not key.startswith("note_")},
        shape=shape,
        motion=motion,
        gripper=gripper_motion(table),
        arrows={"measured": measured},
        panels=[*pose_panels(motion), *wrench_panels(measured)],
        obstacles=obstacles,
    )


def parse_shape(described: Mapping[str, Any]) -> Shape:
    """Return the shape of the table `[object]` of a recording."""
    feet = np.array(described.get("support") or (), dtype=float).reshape(-1, 2)
    return Shape(outlines(described), feet)


def close(polygon: Any) -> Floats:
    """Return corners (n, 2) as a closed outline (n + 1, 2)."""
    return np.array([*polygon, polygon[0]], dtype=float)


def gripper_motion(table: Mapping[str, Any]) -> Motion | None:
    """Return the recorded poses of the gripper, projected to the plane; None without samples."""
    if "gripper_x" not in table:
        return None
    x = table["gripper_x"]
    seen = ~np.isnan(x)
    y = table.get("gripper_y", np.zeros(len(x)))
    if "gripper_qw" in table:
        theta = heading(np.column_stack([table[f"gripper_q{part}"] for part in "wxyz"]))
    else:
        theta = table.get("gripper_theta", np.zeros(len(x)))
    motion = Motion(table["t"][seen], np.column_stack([x, y, theta])[seen])
    return motion if len(motion.t) else None


def pose_panels(motion: Motion) -> list[Panel]:
    """Return the plots of position and heading."""
    position = [
        Curve(f"{axis} recorded", "recorded", motion.t, motion.pose[:, k]) for k, axis in enumerate(AXES)
    ]
    turn = Curve("recorded", "recorded", motion.t, motion.pose[:, 2])
    return [Panel("position", "Position, m", position), Panel("heading", "Heading, rad", [turn])]


def wrench_panels(measured: Arrow) -> list[Panel]:
    """Return the plots of the tared wrench on the object, object axes about its origin."""
    force = [
        Curve(f"{axis} measured", "recorded", measured.t, measured.wrench[:, k])
        for k, axis in enumerate(AXES)
    ]
    torque = Curve("measured", "recorded", measured.t, measured.wrench[:, 2])
    return [
        Panel("force", "Force on the object, N", force),
        Panel("torque", "Torque on the object, N·m", [torque]),
    ]
