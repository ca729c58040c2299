"""One table with the same pushes in `trundle simulate` and in MuJoCo, without obstacles."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import tomli_w
from numpy.typing import NDArray

import trundle
from trundle.export import Laws, callback, to_mujoco

Floats = NDArray[np.float64]
Effect = Mapping[str, Any]
Box = tuple[float, float, float, float]
"""A fixed box: left, lower, right and upper end, m, world frame."""

LENGTH, WIDTH, MASS = 1.2, 0.8, 22.0
INERTIA = MASS * (LENGTH**2 + WIDTH**2) / 12.0
BODY = {
    "footprint": [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]],
    "mass": MASS,
    "support": [[-0.5, -0.3], [0.5, -0.3], [0.5, 0.3], [-0.5, 0.3]],
}
CONTACT = 0.2
"""Time of contact, s."""
STEP = 2.5e-4
"""Of `trundle simulate` where a scenario has no word of it, s."""


@dataclass(frozen=True)
class Push:
    """A wrench at the grasp, in gripper axes, which rotate with the table."""

    start: tuple[float, float, float]
    grasp: tuple[float, float, float]
    knots: Sequence[tuple[float, float, float, float]]
    """[t, N, N, N·m], t in s from contact on; straight lines between."""

    @property
    def seconds(self) -> float:
        """Length from contact on, s."""
        return self.knots[-1][0]

    def wrench(self, t: Floats) -> Floats:
        """Return the wrench (n, 3) at times since contact; none before it."""
        when, *courses = np.array(self.knots).T
        return np.column_stack([np.where(t < 0.0, 0.0, np.interp(t, when, course)) for course in courses])

    def on_origin(self, t: Floats) -> Floats:
        """Return the same about the table's origin in its axes."""
        x, y, angle = self.grasp
        wrench = self.wrench(t)
        force = wrench[:, :2] @ turn(angle).T
        return np.column_stack([force, wrench[:, 2] + x * force[:, 1] - y * force[:, 0]])


def middles(n: int, step: float) -> Floats:
    """Return the middle of each of `n` steps."""
    return np.linspace(step / 2, (n - 0.5) * step, n)


def turn(angle: float) -> Floats:
    """Return the matrix of a counter-clockwise rotation."""
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[cos, -sin], [sin, cos]])


def gap(one: Floats, other: Floats) -> tuple[float, float]:
    """Return the largest difference of positions, m, and of headings, rad."""
    off = np.abs(one - other)
    return float(np.hypot(off[..., 0], off[..., 1]).max()), float(off[..., 2].max())


def assert_alike(one: Floats, other: Floats, most: tuple[float, float]) -> None:
    """No pose is farther from the other than this, m and rad."""
    position, heading = gap(one, other)
    assert position < most[0] and heading < most[1], (position, heading)


def simulated(
    folder: Path,
    effects: Sequence[Effect],
    push: Push,
    *,
    boxes: Sequence[Box] = (),
    step: float | None = None,
    rate: float = 100.0,
) -> Mapping[str, Floats]:
    """Return the columns of what `trundle.simulate` records, without noise."""
    corners = [[[a, b], [c, b], [c, d], [a, d]] for a, b, c, d in boxes]
    scenario: dict[str, Any] = {
        "format": "trundle-scenario/1",
        "name": "agreement",
        "object": "table.toml",
        "effect": list(effects),
        "obstacle": [{"polygon": polygon} for polygon in corners],
        "sensor": {"rate": rate, "force_noise": 0.0, "torque_noise": 0.0, "precontact": CONTACT},
        "tracker": {"rate": rate, "noise": [0.0, 0.0, 0.0]},
        "push": [{"start": push.start, "grasp": push.grasp, "drive": "force", "knots": push.knots}],
    }
    if step is not None:
        scenario["step"] = step
    table = {"format": "trundle-object/1", "name": "table", "body": BODY}
    for name, content in (("table.toml", table), ("scenario.toml", scenario)):
        (folder / name).write_text(tomli_w.dumps(content))
    columns: Mapping[str, Floats] = trundle.simulate(folder / "scenario.toml").episodes["episode_00"]
    return columns


def poses(columns: Mapping[str, Floats]) -> Floats:
    """Return recorded poses (n, 3) with continuous headings."""
    x, y, theta = (columns[f"object_{axis}"] for axis in ("x", "y", "theta"))
    return np.column_stack([x, y, np.unwrap(theta)])


