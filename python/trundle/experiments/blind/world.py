"""The world in MuJoCo: a body that slides and turns on the floor, a wheel, a gripper, and what is hidden."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from trundle.experiments.blind.family import EpisodeContext, HiddenEffect, Hook
from trundle.experiments.blind.push import CONTACT_TIME_S, EPISODE_DURATION_S, Push, WrenchPush
from trundle.experiments.blind.scene import Scene, Wheel

__all__ = ["BODY_HEIGHT_M", "Motion", "add_wheel", "at_site", "quaternion", "set_wheel", "simulate"]

Floats = NDArray[np.float64]

TIME_STEP_S = 5e-4
"""s."""
BODY_HEIGHT_M = 0.4
"""Of the middle of the object above the floor, m: feet have room below."""


@dataclass(frozen=True)
class Motion:
    """What truly happened in an episode, at every step from contact on.

    Attributes
    ----------
    t : array (n,)
        s, the table's.
    pose : array (n, 3)
        Of the object's frame.
    grasp : Grasp
        Of the gripper on the object.
    wrench : array (n, 3)
        On what the sensor carries, gripper axes and origin, N, N, N·m.
    """

    t: Floats
    pose: Floats
    push: Push | WrenchPush
    wrench: Floats


def simulate(scene: Scene, hidden: Sequence[HiddenEffect], episode: int) -> Motion:
    """Simulate one episode."""
    spec, table = build_world(scene, scene.pushes[episode])
    context = EpisodeContext(spec, table, scene, episode)
    for one in hidden:
        one.family.add_to_world(context, one.values)
    model = spec.compile()
    hooks = [one.family.hook(model, context, one.values) for one in hidden]
    return integrate(model, scene, scene.pushes[episode], [hook for hook in hooks if hook is not None])


def build_world(scene: Scene, push: Push | WrenchPush) -> tuple[Any, Any]:
    """Return the world without any effect, and its object."""
    spec = mujoco.MjSpec()
    spec.option.timestep = TIME_STEP_S
    spec.option.gravity = [0.0, 0.0, 0.0]
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 100.0
    table = spec.worldbody.add_body(name="table")
    for name, axis in (("x", [1, 0, 0]), ("y", [0, 1, 0])):
        table.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
    table.add_joint(name="theta", type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 0, 1])
    add_body(table, scene)
    add_wheel(spec, table, "wheel", scene.wheel)
    grasp = push.grasp
    table.add_site(name="grasp", pos=[grasp.x, grasp.y, 0.0], quat=quaternion(grasp.angle))
    for along, index in (("x", 0), ("y", 1), ("turn", 5)):
        spec.add_actuator(name=f"gripper {along}", **at_site("grasp", index))
    return spec, table


def add_body(table: Any, scene: Scene) -> None:
    """Give the object its parts: boxes of one density, or a cylinder."""
    shape = scene.shape
    common = {"contype": 1, "conaffinity": 1, "condim": 1}
    if shape.disc is not None:
        x, y, radius = shape.disc
        kind = mujoco.mjtGeom.mjGEOM_CYLINDER
        table.add_geom(
            type=kind, size=[radius, 0.1, 0.0], pos=[x, y, BODY_HEIGHT_M], mass=scene.mass, **common
        )
        return
    for x, y, w, d in shape.boxes:
        kind, mass = mujoco.mjtGeom.mjGEOM_BOX, scene.mass * 4 * w * d / shape.area
        table.add_geom(type=kind, size=[w, d, 0.1], pos=[x, y, BODY_HEIGHT_M], mass=mass, **common)


def add_wheel(spec: Any, body: Any, name: str, wheel: Wheel) -> None:
    """Add a viscous wheel: a force against the velocity of a site, along and across its direction."""
    body.add_site(name=name, pos=[wheel.x, wheel.y, 0.0], quat=quaternion(wheel.angle))
    for axis, index, mu in (("along", 0, wheel.mu_x), ("across", 1, wheel.mu_y)):
        spec.add_actuator(
            name=f"{name} {axis}",
            biastype=mujoco.mjtBias.mjBIAS_AFFINE,
            biasprm=[0.0, 0.0, -mu] + [0.0] * 7,
            **{**at_site(name, index), "gainprm": [0.0] * 10},
        )


def set_wheel(model: Any, name: str, mu_x: float, mu_y: float) -> None:
    """Change a wheel's friction while it rolls."""
    model.actuator(f"{name} along").biasprm[2] = -mu_x
    model.actuator(f"{name} across").biasprm[2] = -mu_y


