"""Friction of one axis that falls slowly with speed."""

from __future__ import annotations

import numpy as np
import pytest

import trundle

INERTIA, DAMPING = 0.1, 0.05
FRICTION = {"effort": 0.3, "static_effort": 0.6, "velocity": 0.8}


def recording() -> trundle.JointRecording:
    """Return a recording whose motion is hardly faster than the fall of the friction."""
    rng = np.random.default_rng(0)
    t = np.arange(0.0, 10.0, 0.005)
    episodes = {}
    for k in range(4):
        waves = [(0.6, 1.3 + 0.2 * k), (0.3, 3.1), (0.1, 5.3)]
        q, v, a = (
            sum(size * w**n * np.sin(w * t + w * k + n * np.pi / 2) for size, w in waves) for n in range(3)
        )
        share = np.exp(-((v / FRICTION["velocity"]) ** 2))
        level = FRICTION["effort"] + (FRICTION["static_effort"] - FRICTION["effort"]) * share
        effort = INERTIA * a + DAMPING * v + level * np.sign(v)
        errors = rng.standard_normal((2, len(t)))
        episodes[f"e{k}"] = {"t": t, "q_arm": q + 5e-5 * errors[0], "effort_arm": effort + 5e-3 * errors[1]}
    metadata = {
        "format": "trundle-recording/2",
        "name": "bench",
        "mechanism": {"axis": "hinge", "joints": ["arm"], "inertia": INERTIA},
    }
    return trundle.JointRecording(metadata, episodes)


def test_friction_that_falls_slowly_with_speed_is_one_effect() -> None:
    found = trundle.diagnose(recording())
    assert found.missing == ["joint_dry_friction:arm"]
    parameters = found.answer["missing"][0]["parameters"]
    assert {name: parameters[name]["mean"] for name in FRICTION} == pytest.approx(FRICTION, rel=0.1)
