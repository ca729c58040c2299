"""The MuJoCo world: a body that slides and rotates on the floor, a wheel, a gripper, and hidden effects."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import mujoco
import numpy as np

from trundle.experiments.blind.family import Context, HiddenEffect, Hook
from trundle.experiments.blind.push import CONTACT_TIME_S, Grasp, Kinematics, Push, WrenchPush, servo_wrench
from trundle.experiments.blind.readings import step_averages
from trundle.experiments.blind.scene import Scene, Wheel
from trundle.experiments.sampling import Floats

__all__ = [
    "BODY_HEIGHT_M",
    "SLIP_STIFFNESS_RATIO",
    "add_bias",
    "add_caster",
    "add_disc",
    "add_gripper",
    "add_point_mass",
    "add_slides",
    "add_wheel",
    "compile_effects",
    "initial_state",
    "new_world",
    "set_wheel",
    "simulate_grasp",
    "site",
    "step",
    "turned",
]

SLIP_STIFFNESS_RATIO = 20.0
"""Resistance of a caster's tyre to side slip over the resistance of its scrubbing at the pivot."""
BODY_HEIGHT_M = 0.4
"""Height of the object's middle above the floor; leaves room for feet."""


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


def compile_effects(
    spec: Any, table: Any, scene: Scene, hidden: Sequence[HiddenEffect], episode: int
) -> tuple[Any, list[Hook]]:
    """Add the hidden effects to a world and compile it.

    Return the compiled model and the functions to call before each step.
    """
    context = Context(scene, episode, spec, table)
    for one in hidden:
        if one.family.build is not None:
            one.family.build(context, one.values)
    model = spec.compile()
    hooks = [one.hook(model, context) for one in hidden]
    return model, [hook for hook in hooks if hook is not None]


def add_slides(body: Any, prefix: str = "") -> list[Any]:
    """Add slide joints along x and y to a body, and return them."""
    slide = mujoco.mjtJoint.mjJNT_SLIDE
    axes = (("x", [1, 0, 0]), ("y", [0, 1, 0]))
    return [body.add_joint(name=f"{prefix}{name}", type=slide, axis=axis) for name, axis in axes]


def add_point_mass(body: Any, name: str, place: Sequence[float], mass: float) -> Any:
    """Add a child body with the mass of a small sphere without contacts, and return it."""
    child = body.add_body(name=name, pos=[*place, 0.2])
    sphere = mujoco.mjtGeom.mjGEOM_SPHERE
    child.add_geom(type=sphere, size=[0.02, 0, 0], mass=mass, contype=0, conaffinity=0)
    return child


def add_disc(table: Any, scene: Scene, **collision: Any) -> bool:
    """Add a cylinder if the object is a disc, and report whether it is one."""
    if scene.shape.disc is None:
        return False
    x, y, radius = scene.shape.disc
    kind = mujoco.mjtGeom.mjGEOM_CYLINDER
    place, size = [x, y, BODY_HEIGHT_M], [radius, 0.1, 0.0]
    table.add_geom(type=kind, size=size, pos=place, mass=scene.mass, **collision)
    return True


def add_gripper(spec: Any, table: Any, grasp: Grasp) -> None:
    """Add the actuators with which the gripper exerts a wrench, in its own axes."""
    table.add_site(name="grasp", pos=[grasp.x, grasp.y, 0.0], quat=turned(grasp.angle))
    for along, index in (("x", 0), ("y", 1), ("turn", 5)):
        kind, gain = mujoco.mjtGain.mjGAIN_FIXED, [1.0] + [0.0] * 9
        spec.add_actuator(name=f"gripper {along}", **site("grasp", index), gaintype=kind, gainprm=gain)


def add_wheel(spec: Any, body: Any, name: str, wheel: Wheel) -> None:
    """Add a viscous wheel: forces against the velocity of a site, along and across its direction."""
    body.add_site(name=name, pos=[wheel.x, wheel.y, 0.0], quat=turned(wheel.angle))
    for axis, index, mu in (("along", 0, wheel.mu_x), ("across", 1, wheel.mu_y)):
        add_bias(spec, f"{name} {axis}", [0.0, 0.0, -mu], **site(name, index))