def at_site(name: str, index: int) -> dict[str, Any]:
    """Return an actuator that acts at a site along its axis `index` (0-2 force, 3-5 torque)."""
    gear = [0.0] * 6
    gear[index] = 1.0
    kind = mujoco.mjtTrn.mjTRN_SITE
    fixed = mujoco.mjtGain.mjGAIN_FIXED
    gain = [1.0] + [0.0] * 9
    return {"trntype": kind, "target": name, "gear": gear, "gaintype": fixed, "gainprm": gain}


def quaternion(angle: float) -> list[float]:
    """Return a turn about the vertical as a quaternion."""
    return [math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)]


def integrate(model: Any, scene: Scene, push: Push | WrenchPush, hooks: Sequence[Hook]) -> Motion:
    """Push from contact to the end; the force of a step is that of its middle."""
    data = mujoco.MjData(model)
    data.qpos[:3] = push.start
    data.time = CONTACT_TIME_S
    n = round((EPISODE_DURATION_S - CONTACT_TIME_S) / TIME_STEP_S)
    t: Floats = CONTACT_TIME_S + TIME_STEP_S * np.arange(n + 1, dtype=np.float64)
    drive = wrench_source(scene, push, t)
    poses, forces = np.empty((n + 1, 3)), np.empty((n + 1, 3))
    slot = model.actuator("gripper x").id
    for k in range(n + 1):
        poses[k] = data.qpos[:3]
        forces[k] = data.ctrl[slot : slot + 3] = drive(data, k)
        if hooks:
            data.qfrc_applied[:] = 0.0
            for hook in hooks:
                hook(data)
        mujoco.mj_step(model, data)
    middle = np.vstack([forces[:1], (forces[1:] + forces[:-1]) / 2])
    return Motion(t, poses, push, middle)


def wrench_source(scene: Scene, push: Push | WrenchPush, t: Floats) -> Callable[[Any, int], list[float]]:
    """Return what the gripper exerts at step `k`, its own axes: a command, or what its wish takes."""
    if isinstance(push, WrenchPush):
        wrench = push.wrench(t).tolist()
        return lambda data, k: list(wrench[k])
    desired = push.desired_twist(t).tolist()
    return lambda data, k: servo_wrench(data, scene, push, desired[k])


def servo_wrench(data: Any, scene: Scene, push: Push, desired: list[float]) -> list[float]:
    """Return what the gripper exerts in its own axes: in proportion to the twist that is missing."""
    vx, vy, omega = data.qvel[0].item(), data.qvel[1].item(), data.qvel[2].item()
    heading, grasp = data.qpos[2].item(), push.grasp
    c, s = math.cos(heading), math.sin(heading)
    at_x = vx - omega * (s * grasp.x + c * grasp.y)
    at_y = vy + omega * (c * grasp.x - s * grasp.y)
    c, s = math.cos(heading + grasp.angle), math.sin(heading + grasp.angle)
    missing = (desired[0] - c * at_x - s * at_y, desired[1] + s * at_x - c * at_y, desired[2] - omega)
    (force, torque), (most, turn) = scene.gain, scene.limit
    along, across = saturate(force * missing[0], most), saturate(force * missing[1], most)
    return [along, across, saturate(torque * missing[2], turn)]


def saturate(value: float, limit: float) -> float:
    """Return a value within its limit, smoothly, as a compliant arm gives way."""
    return limit * math.tanh(value / limit)
