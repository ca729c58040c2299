"""Simulated recordings of one hinge and of a planar arm with two joints, for the tests of the checks."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

import trundle

Floats = NDArray[np.float64]
Columns = dict[str, Floats]

DT = 1e-3
"""Step of the simulation, s."""
DURATION = 6.0
"""Length of an episode, s."""
JOINTS = ("shoulder", "elbow")
GRAVITY = 9.81


def reference(rng: np.random.Generator, shape: tuple[int, ...], t: Floats) -> tuple[Floats, Floats]:
    """Return multi-sine trajectories and their velocities, shape (len(t), *shape)."""
    frequencies = rng.uniform(0.15, 1.2, (4, *shape))
    amplitudes = rng.uniform(0.1, 0.5, (4, *shape))
    phases = rng.uniform(0.0, 2.0 * np.pi, (4, *shape))
    omega = 2.0 * np.pi * frequencies
    angle = omega * t.reshape(-1, *[1] * (len(shape) + 1)) + phases
    return (amplitudes * np.sin(angle)).sum(1), (amplitudes * omega * np.cos(angle)).sum(1)


def accelerations(q: Floats, v: Floats, effort: Floats, arm: dict[str, Floats]) -> Floats:
    """Return the accelerations of an arm with one or two joints and friction; q has shape (n, joints)."""
    free = effort - arm["damping"] * v - arm["friction"] * np.tanh(v / 0.05)
    length, mass, inertia = arm["length"], arm["mass"], arm["inertia"]
    if q.shape[1] == 1:
        torque = free[:, 0] - GRAVITY * mass[:, 0] * length[:, 0] * np.sin(q[:, 0])
        single: Floats = (torque / (inertia[:, 0] + mass[:, 0] * length[:, 0] ** 2))[:, None]
        return single
    (m1, m2), (l1, l2), (i1, i2) = mass.T, length.T, inertia.T
    cos, sin = np.cos(q[:, 1]), np.sin(q[:, 1])
    a = i1 + i2 + m1 * l1**2 + m2 * (4.0 * l1**2 + l2**2 + 4.0 * l1 * l2 * cos)
    b = i2 + m2 * (l2**2 + 2.0 * l1 * l2 * cos)
    c = i2 + m2 * l2**2
    h = 2.0 * m2 * l1 * l2 * sin
    g2 = GRAVITY * m2 * l2 * np.sin(q[:, 0] + q[:, 1])
    g1 = GRAVITY * (m1 * l1 + 2.0 * m2 * l1) * np.sin(q[:, 0]) + g2
    r1 = free[:, 0] + h * (2.0 * v[:, 0] * v[:, 1] + v[:, 1] ** 2) - g1
    r2 = free[:, 1] - h * v[:, 0] ** 2 - g2
    solved: Floats = np.column_stack([c * r1 - b * r2, a * r2 - b * r1]) / (a * c - b * b)[:, None]
    return solved


def drawn(rng: np.random.Generator, n: int, episodes: int, joints: int) -> dict[str, Floats]:
    """Return parameters of `n` arms, each repeated for its episodes, shape (n * episodes, joints)."""
    ranges = {
        "mass": (0.3, 2.0),
        "length": (0.1, 0.3),
        "inertia": (0.03, 0.08),
        "damping": (0.05, 0.5),
        "friction": (0.0, 0.5),
    }
    draws = {name: rng.uniform(low, high, (n, joints)) for name, (low, high) in ranges.items()}
    return {name: np.repeat(values, episodes, axis=0) for name, values in draws.items()}


def motions(n: int, joints: int, seed: int, episodes: int = 3) -> Iterator[list[Columns]]:
    """Yield the episodes of `n` arms at 1 kHz: `t`, and q, v, effort, target by joint, without noise."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, DURATION, DT)
    shape = (n * episodes, joints)
    target, speed = reference(rng, shape, t)
    arm = drawn(rng, n, episodes, joints)
    stiffness, rate = rng.uniform(50.0, 150.0, shape), rng.uniform(2.0, 6.0, shape)
    q, v = target[0].copy(), speed[0].copy()
    rows = np.empty((3, len(t), *shape))
    for k in range(len(t)):
        effort = stiffness * (target[k] - q) + rate * (speed[k] - v)
        rows[:, k] = q, v, effort
        v = v + DT * accelerations(q, v, effort, arm)
        q = q + DT * v
    tables = [table(t, rows[:, :, case], target[:, case]) for case in range(n * episodes)]
    yield from (tables[case * episodes : (case + 1) * episodes] for case in range(n))


def table(t: Floats, rows: Floats, target: Floats) -> Columns:
    """Return the columns of one episode; `rows` has shape (3, len(t), joints)."""
    found: Columns = {"t": t}
    for joint in range(rows.shape[2]):
        name = JOINTS[joint]
        found |= dict(zip((f"q_{name}", f"v_{name}", f"effort_{name}"), rows[:, :, joint], strict=True))
        found[f"target_{name}"] = target[:, joint]
    return found


def measured(columns: Columns, rng: np.random.Generator, stride: int = 5, noise: float = 2e-4) -> Columns:
    """Sample every `stride` ms and add noise."""
    found = {name: values[::stride].copy() for name, values in columns.items()}
    for name, values in found.items():
        if name.startswith("q_"):
            values += noise * rng.standard_normal(len(values))
        elif name.startswith("v_"):
            values += 20.0 * noise * rng.standard_normal(len(values))
        elif name.startswith("effort_"):
            values += 0.01 * np.std(values) * rng.standard_normal(len(values))
    return found


def metadata(joints: int, **more: Any) -> dict[str, Any]:
    """Return the metadata of a simulated recording."""
    mechanism: dict[str, Any] = {"joints": list(JOINTS[:joints])}
    mechanism |= {"axis": "hinge", "gravity": True} if joints == 1 else {"model": "arm.xml"}
    return {"format": "trundle-recording/2", "name": "simulated", "mechanism": mechanism, **more}


def recording(episodes: list[Columns], **more: Any) -> trundle.JointRecording:
    """Return a recording of episodes of the same joints."""
    joints = sum(name.startswith("q_") for name in episodes[0])
    names = {f"episode_{k:02}": episode for k, episode in enumerate(episodes)}
    return trundle.JointRecording(
        metadata(joints, **more), names, {} if joints == 1 else {"arm.xml": "<mujoco/>"}
    )
