"""A gear with play whose drive has dry friction, simulated by MuJoCo with a joint for each side."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import trundle

mujoco = pytest.importorskip("mujoco")

from tests.mechanism_diagnosis.recordings import open_loop_ratio  # noqa: E402

STEP = 5e-4
FRICTION = 0.1
PENDULUM = """<mujoco><compiler angle="radian"/><option timestep="0.0005" integrator="implicitfast"/>
<worldbody><body name="link" pos="0 0 0.5">
<joint name="arm" axis="0 1 0" armature="0.02" damping="0.05"{friction}/>{play}
<inertial pos="0 0 -0.15" mass="0.5" diaginertia="5e-3 5e-3 2e-4"/></body></worldbody></mujoco>"""
PLAY = """<joint name="play" axis="0 1 0" limited="true" range="{low} {high}"
solreflimit="0.002 1" solimplimit="0.95 0.99 {width} 0.5 2"/>"""


def episode(seed: int, gap: float) -> dict[str, NDArray[np.float64]]:
    """Return the motion of the link, and the effort of a drive that follows random waves."""
    play = PLAY.format(low=-gap / 2, high=gap / 2, width=1e-4 * gap)
    model = mujoco.MjModel.from_xml_string(PENDULUM.format(friction=f' frictionloss="{FRICTION}"', play=play))
    data, rng = mujoco.MjData(model), np.random.default_rng(seed)
    t = np.arange(0.0, 10.0, STEP)
    waves = ((0.5, 0.23), (0.3, 0.47), (0.12, 0.9))
    wanted = np.sum([size * np.sin(2 * np.pi * f * t + rng.uniform(0, 6)) for size, f in waves], 0)
    rows = np.empty((len(t), 2))
    for k, target in enumerate(wanted):
        weight = 0.5 * 9.81 * 0.15 * np.sin(data.qpos.sum())
        effort = 8 * (target - data.qpos[0]) - 0.6 * data.qvel[0] + weight
        rows[k] = data.qpos.sum(), effort
        data.qfrc_applied[0] = effort
        mujoco.mj_step(model, data)
    q, effort = rows[::10].T
    noise = rng.standard_normal((2, len(q)))
    return {"t": t[::10], "q_arm": q + 2e-5 * noise[0], "effort_arm": effort + 2e-3 * noise[1]}


@pytest.mark.parametrize("gap", [0.03, 0.1])
def test_play_is_named_where_the_drive_has_dry_friction(gap: float) -> None:
    metadata = {
        "format": "trundle-recording/2",
        "name": "gear",
        "mechanism": {"model": "robot.xml", "joints": ["arm"]},
        "split": {"held_out": ["e3"]},
    }
    files = {"robot.xml": PENDULUM.format(friction="", play="").encode()}
    episodes = {f"e{k}": episode(k, gap) for k in range(4)}
    found = trundle.diagnose(trundle.JointRecording(metadata, episodes, files))
    assert sorted(found.missing) == ["joint_backlash:arm", "joint_dry_friction:arm"]
    sizes = {one["effect"]: one["parameters"] for one in found.answer["missing"]}
    assert sizes["joint_backlash"]["gap"]["mean"] == pytest.approx(gap, rel=0.05)
    assert sizes["joint_dry_friction"]["effort"]["mean"] == pytest.approx(FRICTION, rel=0.05)
    assert open_loop_ratio(found.answer) < 0.5
