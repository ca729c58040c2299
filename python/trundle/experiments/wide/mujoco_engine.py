"""The MuJoCo engine: grasps with a velocity servo, or a finger on two slides."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from trundle.experiments.blind.family import HiddenEffect, Hook
from trundle.experiments.blind.push import CONTACT_TIME_S
from trundle.experiments.blind.readings import Readings, step_averages
from trundle.experiments.blind.world import (
    BODY_HEIGHT_M,
    add_disc,
    add_gripper,
    add_slides,
    add_wheel,
    compile_effects,
    new_world,
    servo_wrench,
    step,
)
from trundle.experiments.sampling import Floats
from trundle.experiments.wide.scene import WideScene
from trundle.experiments.wide.strokes import Finger
from trundle.experiments.wide.trajectory import grasp_readings, grid_readings

__all__ = ["TIME_STEP_S", "simulate"]


TIME_STEP_S = 1e-3
"""Simulation step of grasps; free pushes use half of it."""
TIP_RADIUS_M = 0.004
"""Radius of the fingertip."""
TIP_MASS_KG = 0.3
"""Mass of the fingertip. It lies behind the sensor, which reads the contact force only."""
TIP_SOLREF, TIP_SOLIMP = (0.01, 1.0), (0.1, 0.1, 0.001, 0.5, 2.0)
"""Contact parameters of the rubber tip, about 3·10⁴ N/m.

A higher impedance loses loaded contacts for single steps.
"""
TIP_BIT, TABLE_BITS = 4, 5
"""Collision bits. Obstacles use 1, feet 2."""


def simulate(scene: WideScene, hidden: Sequence[HiddenEffect], episode: int) -> Readings:
    """Return the readings of perfect instruments in an episode."""
    spec, table = build_world(scene, episode)
    model, hooks = compile_effects(spec, table, scene, hidden, episode)
    run = simulate_free_push if scene.strokes else simulate_grasp
    return run(model, scene, episode, hooks)


def build_world(scene: WideScene, episode: int) -> tuple[Any, Any]:
    """Return the world without effects, and its object."""
    spec, table = new_world(time_step(scene))
    add_parts(spec, table, scene)
    add_wheel(spec, table, "wheel", scene.wheel)
    if scene.strokes:
        add_finger(spec, scene, episode)
    else:
        add_gripper(spec, table, scene.pushes[episode].grasp)
    return spec, table


def time_step(scene: WideScene) -> float:
    """Return the simulation step, s."""
    return TIME_STEP_S / 2 if scene.strokes else TIME_STEP_S


def add_parts(spec: Any, table: Any, scene: WideScene) -> None:
    """Add the object's geometry of equal density: a cylinder, or prisms."""
    shape: Any = scene.shape
    common = {"contype": TABLE_BITS, "conaffinity": TABLE_BITS, "condim": 1}
    if add_disc(table, scene, **common):
        return
    for k, part in enumerate(shape.parts):
        name, low, high = f"part {k}", BODY_HEIGHT_M - 0.1, BODY_HEIGHT_M + 0.1
        corners = np.vstack([np.column_stack([part, np.full(len(part), z)]) for z in (low, high)])
        spec.add_mesh(name=name, uservert=corners.ravel().tolist())
        mass = scene.mass * area(part) / shape.area
        table.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, mass=mass, **common)


def area(ring: Floats) -> float:
    """Return the area of a polygon."""
    x, y = ring.T
    return float(abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2)


def add_finger(spec: Any, scene: WideScene, episode: int) -> None:
    """Add the finger: a small ball on two slides with a servo of the arm's stiffness."""
    strokes = scene.strokes[episode]
    tip = spec.worldbody.add_body(name="tip", pos=[0.0, 0.0, BODY_HEIGHT_M])
    add_slides(tip, "tip ")
    tip.add_geom(
        name="tip",
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[TIP_RADIUS_M, 0, 0],
        mass=TIP_MASS_KG,
        contype=TIP_BIT,
        conaffinity=0,
        condim=3 if strokes.friction else 1,
        priority=1,
        friction=[max(strokes.friction, 1e-3), 0.0, 0.0],
        solref=list(TIP_SOLREF),
        solimp=list(TIP_SOLIMP),
    )
    stiffness, damping = strokes.stiffness, arm_damping(scene, episode)
    for axis in ("x", "y"):
        spec.add_actuator(
            name=f"tip {axis}",
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            target=f"tip {axis}",
            gaintype=mujoco.mjtGain.mjGAIN_FIXED,
            gainprm=[1.0] + [0.0] * 9,
            biastype=mujoco.mjtBias.mjBIAS_AFFINE,
            biasprm=[0.0, -stiffness, -damping] + [0.0] * 7,
        )


