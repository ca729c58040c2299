"""A small table with one wheel and dry friction at a point, simulated in NumPy."""

from __future__ import annotations

import copy
import functools
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

FOOTPRINT = np.array([[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]])
SUPPORT = 0.8 * FOOTPRINT
MASS, INERTIA = 21.9, 21.9 * (1.2**2 + 0.8**2) / 12.0
WHEEL, WHEEL_MU = np.array([-0.5, -0.3]), np.array([8.0, 90.0])
DRAG, DRAG_FORCE = np.array([-0.48, 0.31]), 6.0
DT, POSE_SD = 0.01, np.array([0.0005, 0.0005, 0.0017])


def push(seed: int, seconds: float = 5.0) -> tuple[Array, Array]:
    """Time (n,) s and wrench (n, 3) on the object, object axes: at rest for half a second, then swaying."""
    draw = np.random.default_rng(seed)
    t = np.arange(0.0, seconds, DT)
    heading, rate = draw.uniform(-1.0, 1.0), draw.uniform(0.5, 1.5)
    on = np.clip((t - 0.5) / 0.3, 0.0, 1.0) * np.clip((seconds - 0.6 - t) / 0.4, 0.0, 1.0)
    angle = heading + 0.6 * np.sin(rate * t)
    turn = draw.uniform(-5.0, 5.0) * np.cos(rate * t)
    return t, on[:, None] * np.column_stack([22.0 * np.cos(angle), 22.0 * np.sin(angle), turn])


def resistance(twist: Array, drag: float) -> Array:
    """Wrench (3,) of wheel and dry friction at a body twist (3,)."""
    wrench = np.zeros(3)
    for place, law in ((WHEEL, "wheel"), (DRAG, "drag")):
        slip = twist[:2] + twist[2] * np.array([-place[1], place[0]])
        force = (
            -WHEEL_MU * slip if law == "wheel" else -drag * np.tanh(np.linalg.norm(slip) / 0.01) * unit(slip)
        )
        wrench += [*force, place[0] * force[1] - place[1] * force[0]]
    return wrench


def unit(vector: Array) -> Array:
    length = np.linalg.norm(vector)
    return np.asarray(vector / length if length > 0.0 else vector, dtype=np.float64)


def simulate(wrench: Array, drag: float, substeps: int = 4) -> tuple[Array, Array]:
    """Poses and body twists (n, 3) from rest at the origin."""
    pose, twist = np.zeros(3), np.zeros(3)
    poses, twists = [pose.copy()], [twist.copy()]
    inertia, h = np.array([MASS, MASS, INERTIA]), DT / substeps
    for applied in wrench[1:]:
        for _ in range(substeps):
            spin = np.array([twist[2] * twist[1], -twist[2] * twist[0], 0.0])
            twist = twist + h * ((applied + resistance(twist, drag)) / inertia + spin)
            cos, sin = np.cos(pose[2]), np.sin(pose[2])
            pose = pose + h * np.array(
                [cos * twist[0] - sin * twist[1], sin * twist[0] + cos * twist[1], twist[2]]
            )
        poses.append(pose.copy())
        twists.append(twist.copy())
    return np.array(poses), np.array(twists)


def episode(index: int, drag: float, given_drag: float) -> dict[str, Any]:
    """One recorded push with the simulations before (no friction) and after (nearly the right one)."""
    return copy.deepcopy(_episode(index, drag, given_drag))


@functools.cache
def _episode(index: int, drag: float, given_drag: float) -> dict[str, Any]:
    draw = np.random.default_rng(100 + index)
    t, wrench = push(index)
    truth, twists = simulate(wrench, drag)
    lacking = np.array([resistance(twist, drag) - resistance(twist, 0.0) for twist in twists])
    noise = draw.normal(size=lacking.shape) * [0.8, 0.8, 0.3]
    return {
        "name": f"episode_{index:02d}",
        "held_out": index >= 4,
        "contact": 0.5,
        "t": t.tolist(),
        "observed": (truth + draw.normal(size=truth.shape) * POSE_SD).tolist(),
        "before": simulate(wrench, 0.0)[0].tolist(),
        "after": simulate(wrench, given_drag)[0].tolist(),
        "residual": {
            "t": t.tolist(),
            "before": (lacking + noise).tolist(),
            "after": (0.02 * lacking + noise).tolist(),
            "sd": np.tile([0.8, 0.8, 0.3], (len(t), 1)).tolist(),
        },
        "wrench": None,
    }
