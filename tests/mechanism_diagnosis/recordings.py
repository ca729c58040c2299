"""Small recordings of joints, simulated by MuJoCo or by integration."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

import trundle
from trundle._types import JointAnswer

Floats = NDArray[np.float64]

STEP = 0.001
RATE_STEPS = 5
DURATION = 8.0
ARM = """<mujoco><option timestep="0.001" integrator="implicitfast"/><worldbody>
<body name="upper" pos="0 0 1">
<joint name="shoulder" axis="0 1 0" armature="0.02" damping="0.3"{shoulder}/>
<inertial pos="0 0 -0.2" mass="1.2" diaginertia="0.02 0.02 0.004"/>
<body name="fore" pos="0 0 -0.4"><joint name="elbow" axis="0 1 0" armature="0.01" damping="0.1"{elbow}/>
<inertial pos="0 0 -0.15" mass="0.6" diaginertia="0.006 0.006 0.001"/></body></body></worldbody></mujoco>"""
NOMINAL = ARM.format(shoulder="", elbow="")


def targets(t: Floats, seed: int) -> Floats:
    """Return smooth random positions of two joints, (T, 2)."""
    rng = np.random.default_rng(seed)
    waves = [
        rng.uniform(0.15, 0.4) * np.sin(2 * np.pi * f * t[:, None] + rng.uniform(0, 6, 2))
        for f in (0.23, 0.41, 0.67)
    ]
    found: Floats = np.sum(waves, axis=0)
    return found


def log_of(model_text: str, seed: int, duration: float = DURATION, delay_steps: int = 0) -> dict[str, Floats]:
    """Return the columns of a log of an arm under control of positions, with recorded efforts.

    The efforts are those of `delay_steps` steps of the simulation later than their time.
    """
    model = mujoco.MjModel.from_xml_string(model_text)
    data, rng = mujoco.MjData(model), np.random.default_rng(seed)
    t = np.arange(0, duration, STEP)
    wanted = targets(t, seed)
    data.qpos[:] = wanted[0]
    q, effort = np.empty_like(wanted), np.empty_like(wanted)
    for k, row in enumerate(wanted):
        q[k] = data.qpos
        effort[k] = 60 * (row - data.qpos) - 3 * data.qvel
        data.qfrc_applied[:] = effort[k]
        mujoco.mj_step(model, data)
    rows = slice(None, None, RATE_STEPS)
    q = q[rows] + rng.normal(0, 5e-5, q[rows].shape)
    effort = np.roll(effort, -delay_steps, axis=0)[rows] + rng.normal(0, 0.02, q.shape)
    names = ("shoulder", "elbow")
    columns = {"t": t[rows]}
    columns |= {f"q_{joint}": q[:, k] for k, joint in enumerate(names)}
    return columns | {f"effort_{joint}": effort[:, k] for k, joint in enumerate(names)}


def arm_recording(friction: float) -> trundle.JointRecording:
    """Return a recording of an arm whose elbow has dry friction, N·m, that its model does not have."""
    return recording_of(ARM.format(shoulder="", elbow=f' frictionloss="{friction}"'))


def recording_of(truth: str, shoulder_offset: float = 0.0) -> trundle.JointRecording:
    """Return a recording of an arm with the nominal model; the shoulder may have an offset, rad."""
    episodes = {f"e{seed}": log_of(truth, seed) for seed in range(4)}
    for columns in episodes.values():
        columns["q_shoulder"] = columns["q_shoulder"] + shoulder_offset
    metadata = {
        "format": "trundle-recording/2",
        "name": "arm",
        "mechanism": {"model": "robot.xml", "joints": ["shoulder", "elbow"]},
        "effort": {"source": "measured"},
        "split": {"held_out": ["e3"]},
    }
    return trundle.JointRecording(metadata, episodes, {"robot.xml": NOMINAL.encode()})


def open_loop_ratio(answer: JointAnswer) -> float:
    """Return the open-loop error of held-out positions with the named effects over that without."""
    held_out = answer["fit"]["held_out"]
    assert held_out is not None
    before, after = (held_out[side]["relative_position_rmse"] for side in ("before", "after"))
    assert before is not None
    assert after is not None
    return float(after / before)


def pendulum_recording(friction: float) -> trundle.JointRecording:
    """Return free swings of a pendulum with dry friction per inertia, rad/s²."""
    episodes = {}
    for number, start in enumerate((1.2, -0.9, 1.5)):
        rng = np.random.default_rng(number)
        q, v, found = start, 0.0, []
        for _ in range(int(12.0 / STEP)):
            found.append(q)
            v += STEP * (-30.0 * np.sin(q) - 0.05 * v)
            v = np.sign(v) * max(abs(v) - STEP * friction, 0.0)
            q += STEP * v
        values = np.array(found)[::RATE_STEPS]
        t = np.arange(len(values)) * STEP * RATE_STEPS
        episodes[f"e{number}"] = {"t": t, "q_arm": values + rng.normal(0, 2e-4, len(t))}
    metadata = {
        "format": "trundle-recording/2",
        "name": "pendulum",
        "mechanism": {"axis": "hinge", "joints": ["arm"], "gravity": True},
        "split": {"held_out": ["e2"]},
    }
    return trundle.JointRecording(metadata, episodes)


def write_log(path: Path, columns: dict[str, Floats]) -> None:
    """Write a CSV log."""
    names = list(columns)
    np.savetxt(
        path,
        np.stack([columns[name] for name in names], 1),
        delimiter=",",
        header=",".join(names),
        comments="",
    )
