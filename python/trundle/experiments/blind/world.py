"""The MuJoCo world: a body that slides and rotates on the floor, a wheel, a gripper, and hidden effects."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from trundle.experiments.blind.family import EpisodeContext, HiddenEffect, Hook
from trundle.experiments.blind.push import CONTACT_TIME_S, EPISODE_DURATION_S, Grasp, Push, WrenchPush
from trundle.experiments.blind.readings import step_averages
from trundle.experiments.blind.scene import Scene, Wheel
from trundle.experiments.sampling import Floats

__all__ = ["BODY_HEIGHT_M", "Motion", "add_wheel", "at_site", "quaternion", "set_wheel", "simulate"]


TIME_STEP_S = 5e-4
"""Simulation step."""
BODY_HEIGHT_M = 0.4
"""Height of the object's middle above the floor; leaves room for feet."""


@dataclass(frozen=True)
class Motion:
    """True motion of an episode at every step from contact on.

    Attributes
    ----------
    t : array (n,)
        s, as in the table.
    pose : array (n, 3)
        Of the object's frame.
    push : Push or WrenchPush
        The push of the episode.
    wrench : array (n, 3)
        On the object, gripper axes and origin, N, N, N·m.
    """

    t: Floats
    pose: Floats
    push: Push | WrenchPush
    wrench: Floats


def simulate(scene: Scene, hidden: Sequence[HiddenEffect], episode: int) -> Motion:
    """Simulate one episode."""
    spec, table = build_world(scene, scene.pushes[episode])
    model, hooks = compile_effects(spec, table, scene, hidden, episode)
    return integrate(model, scene, scene.pushes[episode], hooks)


def compile_effects(
    spec: Any, table: Any, scene: Scene, hidden: Sequence[HiddenEffect], episode: int
) -> tuple[Any, list[Hook]]:
    """Add the hidden effects to a world and compile it.

    Return the compiled model and the functions to call before each step.
    """
    context = EpisodeContext(spec, table, scene, episode)
    for one in hidden:
        one.family.add_to_world(context, one.values)
    model = spec.compile()
    hooks = [one.family.hook(model, context, one.values) for one in hidden]
    return model, [hook for hook in hooks if hook is not None]


def build_world(scene: Scene, push: Push | WrenchPush) -> tuple[Any, Any]:
    """Return the world without effects, and its object."""
    spec, table = new_world(TIME_STEP_S)
    add_body(table, scene)
    add_wheel(spec, table, "wheel", scene.wheel)
    add_gripper(spec, table, push.grasp)
    return spec, table


def new_world(time_step: float) -> tuple[Any, Any]:
    """Return a world without gravity, and an object without geometry on two slides and a hinge."""
    spec = mujoco.MjSpec()
    spec.option.timestep = time_step
    spec.option.gravity = [0.0, 0.0, 0.0]
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 100.0
    table = spec.worldbody.add_body(name="table")
    add_slides(table)
    table.add_joint(name="theta", type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 0, 1])
    return spec, table


def add_slides(body: Any, prefix: str = "") -> None:
    """Add slide joints along x and y to a body."""
    for name, axis in (("x", [1, 0, 0]), ("y", [0, 1, 0])):
        body.add_joint(name=f"{prefix}{name}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)


def add_gripper(spec: Any, table: Any, grasp: Grasp) -> None:
    """Add the actuators with which the gripper exerts a wrench, in its own axes."""
    table.add_site(name="grasp", pos=[grasp.x, grasp.y, 0.0], quat=quaternion(grasp.angle))
    for along, index in (("x", 0), ("y", 1), ("turn", 5)):
        spec.add_actuator(name=f"gripper {along}", **at_site("grasp", index))


def add_disc(table: Any, scene: Scene, **collision: Any) -> bool:
    """Add a cylinder if the object is a disc, and report whether it is one."""
    if scene.shape.disc is None:
        return False
    x, y, radius = scene.shape.disc
    kind = mujoco.mjtGeom.mjGEOM_CYLINDER
    table.add_geom(
        type=kind, size=[radius, 0.1, 0.0], pos=[x, y, BODY_HEIGHT_M], mass=scene.mass, **collision
    )
    return True


def add_body(table: Any, scene: Scene) -> None:
    """Add the object's geometry: boxes of equal density, or a cylinder."""
    shape = scene.shape
    common = {"contype": 1, "conaffinity": 1, "condim": 1}
    if add_disc(table, scene, **common):
        return
    for x, y, w, d in shape.boxes:
        kind, mass = mujoco.mjtGeom.mjGEOM_BOX, scene.mass * 4 * w * d / shape.area
        table.add_geom(type=kind, size=[w, d, 0.1], pos=[x, y, BODY_HEIGHT_M], mass=mass, **common)


def add_wheel(spec: Any, body: Any, name: str, wheel: Wheel) -> None:
    """Add a viscous wheel: forces against the velocity of a site, along and across its direction."""
    body.add_site(name=name, pos=[wheel.x, wheel.y, 0.0], quat=quaternion(wheel.angle))
    for axis, index, mu in (("along", 0, wheel.mu_x), ("across", 1, wheel.mu_y)):
        spec.add_actuator(
            name=f"{name} {axis}",
            biastype=mujoco.mjtBias.mjBIAS_AFFINE,
            biasprm=[0.0, 0.0, -mu] + [0.0] * 7,
            **{**at_site(name, index), "gainprm": [0.0] * 10},
        )


def set_wheel(model: Any, name: str, mu_x: float, mu_y: float) -> None:
    """Change a wheel's friction."""
    model.actuator(f"{name} along").biasprm[2] = -mu_x
    model.actuator(f"{name} across").biasprm[2] = -mu_y


def at_site(name: str, index: int) -> dict[str, Any]:
    """Return the arguments of an actuator at a site along its axis `index` (0-2 force, 3-5 torque)."""
    gear = [0.0] * 6
    gear[index] = 1.0
    kind = mujoco.mjtTrn.mjTRN_SITE
    fixed = mujoco.mjtGain.mjGAIN_FIXED
    gain = [1.0] + [0.0] * 9
    return {"trntype": kind, "target": name, "gear": gear, "gaintype": fixed, "gainprm": gain}


def quaternion(angle: float) -> list[float]:
    """Return a rotation about the vertical as a quaternion."""
    return [math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)]


def integrate(model: Any, scene: Scene, push: Push | WrenchPush, hooks: Sequence[Hook]) -> Motion:
    """Simulate from contact to the end. The force of a step is that at its middle."""
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
        step(model, data, hooks)
    return Motion(t, poses, push, step_averages(forces))


def step(model: Any, data: Any, hooks: Sequence[Hook]) -> None:
    """Advance by one step, with the forces that the effects apply."""
    if hooks:
        data.qfrc_applied[:] = 0.0
        for hook in hooks:
            hook(data)
    mujoco.mj_step(model, data)


def wrench_source(scene: Scene, push: Push | WrenchPush, t: Floats) -> Callable[[Any, int], list[float]]:
    """Return a function of data and step that returns the gripper's wrench, in its own axes."""
    if isinstance(push, WrenchPush):
        wrench = push.wrench(t).tolist()
        return lambda data, k: list(wrench[k])
    desired = push.desired_twist(t).tolist()
    return lambda data, k: servo_wrench(data, scene, push, desired[k])


def servo_wrench(data: Any, scene: Scene, push: Push, desired: list[float]) -> list[float]:
    """Return the gripper's wrench in its own axes: proportional to the error of its twist, saturated."""
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
    """Return a value within ±`limit`, with a smooth saturation."""
    return limit * math.tanh(value / limit)
