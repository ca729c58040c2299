"""A planar arm of two hinges in NumPy: the simulator under test, and recordings with hidden dry friction."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import trundle

Floats = NDArray[np.float64]

JOINTS = ("shoulder", "elbow")
VALUES = {"upper_mass": 1.2, "fore_mass": 0.7, "damping": 0.12}
LENGTH, CENTRES, GYRATIONS, GRAVITY = 0.3, (0.14, 0.12), (0.09, 0.08), 9.81
ROTORS = (0.012, 0.006)


def acceleration(q: Floats, v: Floats, effort: Floats, values: dict[str, float]) -> Floats:
    """Return accelerations for states and efforts, (..., 2)."""
    m1, m2, damping = (values[name] for name in VALUES)
    (c1, c2), (k1, k2), length = CENTRES, GYRATIONS, LENGTH
    cos, sin = np.cos(q[..., 1]), np.sin(q[..., 1])
    coupling, second = m2 * length * c2, m2 * (c2**2 + k2**2)
    m11 = ROTORS[0] + m1 * (c1**2 + k1**2) + m2 * length**2 + second + 2 * coupling * cos
    m12, m22 = second + coupling * cos, ROTORS[1] + second
    v1, v2 = v[..., 0], v[..., 1]
    weight = m2 * GRAVITY * c2 * np.sin(q[..., 0] + q[..., 1])
    first = (m1 * c1 + m2 * length) * GRAVITY * np.sin(q[..., 0]) + weight
    f1 = effort[..., 0] + coupling * sin * (2 * v1 * v2 + v2**2) - first - damping * v1
    f2 = effort[..., 1] - coupling * sin * v1**2 - weight - damping * v2
    determinant = m11 * m22 - m12**2
    return np.stack([m22 * f1 - m12 * f2, m11 * f2 - m12 * f1], axis=-1) / determinant[..., None]


def step(state: Floats, effort: Floats, dt: float, values: dict[str, float]) -> Floats:
    """Return the state after `dt` by the semi-implicit Euler method; also for states (B, 4)."""
    q, v = state[..., :2], state[..., 2:]
    v = v + dt * acceleration(q, v, effort, values or VALUES)
    return np.concatenate([q + dt * v, v], axis=-1)


def log(seed: int, friction: float, duration: float = 6.0) -> dict[str, Floats]:
    """Return a log of the arm under control of positions, with dry friction at the elbow, N·m."""
    rng, dt, every = np.random.default_rng(seed), 5e-4, 10
    t = np.arange(0, duration, dt)
    waves = [
        rng.uniform(0.2, 0.45) * np.sin(2 * np.pi * f * t[:, None] + rng.uniform(0, 6, 2))
        for f in (0.23, 0.41, 0.67)
    ]
    wanted = np.sum(waves, axis=0)
    state, states, efforts = np.r_[wanted[0], 0.0, 0.0], [], []
    for row in wanted:
        effort = np.array([60.0, 40.0]) * (row - state[:2]) - np.array([3.0, 1.5]) * state[2:]
        states.append(state)
        efforts.append(effort)
        state = step(state, effort - [0.0, friction * np.tanh(state[3] / 5e-3)], dt, VALUES)
    q, effort = np.array(states)[::every, :2], np.array(efforts)[::every]
    q = q + rng.normal(0, 5e-5, q.shape)
    effort = effort + rng.normal(0, 0.02, effort.shape)
    columns = {"t": t[::every]}
    for k, joint in enumerate(JOINTS):
        columns |= {f"q_{joint}": q[:, k], f"effort_{joint}": effort[:, k]}
    return columns


def recording(
    friction: float, duration: float = 6.0, held_out: tuple[str, ...] = ("e2",)
) -> trundle.JointRecording:
    """Return a recording of three episodes."""
    metadata = {
        "format": "trundle-recording/2",
        "name": "arm",
        "mechanism": {"types": "hinge", "joints": list(JOINTS)},
        "split": {"held_out": list(held_out)},
    }
    return trundle.JointRecording(metadata, {f"e{k}": log(k, friction, duration) for k in range(3)})
