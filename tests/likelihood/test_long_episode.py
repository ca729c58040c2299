"""An episode of more than a minute: covariances stay symmetric and positive definite."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

import trundle

TRUTH = {
    "body.mass": 22.0,
    "viscous_wheel.x": -0.5,
    "viscous_wheel.y": -0.3,
    "viscous_wheel.angle": 0.2,
    "viscous_wheel.mu_x": 15.0,
    "viscous_wheel.mu_y": 180.0,
}
FOOTPRINT = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
GYRATION = np.hypot(1.2, 0.8) / np.sqrt(12.0)
POSE_NOISE = [5e-4, 5e-4, 1.7e-3]


def push(t: np.ndarray) -> np.ndarray:
    """Return the wrench about the object's origin, its axes; shape (..., 3)."""
    waves = (8 + 20 * np.sin(2.2 * t + 0.4), 14 * np.sin(3.1 * t), 4 * np.sin(1.7 * t + 1.0))
    return np.stack(waves, axis=-1) * np.clip((t - 0.2) / 0.1, 0.0, 1.0)[..., None]


def motion(t: float, state: np.ndarray) -> np.ndarray:
    """Return the derivative of pose and twist (eq. 1-4), by textbook mechanics."""
    mass, x, y, angle, *mu = TRUTH.values()
    theta, velocity, spin = state[2], state[3:5], state[5]
    turn = np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])
    rolling = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    friction = -rolling @ np.diag(mu) @ rolling.T @ (turn.T @ velocity + spin * np.array([-y, x]))
    wrench = push(np.array(t)) + np.append(friction, x * friction[1] - y * friction[0])
    return np.concatenate([state[3:], turn @ wrench[:2] / mass, wrench[2:] / (mass * GYRATION**2)])


def test_minutes_of_pushing_are_fitted() -> None:
    rng = np.random.default_rng(0)
    t = np.arange(0.0, 80.0, 0.01)
    solved = solve_ivp(motion, (0.0, t[-1]), np.zeros(6), "LSODA", t, rtol=1e-8, atol=1e-9)
    pose = solved.y[:3].T + rng.normal(size=(len(t), 3)) * POSE_NOISE
    wrench = push(t) + rng.normal(size=(len(t), 3)) * [0.4, 0.4, 0.05]
    columns = dict(zip(("object_x", "object_y", "object_theta"), pose.T, strict=True))
    columns |= dict(zip(("force_x", "force_y", "torque_z"), wrench.T, strict=True))
    metadata = {
        "format": "trundle-recording/1",
        "name": "table",
        "object": {"footprint": FOOTPRINT},
        "wrench": {"frame": "object", "reference": "object", "sign": "on_object", "raw": False},
        "noise": {"pose": POSE_NOISE, "force": 0.4, "torque": 0.05},
    }
    recording = trundle.Recording(metadata, {"push": {"t": t, **columns}})
    found = trundle.fit(recording, start=TRUTH, starts=0)
    for parameter in found.summary["parameters"]:
        truth = TRUTH[parameter["name"]]
        assert abs(parameter["mean"] - truth) < 0.01 * max(abs(truth), 1.0), parameter