def arm_damping(scene: WideScene, episode: int) -> float:
    """Return the damping of the finger's servo, N·s/m: damping ratio 0.3 with the object's mass."""
    return float(0.6 * np.sqrt(scene.strokes[episode].stiffness * scene.mass))


def simulate_grasp(model: Any, scene: WideScene, episode: int, hooks: Sequence[Hook]) -> Readings:
    """Simulate an episode of a grasp. The force is proportional to the velocity error."""
    push: Any = scene.pushes[episode]
    data, t, poses, forces = initial_state(model, scene, episode)
    wanted, slot = push.desired_twist(t).tolist(), model.actuator("gripper x").id
    for k in range(len(t)):
        poses[k] = data.qpos[:3]
        forces[k] = data.ctrl[slot : slot + 3] = servo_wrench(data, scene, push, wanted[k])
        step(model, data, hooks)
    return grasp_readings(scene, episode, t, poses, step_averages(forces))


def simulate_free_push(model: Any, scene: WideScene, episode: int, hooks: Sequence[Hook]) -> Readings:
    """Simulate an episode of free pushing. The sensor reads the contact force."""
    data, t, poses, forces = initial_state(model, scene, episode)
    strokes, damping = scene.strokes[episode], arm_damping(scene, episode)
    finger, tips = Finger(strokes, scene.shape, time_step(scene)), np.empty((len(t), 2))
    at, speed = model.joint("tip x").qposadr[0], model.joint("tip x").dofadr[0]
    slot, geom, was = model.actuator("tip x").id, model.geom("tip").id, None
    reader = ContactForceReader(model, geom)
    for k in range(len(t)):
        poses[k] = data.qpos[:3]
        x, y, vx, vy, down = finger.at(float(t[k]), data.qpos[:3].tolist())
        if not down or not was:
            data.qpos[at : at + 2], data.qvel[speed : speed + 2] = (x, y), (vx, vy)
        if down != was:
            model.geom_contype[geom], was = TIP_BIT * down, down
        tips[k] = data.qpos[at : at + 2]
        data.ctrl[slot : slot + 2] = (
            strokes.stiffness * x + damping * vx,
            strokes.stiffness * y + damping * vy,
        )
        step(model, data, hooks)
        forces[k] = reader.read(data, tips[k])
    angle = scene.pushes[episode].grasp.angle
    return grid_readings(
        scene, episode, t, poses, np.column_stack([tips, np.full(len(t), angle)]), step_averages(forces)
    )


def initial_state(model: Any, scene: WideScene, episode: int) -> tuple[Any, Floats, Floats, Floats]:
    """Return the state at contact, the times of the steps, and arrays for poses and forces."""
    data = mujoco.MjData(model)
    data.qpos[:3] = scene.pushes[episode].start
    data.time = CONTACT_TIME_S
    n = round((scene.seconds[episode] - CONTACT_TIME_S) / time_step(scene))
    t: Floats = CONTACT_TIME_S + time_step(scene) * np.arange(n + 1, dtype=np.float64)
    return data, t, np.empty((n + 1, 3)), np.zeros((n + 1, 3))


class ContactForceReader:
    """Reads the contact force on the object, world axes, and its moment about the finger's centre."""

    def __init__(self, model: Any, geom: int) -> None:
        self.model, self.geom = model, geom
        self.local = np.empty(6)

    def read(self, data: Any, tip: Floats) -> list[float]:
        """Return force and moment of the last step."""
        total = [0.0, 0.0, 0.0]
        for k in range(data.ncon):
            contact = data.contact[k]
            if self.geom not in (contact.geom1, contact.geom2):
                continue
            mujoco.mj_contactForce(self.model, data, k, self.local)
            force = contact.frame.reshape(3, 3).T @ self.local[:3]
            fx, fy = (force[:2] if contact.geom1 == self.geom else -force[:2]).tolist()
            rx, ry = (contact.pos[:2] - tip).tolist()
            total = [total[0] + fx, total[1] + fy, total[2] + rx * fy - ry * fx]
        return total
