"""Recordings of a table with dry friction under all legs, simulated by MuJoCo."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import mujoco
import numpy as np
from numpy.typing import NDArray

import trundle

Floats = NDArray[np.float64]

FOOTPRINT = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
LEGS = np.array([[-0.5, -0.3], [0.5, -0.3], [0.5, 0.3], [-0.5, 0.3]])
MASS, INERTIA = 22.0, 22.0 * (1.2**2 + 0.8**2) / 12.0
FRICTION = 40.0
"""Friction of all legs together, N."""
GRASP = np.array([-0.6, 0.1])
"""Position of the gripper on the table; its axes are those of the table."""
CONTACT = 0.5
SECONDS = 5.0
POSE, FORCE, TORQUE = (5e-4, 5e-4, 1.75e-3), 0.4, 0.05
"""Noise."""
PLANAR = f"""
<mujoco>
  <option timestep="2e-4" gravity="0 0 0"/>
  <worldbody><body name="table">
    <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/><joint type="hinge" axis="0 0 1"/>
    <inertial pos="0 0 0" mass="{MASS}" diaginertia="1 3 {INERTIA}"/>
  </body></worldbody>
</mujoco>
"""
"""A table in the plane with friction from Python."""
STANDING = f"""
<mujoco>
  <option timestep="1e-3" cone="elliptic" impratio="100" noslip_iterations="10"/>
  <worldbody>
    <geom type="plane" size="20 20 1" friction="{FRICTION / (MASS * 9.81)} 0 0"/>
    <body name="table" pos="0 0 0.02">
      <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/><joint type="hinge" axis="0 0 1"/>
      <joint type="slide" axis="0 0 1"/><joint type="hinge" axis="1 0 0"/><joint type="hinge" axis="0 1 0"/>
      <inertial pos="0 0 0" mass="{MASS}" diaginertia="1 3 {INERTIA}"/>
      {"".join(f'<geom size="0.02" pos="{x} {y} 0" friction="0 0 0" condim="3"/>' for x, y in LEGS)}
    </body>
  </worldbody>
</mujoco>
"""
"""A table on four legs with MuJoCo's friction."""


def creeping(creep: float) -> Callable[[Floats, Floats], Floats]:
    """Return dry friction of the legs with a creep speed, m/s: wrench by pose and twist, world axes."""

    def friction(pose: Floats, twist: Floats) -> Floats:
        cos, sin = np.cos(pose[2]), np.sin(pose[2])
        arm = LEGS @ np.array([[cos, sin], [-sin, cos]])
        velocity = twist[:2] + twist[2] * np.column_stack([-arm[:, 1], arm[:, 0]])
        speed = np.sqrt(np.sum(velocity**2, axis=1, keepdims=True) + creep**2)
        force = -FRICTION / 4.0 * velocity / speed
        return np.array([*force.sum(axis=0), np.sum(arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0])])

    return friction


def frictionless(_pose: Floats, _twist: Floats) -> Floats:
    """Return no friction."""
    return np.zeros(3)


def push(strength: float, episode: int, seed: int) -> Callable[[float], Floats]:
    """Return the wrench at the grasp over time, gripper axes, N, N, N·m; it oscillates around breakaway."""
    rng = np.random.default_rng([seed, episode])
    phase, rate = rng.uniform(-np.pi, np.pi, 3), rng.uniform(0.7, 1.3, 3)

    def wrench(t: float) -> Floats:
        s = t - CONTACT
        if s <= 0.0:
            return np.zeros(3)
        on = min(s / 0.2, 1.0)
        along = np.sin(2.2 * rate[0] * s + phase[0])
        side = np.sin(3.1 * rate[1] * s + phase[1])
        turn = np.sin(1.7 * rate[2] * s + phase[2])
        return on * strength * np.array([1.2 * along, 0.6 * side, 0.2 * turn])

    return wrench


