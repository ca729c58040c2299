"""A simulated table with a viscous wheel, pushed by a rigid grasp, with known truth."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import trundle

Floats = NDArray[np.float64]

FOOTPRINT = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
MASS, INERTIA = 22.0, 3.8
GRASP = np.array([-0.6, 0.1, 0.3])
"""Pose of the gripper in the object frame."""
OFFSET = np.array([3.0, -2.0, 0.2])
"""Reading of the sensor without contact."""
NOISE: dict[str, Any] = {"pose": [5e-4, 5e-4, 1.7e-3], "force": 0.4, "torque": 0.05}
STEP = 1e-3
TABLES = dict[str, dict[str, Any]]


@dataclass(frozen=True)
class Table:
    """A simulated table; `wheel` is x, y, angle, mu_x, mu_y as in equation 3 of the paper."""

    wheel: tuple[float, float, float, float, float] = (-0.5, -0.3, 0.2, 15.0, 180.0)
    dry: float = 0.0
    episodes: int = 5
    seconds: float = 5.0
    quiet: float = 0.6
    strength: float = 25.0
    seed: int = 0
    metadata: dict[str, Any] = field(default_factory=dict)


def turn(angle: float | Floats) -> Floats:
    """Rotation matrix of an angle in the plane."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin], [sin, cos]])


def transport(frame: Floats, wrench: Floats) -> Floats:
    """Planar wrench read in a frame at pose `frame`, brought to the frame that the pose is given in."""
    force = turn(frame[2]) @ wrench[:2]
    return np.array([*force, wrench[2] + frame[0] * force[1] - frame[1] * force[0]])


def drag(table: Table, twist: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return the wrench of the floor on the table, body axes about its origin."""
    x, y, angle, mu_x, mu_y = table.wheel
    cos, sin = math.cos(angle), math.sin(angle)
    velocity = twist[0] - twist[2] * y, twist[1] + twist[2] * x
    along = -mu_x * (cos * velocity[0] + sin * velocity[1])
    across = -mu_y * (cos * velocity[1] - sin * velocity[0])
    force = cos * along - sin * across, sin * along + cos * across
    rubbing = [-table.dry * one / (abs(one) + 0.005) for one in twist]
    return (
        force[0] + rubbing[0],
        force[1] + rubbing[1],
        x * force[1] - y * force[0] + 0.3 * rubbing[2],
    )


def push(table: Table, t: Floats, phases: Floats) -> Floats:
    """Wrenches at the grasp at all times, gripper axes."""
    s = t - table.quiet
    swing = np.sin(np.array([1.1, 2.3, 1.7]) * s[:, None] + phases)
    planar = np.stack([1.0 + 0.5 * swing[:, 0], 0.6 * swing[:, 1]], axis=1) @ turn(phases[0]).T
    return table.strength * np.where(s[:, None] > 0.0, np.column_stack([planar, 0.15 * swing[:, 2]]), 0.0)


@dataclass
class Truth:
    """One episode without noise, a row per time step."""

    t: Floats
    pose: Floats
    twist: Floats
    accel: Floats
    reading: Floats


def simulate(table: Table, episode: int) -> Truth:
    """Integrate one push, with plain numbers because arrays of three are slow."""
    phases = np.random.default_rng(table.seed + 99).uniform(-np.pi, np.pi, (table.episodes, 3))
    t: Floats = STEP * np.arange(round(table.seconds / STEP), dtype=np.float64)
    reading = push(table, t, phases[episode])
    (x, y, theta), (v_x, v_y, spin) = (0.3 * episode, -0.1, 0.7 * episode - 1.0), (0.0, 0.0, 0.0)
    rows = np.empty((len(t), 9))
    for i, pushed in enumerate(transport(GRASP, reading.T).T.tolist()):
        cos, sin = math.cos(theta), math.sin(theta)
        floor = drag(table, (cos * v_x + sin * v_y, cos * v_y - sin * v_x, spin))
        force_x, force_y, torque = (one + other for one, other in zip(pushed, floor, strict=True))
        a_x, a_y = (cos * force_x - sin * force_y) / MASS, (sin * force_x + cos * force_y) / MASS
        rows[i] = x, y, theta, v_x, v_y, spin, a_x, a_y, torque / INERTIA
        v_x, v_y, spin = v_x + STEP * a_x, v_y + STEP * a_y, spin + STEP * torque / INERTIA
        x, y, theta = x + STEP * v_x, y + STEP * v_y, theta + STEP * spin
    return Truth(t, rows[:, :3], rows[:, 3:6], rows[:, 6:], reading)


def observed(truth: Truth, rng: np.random.Generator, noise: float) -> dict[str, Any]:
    """Poses at about 60 Hz and a raw reaction at 100 Hz, out of step, in one table."""
    pose_at = np.arange(3, len(truth.t), 17)
    wrench_at = np.arange(0, len(truth.t), 10)
    at = np.union1d(pose_at, wrench_at)
    cells = {name: np.full(len(at), np.nan) for name in COLUMNS}
    rows, seen = np.searchsorted(at, pose_at), truth.pose[pose_at]
    gripper = np.array([placed(pose) for pose in seen])
    for k, axis in enumerate(["x", "y", "theta"]):
        cells[f"object_{axis}"][rows] = seen[:, k] + noise * rng.normal(0.0, NOISE["pose"][k], len(rows))
        cells[f"gripper_{axis}"][rows] = gripper[:, k] + noise * rng.normal(0.0, 1e-4, len(rows))
    rows = np.searchsorted(at, wrench_at)
    sd = [NOISE["force"], NOISE["force"], NOISE["torque"]]
    for k, axis in enumerate(("force_x", "force_y", "torque_z")):
        reading = -truth.reading[wrench_at, k] + OFFSET[k]
        cells[axis][rows] = reading + noise * rng.normal(0.0, sd[k], len(rows))
    return {"t": truth.t[at], **cells}


COLUMNS = [f"{body}_{axis}" for body in ("object", "gripper") for axis in ("x", "y", "theta")] + [
    "force_x",
    "force_y",
    "torque_z",
]


def placed(pose: Floats) -> Floats:
    """Pose of the gripper in the world."""
    return np.array([*(pose[:2] + turn(pose[2]) @ GRASP[:2]), pose[2] + GRASP[2]])


def metadata(table: Table) -> dict[str, Any]:
    """recording.toml as a dict."""
    return {
        "format": "trundle-recording/1",
        "name": "simulated table",
        "object": {"footprint": FOOTPRINT},
        "wrench": {
            "frame": "sensor",
            "sign": "on_sensor",
            "raw": True,
            "precontact": [0.0, table.quiet - 0.05],
        },
        **table.metadata,
    }


def tables(table: Table, noise: float = 1.0) -> TABLES:
    """Return the columns of the episodes; `noise` scales the noise of the instruments."""
    rng = np.random.default_rng(table.seed)
    names = [f"episode_{i:02}" for i in range(table.episodes)]
    return {name: observed(simulate(table, i), rng, noise) for i, name in enumerate(names)}


def recording(table: Table, **changes: Any) -> trundle.Recording:
    """A clean recording of a table."""
    table = replace(table, **changes)
    return trundle.Recording(metadata(table), tables(table))
