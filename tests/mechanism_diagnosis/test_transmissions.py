"""An arm whose elbow has an elastic transmission and its encoder at the drive, simulated by MuJoCo."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import trundle

mujoco = pytest.importorskip("mujoco")

from tests.mechanism_diagnosis.recordings import ARM, NOMINAL, RATE_STEPS, STEP, open_loop_ratio, targets  # noqa: E402

STIFFNESS, DAMPING = 40.0, 0.2
SETTLING = 3000
SPRING = f'/><joint name="spring" axis="0 1 0" stiffness="{STIFFNESS}" damping="{DAMPING}"'
JOINTS = ("shoulder", "elbow")


def episode(seed: int) -> dict[str, NDArray[np.float64]]:
    """Return the positions of the drives and their efforts."""
    model = mujoco.MjModel.from_xml_string(ARM.format(shoulder="", elbow=SPRING))
    data, rng = mujoco.MjData(model), np.random.default_rng(seed)
    t = np.arange(0.0, 8.0, STEP)
    wanted = targets(2.0 * t, seed)
    wanted = np.vstack([np.repeat(wanted[:1], SETTLING, 0), wanted])
    data.qpos[:2] = wanted[0]
    q, effort = np.empty_like(wanted), np.empty_like(wanted)
    for k, row in enumerate(wanted):
        q[k] = data.qpos[:2]
        effort[k] = 60 * (row - q[k]) - 3 * data.qvel[:2]
        data.qfrc_applied[:2] = effort[k]
        mujoco.mj_step(model, data)
    rows = slice(SETTLING, None, RATE_STEPS)
    columns = {"t": t[::RATE_STEPS]}
    for k, joint in enumerate(JOINTS):
        noise = rng.standard_normal((2, len(columns["t"])))
        columns[f"q_{joint}"] = q[rows, k] + 5e-5 * noise[0]
        columns[f"effort_{joint}"] = effort[rows, k] + 0.02 * noise[1]
    return columns


def test_elasticity_behind_the_encoder_moves_the_other_joints() -> None:
    metadata = {
        "format": "trundle-recording/2",
        "name": "arm",
        "mechanism": {"model": "robot.xml", "joints": list(JOINTS)},
        "encoder": {"side": {"shoulder": "joint", "elbow": "drive"}},
        "split": {"held_out": ["e3"]},
    }
    episodes = {f"e{seed}": episode(seed) for seed in range(4)}
    found = trundle.diagnose(trundle.JointRecording(metadata, episodes, {"robot.xml": NOMINAL.encode()}))
    assert found.missing == ["joint_elasticity:elbow"]
    stiffness = found.answer["missing"][0]["parameters"]["stiffness"]["mean"]
    assert stiffness == pytest.approx(STIFFNESS, rel=0.05)
    assert open_loop_ratio(found.answer) < 0.8
