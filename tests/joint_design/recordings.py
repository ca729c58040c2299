"""Recordings of benches: by inverse dynamics of an axis, and by MuJoCo."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

import trundle

Floats = NDArray[np.float64]

GRAVITY, INERTIA, DAMPING = 0.5, 0.005, 0.02
STEP = 0.001
RATE_STEPS = 5
BENCH = """<mujoco><option timestep="0.001" integrator="implicitfast"/><worldbody><body name="arm">
<joint name="hinge" axis="0 0 1" armature="0.02" damping="{damping}" frictionloss="{friction}"/>
<inertial pos="0.1 0 0" mass="0.5" diaginertia="0.002 0.002 0.002"/></body></worldbody></mujoco>"""


def axis_recording(
    centre: float, amplitude: float, *, gain: float = 1.0, noise: float = 0.01
) -> trundle.JointRecording:
    """Return a recording of an axis under gravity with dry friction of 0.08 N·m, moved about a position.

    The effort is recorded in units of `gain` N·m, with a noise in N·m.
    """
    episodes = {}
    for number in range(3):
        rng = np.random.default_rng(number)
        t = np.arange(0, 8, 0.005)
        waves = [(0.7, 3.1 + number), (0.3, 7.3)]
        phases = rng.uniform(0, 6, 2)
        q, v, a = (centre * (k == 0) + np.zeros_like(t) for k in range(3))
        for (share, w), phase in zip(waves, phases, strict=True):
            q = q + amplitude * share * np.sin(w * t + phase)
            v = v + amplitude * share * w * np.cos(w * t + phase)
            a = a - amplitude * share * w**2 * np.sin(w * t + phase)
        effort = INERTIA * a + DAMPING * v + GRAVITY * np.sin(q) + 0.08 * np.sign(v)
        episodes[f"e{number}"] = {
            "t": t,
            "q_arm": q + rng.normal(0, 1e-5, len(t)),
            "effort_arm": (effort + rng.normal(0, noise, len(t))) / gain,
        }
    metadata: dict[str, Any] = {
        "format": "trundle-recording/2",
        "name": "bench",
        "mechanism": {"axis": "hinge", "joints": ["arm"], "gravity": True},
        "effort": {"gain": gain, "source": "current"},
        "split": {"held_out": ["e2"]},
    }
    return trundle.JointRecording(metadata, episodes)


def followed(friction: float, damping: float, t: Floats, wanted: Floats, seed: int) -> dict[str, Floats]:
    """Return the log of a bench in MuJoCo that a controller moves along positions, (T,), at times t."""
    model = mujoco.MjModel.from_xml_string(BENCH.format(friction=friction, damping=damping))
    data, rng = mujoco.MjData(model), np.random.default_rng(seed)
    times = np.arange(0, t[-1], STEP)
    targets = np.interp(times, t, wanted)
    speeds = np.gradient(targets, STEP)
    data.qpos[:] = wanted[0]
    found = []
    for target, speed in zip(targets, speeds, strict=True):
        effort = 80 * (target - data.qpos[0]) + 3 * (speed - data.qvel[0])
        found.append((data.qpos[0], effort))
        data.qfrc_applied[:] = effort
        mujoco.mj_step(model, data)
    rows = np.array(found)[::RATE_STEPS]
    return {
        "t": times[::RATE_STEPS],
        "q_hinge": rows[:, 0] + rng.normal(0, 2e-5, len(rows)),
        "effort_hinge": rows[:, 1] + rng.normal(0, 0.02, len(rows)),
    }


def bench_recording(
    friction: float, damping: float, further: tuple[Floats, Floats] | None = None
) -> trundle.JointRecording:
    """Return a recording of a bench that moves there and back at one speed, and along further positions."""
    t = np.arange(0, 8, 0.005)
    triangle = 0.5 * np.abs(((t + 0.5) / 2 % 2) - 1) - 0.25  # speed of 0.25 rad/s
    smooth = np.convolve(
        np.pad(triangle, 20, mode="edge"), np.hanning(41) / np.hanning(41).sum(), mode="valid"
    )
    episodes = {f"e{seed}": followed(friction, damping, t, smooth, seed) for seed in range(3)}
    if further is not None:
        episodes["designed"] = followed(friction, damping, *further, 3)
    metadata = {
        "format": "trundle-recording/2",
        "name": "bench",
        "mechanism": {"model": "bench.xml", "joints": ["hinge"], "free": ["armature"]},
        "split": {"held_out": ["e2"]},
    }
    nominal = BENCH.format(friction=0.0, damping=0.0)
    return trundle.JointRecording(metadata, episodes, {"bench.xml": nominal.encode()})
