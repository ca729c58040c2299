"""Drives that are at their limit most of the time, and loads that one joint tells in part."""

from __future__ import annotations

from pathlib import Path
from unittest.mock import ANY

import numpy as np
import pytest
from numpy.typing import NDArray

import trundle

pytest.importorskip("mujoco")

LIMIT = 0.3
PENDULUM = """<mujoco><compiler angle="radian"/><worldbody><body name="link" pos="0 0 0.5">
<joint name="arm" axis="0 1 0" armature="0" damping="0.3"/>
<inertial pos="0 0 -0.15" mass="0.5" diaginertia="5e-4 5e-4 2e-4"/></body></worldbody></mujoco>"""


def clipped_episode(phase: float) -> dict[str, NDArray[np.float64]]:
    """Return the motion of an axis whose commands are far beyond the limit of its drive."""
    dt, inertia, damping, q, v = 1e-3, 0.02, 0.03, 0.0, 0.0
    rows = []
    for k in range(10000):
        wanted = np.sin(2.1 * k * dt + phase) + 0.5 * np.sin(4.7 * k * dt)
        if k % 5 == 0:
            command = 20.0 * (wanted - q) - 1.0 * v
            rows.append((k * dt, q, command))
        effort = np.clip(command, -LIMIT, LIMIT)
        v += dt * (effort - damping * v) / inertia
        q += dt * v
    t, q_arm, effort_arm = np.array(rows).T
    noise = 1e-5 * np.random.default_rng(round(10 * phase)).standard_normal(len(t))
    return {"t": t, "q_arm": q_arm + noise, "effort_arm": effort_arm}


def test_a_limit_far_below_the_commands_is_named() -> None:
    metadata = {
        "format": "trundle-recording/2",
        "name": "clipped",
        "mechanism": {"axis": "hinge", "joints": ["arm"], "inertia": 0.02},
        "effort": {"source": "commanded"},
    }
    episodes = {f"e{k}": clipped_episode(0.7 * k) for k in range(4)}
    size = np.sqrt(np.mean(episodes["e0"]["effort_arm"] ** 2))
    assert size > 3 * LIMIT
    found = trundle.diagnose(trundle.JointRecording(metadata, episodes))
    assert found.missing == ["effort_saturation:arm"]
    assert found.answer["missing"][0]["parameters"]["limit"]["mean"] == pytest.approx(LIMIT, rel=0.05)


def pendulum_recording(
    tmp_path: Path,
    gain: float = 1.0,
    payload: trundle.mechanism.Payload | None = None,
    noise: float = 2e-3,
    **mechanism: object,
) -> trundle.JointRecording:
    """Return a recording of `PENDULUM` with an exact motion, a payload, and a gain of the effort."""
    (tmp_path / "robot.xml").write_text(PENDULUM, encoding="utf-8")
    loaded = trundle.mechanism.Mechanism.load(tmp_path / "robot.xml", ["arm"], payload=payload)
    rng = np.random.default_rng(0)
    t = np.arange(0.0, 10.0, 0.005)
    episodes = {}
    for k in range(4):
        waves = [(0.5, 1.3 + 0.2 * k), (0.3, 3.1), (0.15, 5.3)]
        q, v, a = (
            sum(size * w**n * np.sin(w * t + w * k + n * np.pi / 2) for size, w in waves) for n in range(3)
        )
        effort = gain * loaded.inverse_dynamics(*(np.asarray(x)[:, None] for x in (q, v, a)))[:, 0]
        errors = rng.standard_normal((2, len(t)))
        episodes[f"e{k}"] = {"t": t, "q_arm": q + 2e-5 * errors[0], "effort_arm": effort + noise * errors[1]}
    metadata = {
        "format": "trundle-recording/2",
        "name": "pendulum",
        "mechanism": {"model": "robot.xml", "joints": ["arm"], **mechanism},
    }
    return trundle.JointRecording(metadata, episodes, {"robot.xml": PENDULUM.encode()})


def test_a_load_beside_a_pendulum_is_a_payload_although_its_mass_alone_is_unknown(tmp_path: Path) -> None:
    payload = trundle.mechanism.Payload("link", 0.3, (0.1, 0.0, -0.05))
    found = trundle.diagnose(pendulum_recording(tmp_path, payload=payload))
    assert "payload:link" in {name for tie in found.answer["tied"] for name in tie} | set(found.missing)


@pytest.mark.parametrize("gain", [0.7, 1.4])
def test_a_gain_is_tied_with_other_masses_and_damping(tmp_path: Path, gain: float) -> None:
    # Without an armature, the gain multiplies what the masses and the damping need.
    found = trundle.diagnose(pendulum_recording(tmp_path, gain, noise=0.03, free=["mass"]))
    assert found.answer["tied"] == [[found.missing[0], ANY]]
    assert set(found.answer["tied"][0]) == {"effort_gain:arm", "joint_viscous_friction:arm"}
    assert found.answer["missing"][0]["probability"] < 0.8