def run(
    model: mujoco.MjModel,
    friction: Callable[[Floats, Floats], Floats],
    wrench: Callable[[float], Floats],
    start: Floats,
) -> dict[str, Floats]:
    """Simulate a push: `t`, true pose and true wrench every 5 ms."""
    data = mujoco.MjData(model)
    data.qpos[:3] = start
    every = round(5e-3 / model.opt.timestep)
    rows = []
    for step in range(round(SECONDS / model.opt.timestep)):
        fx, fy, torque = wrench(data.time)
        pose = data.qpos[:3]
        if step % every == 0:
            rows.append([data.time, *pose, fx, fy, torque])
        cos, sin = np.cos(pose[2]), np.sin(pose[2])
        torque += GRASP[0] * fy - GRASP[1] * fx
        pushed = np.array([cos * fx - sin * fy, sin * fx + cos * fy, torque])
        data.qfrc_applied[:3] = pushed + friction(pose, data.qvel[:3])
        mujoco.mj_step(model, data)
    table = np.array(rows)
    return {"t": table[:, 0], "pose": table[:, 1:4], "wrench": table[:, 4:]}


def observed(truth: dict[str, Floats], rng: np.random.Generator) -> dict[str, Floats]:
    """Return columns: poses at 100 Hz, a raw wrench at 200 Hz, with noise and an offset."""
    n = len(truth["t"])
    reading = truth["wrench"] + [2.0, -1.0, 0.3] + rng.normal(size=(n, 3)) * [FORCE, FORCE, TORQUE]
    pose = truth["pose"] + rng.normal(size=(n, 3)) * POSE
    cos, sin = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    held = GRASP @ np.array([[cos, sin], [-sin, cos]]).transpose(2, 0, 1)
    gripper = np.column_stack([pose[:, :2] + held, pose[:, 2]])
    columns = {"t": truth["t"]}
    axes = ("x", "y", "theta")
    for k, axis in enumerate(axes):
        for name, values in (("object", pose), ("gripper", gripper)):
            columns[f"{name}_{axis}"] = np.where(np.arange(n) % 2 == 0, values[:, k], np.nan)
    for k, name in enumerate(("force_x", "force_y", "torque_z")):
        columns[name] = reading[:, k]
    return columns


@cache
def recording(
    floor: str, strength: float = FRICTION, seed: int = 0, feet: bool = False, episodes: int = 5
) -> trundle.Recording:
    """Return a recording of pushes of five seconds, the last held out.

    Parameters
    ----------
    floor : str
        "creeping": dry friction with a creep of 1 mm/s; "sharp": of 0.1 mm/s; "contacts": MuJoCo's contacts
        under four legs, elliptic cones; "joints": MuJoCo's friction loss of the joints, separate along each
        world axis and against rotation, unlike a floor.
    strength : float
        Strength of the pushes, N.
    seed : int
    feet : bool
        Whether the recording contains the positions of the legs.
    episodes : int
    """
    spec = mujoco.MjSpec.from_string(STANDING if floor == "contacts" else PLANAR)
    if floor == "joints":
        for joint, loss in zip(spec.joints, (FRICTION, FRICTION, 0.4 * FRICTION), strict=True):
            joint.frictionloss = loss
    model = spec.compile()
    friction = {"creeping": creeping(1e-3), "sharp": creeping(1e-4)}.get(floor, frictionless)
    tables = {}
    for k in range(episodes):
        rng = np.random.default_rng([seed, k, 1])
        start = np.array([0.2 * k, -0.1 * k, 0.9 * k - 1.0])
        tables[f"push_{k}"] = observed(run(model, friction, push(strength, k, seed), start), rng)
    return trundle.Recording(metadata(floor, feet, episodes), tables)


def metadata(floor: str, feet: bool, episodes: int) -> dict[str, object]:
    object_metadata: dict[str, object] = {
        "footprint": FOOTPRINT,
        **({"support": LEGS.tolist()} if feet else {}),
    }
    return {
        "format": "trundle-recording/1",
        "name": f"MuJoCo's table, {floor}",
        "object": object_metadata,
        "wrench": {"frame": "sensor", "sign": "on_object", "raw": True, "precontact": [0.0, CONTACT - 0.05]},
        "noise": {"pose": list(POSE), "force": FORCE, "torque": TORQUE},
        "split": {"held_out": [f"push_{episodes - 1}"]},
    }
