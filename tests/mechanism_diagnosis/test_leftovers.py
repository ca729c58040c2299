"""Laws whose idealised form leaves a small part of what they explain, far above the noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import trundle

STEP, RATE_STEPS, DURATION = 2e-4, 25, 12.0
INERTIA, DAMPING = 0.5, 0.4
STOP, STIFFNESS, CONTACT_DAMPING = 0.4, 200.0, 5.0


def episode(number: int) -> dict[str, NDArray[np.float64]]:
    """Return the motion of an axis that meets a stop with a damping of its own."""
    rng = np.random.default_rng(number)
    phases, q, v, rows = rng.uniform(0, 6, 3), 0.0, 0.0, []
    for k in range(int(DURATION / STEP)):
        t = k * STEP
        waves = zip((0.25, 0.41, 0.67), phases, strict=True)
        wanted = sum(0.25 * np.sin(2 * np.pi * f * t + phase) for f, phase in waves)
        effort = 60.0 * (wanted - q) - 6.0 * v
        if k % RATE_STEPS == 0:
            rows.append((t, q, effort))
        contact = min(0.0, STIFFNESS * (STOP - q) - CONTACT_DAMPING * v) if q > STOP else 0.0
        v += STEP * (effort - DAMPING * v + contact) / INERTIA
        q += STEP * v
    t_all, q_arm, effort_arm = np.array(rows).T
    noise = rng.standard_normal((2, len(t_all)))
    return {"t": t_all, "q_arm": q_arm + 1e-5 * noise[0], "effort_arm": effort_arm + 5e-3 * noise[1]}


def test_the_damping_of_a_stop_is_no_other_effect() -> None:
    metadata = {
        "format": "trundle-recording/2",
        "name": "stopped",
        "mechanism": {"axis": "hinge", "joints": ["arm"], "inertia": INERTIA},
        "effort": {"source": "measured"},
    }
    found = trundle.diagnose(trundle.JointRecording(metadata, {f"e{k}": episode(k) for k in range(4)}))
    assert found.missing == ["joint_stop:arm"], found.answer["missing"]
    assert found.answer["verdict"] == "explained"
