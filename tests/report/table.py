"""A small table with one wheel and dry friction at a point, simulated in NumPy."""

from __future__ import annotations

import copy
import functools
import math
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

FOOTPRINT = np.array([[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]])
SUPPORT = 0.8 * FOOTPRINT
MASS, INERTIA = 21.9, 21.9 * (1.2**2 + 0.8**2) / 12.0
WHEEL, WHEEL_MU = (-0.5, -0.3), (8.0, 90.0)
DRAG, DRAG_FORCE = (-0.48, 0.31), 6.0
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


Triple = tuple[float, float, float]


def resistance(twist: Triple, drag: float) -> Triple:
    """Wrench of wheel and dry friction at a body twist."""
    (x, y), (mu_x, mu_y) = WHEEL, WHEEL_MU
    wheel = -mu_x * (twist[0] - twist[2] * y), -mu_y * (twist[1] + twist[2] * x)
    at_x, at_y = DRAG
    slip = twist[0] - twist[2] * at_y, twist[1] + twist[2] * at_x
    speed = math.hypot(*slip)
    share = -drag * math.tanh(speed / 0.01) / speed if speed > 0.0 else 0.0
    dry = share * slip[0], share * slip[1]
    torque = x * wheel[1] - y * wheel[0] + at_x * dry[1] - at_y * dry[0]
    return wheel[0] + dry[0], wheel[1] + dry[1], torque


def simulate(wrench: Array, drag: float, substeps: int = 4) -> tuple[Array, Array]:
    """Poses and body twists (n, 3) from rest at the origin, by plain numbers: arrays of three are slow."""
    x, y, theta, u, v, spin = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    rows, h = [(x, y, theta, u, v, spin)], DT / substeps
    for force_x, force_y, torque in wrench[1:].tolist():
        for _ in range(substeps):
            floor = resistance((u, v, spin), drag)
            u, v, spin = (
                u + h * ((force_x + floor[0]) / MASS + spin * v),
                v + h * ((force_y + floor[1]) / MASS - spin * u),
                spin + h * (torque + floor[2]) / INERTIA,
            )
            cos, sin = math.cos(theta), math.sin(theta)
            x, y, theta = x + h * (cos * u - sin * v), y + h * (sin * u + cos * v), theta + h * spin
        rows.append((x, y, theta, u, v, spin))
    found = np.array(rows)
    return found[:, :3], found[:, 3:]


def episode(index: int, drag: float, given_drag: float) -> dict[str, Any]:
    """One recorded push with the simulations before (no friction) and after (nearly the right one)."""
    return copy.deepcopy(_episode(index, drag, given_drag))


@functools.cache
def _episode(index: int, drag: float, given_drag: float) -> dict[str, Any]:
    draw = np.random.default_rng(100 + index)
    t, wrench = push(index)
    truth, twists = simulate(wrench, drag)
    rows = twists.tolist()
    lacking = np.array([resistance(twist, drag) for twist in rows])
    lacking -= np.array([resistance(twist, 0.0) for twist in rows])
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