def model(effects: Sequence[Effect]) -> trundle.Model:
    """Return the same table as a model."""
    described = {"format": "trundle-model/1", "body": BODY, "effect": list(effects)}
    return trundle.Model.from_toml(tomli_w.dumps(described))


def exported(
    folder: Path,
    effects: Sequence[Effect],
    push: Push,
    timestep: float,
    *,
    inner: Sequence[float] | None = None,
    rate: float = 100.0,
) -> Floats:
    """Return the poses of what `trundle export` writes for MuJoCo.

    `inner`: where states of the laws' own start, if not where the export lets them.
    """
    written = to_mujoco(model(effects), folder / "exported")
    engine = mujoco.MjModel.from_xml_path(str(written / "object.xml"))
    engine.opt.timestep = timestep
    laws = callback.Effects(engine, written, contact=CONTACT, episode=0.0)
    data = mujoco.MjData(engine)
    data.qpos[:] = push.start
    if inner is not None:
        data.userdata[:] = inner
        data.time = 1e-9  # at 0 the export takes its own
    n, every = round((CONTACT + push.seconds) / timestep), round(1.0 / (rate * timestep))
    wrench = push.on_origin(middles(n, timestep) - CONTACT).tolist()
    track = [data.qpos.copy()]
    for k, (fx, fy, torque) in enumerate(wrench):
        cos, sin = math.cos(data.qpos[2]), math.sin(data.qpos[2])
        data.qfrc_applied[:] = (cos * fx - sin * fy, sin * fx + cos * fy, torque)
        laws.apply(engine, data)
        mujoco.mj_step(engine, data)
        if (k + 1) % every == 0:
            track.append(data.qpos.copy())
    return np.array(track)


def integrated(
    effects: Sequence[Effect],
    push: Push,
    timestep: float,
    *,
    com: tuple[float, float] = (0.0, 0.0),
    inertia_factor: float = 1.0,
    load: tuple[float, float] | None = None,
    rate: float = 100.0,
) -> Floats:
    """Return the poses that MuJoCo's Runge-Kutta rule gives under the momentary wrench of the laws.

    `com`: the mass centre; `inertia_factor`: of the inertia; `load`: time, s, at which a mass, kg, is added.
    """
    laws, inertia = Laws(model(effects)), inertia_factor * INERTIA
    engine = mujoco.MjModel.from_xml_string(f"""
    <mujoco><option timestep="{timestep}" gravity="0 0 0" integrator="RK4"/><worldbody><body name="table">
      <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/><joint type="hinge" axis="0 0 1"/>
      <inertial pos="{com[0]} {com[1]} 0" mass="{MASS}" diaginertia="{inertia} {inertia} {inertia}"/>
    </body></worldbody></mujoco>""")
    data = mujoco.MjData(engine)
    data.qpos[:] = push.start
    n, every = round((CONTACT + push.seconds) / timestep), round(1.0 / (rate * timestep))
    # At the ends and in the middle of each step: what a step of this rule looks at.
    pushed = push.on_origin(np.linspace(-CONTACT, push.seconds, 2 * n + 1)).tolist()
    middle = 0.0

    def forces(_model: Any, at: Any) -> None:
        pose, twist = at.qpos.tolist(), at.qvel.tolist()
        # An event falls between two steps: all of a step lies on one side.
        fx, fy, torque = laws.wrench(pose, twist, middle, contact=CONTACT, episode=0.0)
        px, py, turning = pushed[round(2 * at.time / timestep)]
        fx, fy = fx + px, fy + py
        cos, sin = math.cos(pose[2]), math.sin(pose[2])
        at.qfrc_passive[:] = (cos * fx - sin * fy, sin * fx + cos * fy, torque + turning)

    track = [data.qpos.copy()]
    mujoco.set_mjcb_passive(forces)
    try:
        for k in range(n):
            middle = (k + 0.5) * timestep
            if load is not None and k == round(load[0] / timestep):
                engine.body_mass[1] *= 1.0 + load[1] / MASS
                engine.body_inertia[1] *= 1.0 + load[1] / MASS
                mujoco.mj_setConst(engine, mujoco.MjData(engine))
            mujoco.mj_step(engine, data)
            if (k + 1) % every == 0:
                track.append(data.qpos.copy())
    finally:
        mujoco.set_mjcb_passive(None)
    return np.array(track)