def add_caster(
    spec: Any, body: Any, name: str, pivot: Sequence[float], first: float, trail: float, side: float
) -> None:
    """Add a caster: a hinged arm from the tyre to the pivot, whose first direction is `first`, rad.

    The tyre resists side slip strongly, and scrubs as it swivels. A massless arm turns so that the tyre's
    side force balances the scrubbing torque. At the pivot it then resists sideways motion with `side`.
    """
    arm = body.add_body(name=name, pos=[*pivot, 0.0], quat=turned(first))
    arm.add_joint(name=f"{name} swivel", type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 0, 1])
    arm.explicitinertial = True
    arm.mass, arm.inertia, arm.ipos = 0.01, [1e-4, 1e-4, 1e-5], [0.0, 0.0, 0.0]
    add_wheel(spec, arm, name, Wheel(-trail, 0.0, 0.0, 0.0, SLIP_STIFFNESS_RATIO * side))
    add_bias(spec, f"{name} scrub", [0, 0, -side * trail**2], **site(name, 5))


def set_wheel(model: Any, name: str, mu_x: float, mu_y: float) -> None:
    """Change a wheel's friction."""
    model.actuator(f"{name} along").biasprm[2] = -mu_x
    model.actuator(f"{name} across").biasprm[2] = -mu_y


def add_bias(spec: Any, name: str, bias: Sequence[float], gain: float = 0.0, **where: Any) -> None:
    """Add an actuator with a force bias[0] + bias[1] · position + bias[2] · velocity + gain · control."""
    spec.add_actuator(
        name=name,
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        biasprm=[*bias] + [0.0] * (10 - len(bias)),
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        gainprm=[gain] + [0.0] * 9,
        **where,
    )


def site(name: str, index: int) -> dict[str, Any]:
    """Return the place of an actuator at a site along its axis `index` (0-2 force, 3-5 torque)."""
    gear = [float(k == index) for k in range(6)]
    return {"trntype": mujoco.mjtTrn.mjTRN_SITE, "target": name, "gear": gear}


def turned(angle: float) -> list[float]:
    """Return a rotation about the vertical as a quaternion."""
    return [math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)]


def initial_state(model: Any, scene: Scene, episode: int) -> tuple[Any, Floats, Floats, Floats]:
    """Return the state at contact, the times of the steps, and arrays for poses and forces."""
    data, time_step = mujoco.MjData(model), model.opt.timestep
    data.qpos[:3] = scene.pushes[episode].start
    data.time = CONTACT_TIME_S
    n = round((scene.seconds[episode] - CONTACT_TIME_S) / time_step)
    t: Floats = CONTACT_TIME_S + time_step * np.arange(n + 1, dtype=np.float64)
    return data, t, np.empty((n + 1, 3)), np.zeros((n + 1, 3))


def step(model: Any, data: Any, hooks: Sequence[Hook]) -> None:
    """Advance by one step, with the forces that the effects apply."""
    if hooks:
        data.qfrc_applied[:] = 0.0
        for hook in hooks:
            hook(data)
    mujoco.mj_step(model, data)


def simulate_grasp(
    model: Any, scene: Scene, episode: int, hooks: Sequence[Hook]
) -> tuple[Floats, Floats, Floats]:
    """Simulate an episode of a grasp; return times, poses and wrenches in gripper axes from contact on."""
    data, t, poses, forces = initial_state(model, scene, episode)
    drive, slot = wrench_source(scene, scene.pushes[episode], t), model.actuator("gripper x").id
    for k in range(len(t)):
        poses[k] = data.qpos[:3]
        forces[k] = data.ctrl[slot : slot + 3] = drive(data, k)
        step(model, data, hooks)
    return t, poses, step_averages(forces)


def wrench_source(scene: Scene, push: Push | WrenchPush, t: Floats) -> Callable[[Any, int], Sequence[float]]:
    """Return a function of data and step that returns the gripper's wrench, in its own axes."""
    if isinstance(push, WrenchPush):
        wrench = push.wrench(t).tolist()
        return lambda data, k: wrench[k]
    desired = push.desired_twist(t).tolist()
    return lambda data, k: servo_wrench(motion(data), push.grasp, desired[k], scene.gain, scene.limit)


def motion(data: Any) -> Kinematics:
    """Return the pose and twist of the object."""
    return Kinematics.of([*data.qpos[:3].tolist(), *data.qvel[:3].tolist()])
