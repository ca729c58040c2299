"""The MuJoCo engine: grasps with a velocity servo, or a finger on two slides."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from trundle.experiments.blind import mujoco_world as world
from trundle.experiments.blind.family import HiddenEffect, Hook
from trundle.experiments.blind.push import Finger
from trundle.experiments.blind.readings import Readings, step_averages
from trundle.experiments.blind.scene import Scene
from trundle.experiments.blind.wide.measurement import grasp_readings, grid_readings
from trundle.experiments.sampling import Floats

__all__ = ["simulate"]

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


def simulate(scene: Scene, hidden: Sequence[HiddenEffect], episode: int) -> Readings:
    """Return the readings of perfect instruments in an episode."""
    spec, table = world.new_world(TIME_STEP_S / 2 if scene.strokes else TIME_STEP_S)
    add_parts(spec, table, scene)
    world.add_wheel(spec, table, "wheel", scene.wheel)
    if scene.strokes:
        add_finger(spec, scene, episode)
    else:
        world.add_gripper(spec, table, scene.pushes[episode].grasp)
    model, hooks = world.compile_effects(spec, table, scene, hidden, episode)
    if scene.strokes:
        return simulate_free_push(model, scene, episode, hooks)
    return grasp_readings(scene, episode, *world.simulate_grasp(model, scene, episode, hooks))


def add_parts(spec: Any, table: Any, scene: Scene) -> None:
    """Add the object's geometry of equal density: a cylinder, or prisms."""
    contact = {"contype": TABLE_BITS, "conaffinity": TABLE_BITS, "condim": 1}
    if world.add_disc(table, scene, **contact):
        return
    low, high = world.BODY_HEIGHT_M - 0.1, world.BODY_HEIGHT_M + 0.1
    for k, part in enumerate(scene.shape.parts):
        name = f"part {k}"
        corners = np.vstack([np.column_stack([part, np.full(len(part), z)]) for z in (low, high)])
        spec.add_mesh(name=name, uservert=corners.ravel().tolist())
        x, y = part.T
        area = float(abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2)
        mass = scene.mass * area / scene.shape.area
        table.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, mass=mass, **contact)


def add_finger(spec: Any, scene: Scene, episode: int) -> None:
    """Add the finger: a small ball on two slides with a servo of the arm's stiffness."""
    strokes = scene.strokes[episode]
    tip = spec.worldbody.add_body(name="tip", pos=[0.0, 0.0, world.BODY_HEIGHT_M])
    world.add_slides(tip, "tip ")
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
    bias = [0.0, -strokes.stiffness, -arm_damping(scene, episode)]
    for joint in ("tip x", "tip y"):
        world.add_bias(spec, joint, bias, 1.0, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=joint)


def arm_damping(scene: Scene, episode: int) -> float:
    """Return the damping of the finger's servo, N·s/m: damping ratio 0.3 with the object's mass."""
    return float(0.6 * np.sqrt(scene.strokes[episode].stiffness * scene.mass))


def simulate_free_push(model: Any, scene: Scene, episode: int, hooks: Sequence[Hook]) -> Readings:
    """Simulate an episode of free pushing. The sensor reads the contact force."""
    data, t, poses, forces = world.initial_state(model, scene, episode)
    stiffness, damping = scene.strokes[episode].stiffness, arm_damping(scene, episode)
    finger = Finger(scene.strokes[episode], scene.shape, model.opt.timestep)
    at, speed = model.joint("tip x").qposadr[0], model.joint("tip x").dofadr[0]
    slot, geom, was = model.actuator("tip x").id, model.geom("tip").id, None
    grippers = np.full((len(t), 3), scene.pushes[episode].grasp.angle)
    for k in range(len(t)):
        poses[k] = data.qpos[:3]
        x, y, vx, vy, down = finger.at(float(t[k]), data.qpos[:3].tolist())
        if not down or not was:
            data.qpos[at : at + 2], data.qvel[speed : speed + 2] = (x, y), (vx, vy)
        if down != was:
            model.geom_contype[geom], was = TIP_BIT * down, down
        grippers[k, :2] = data.qpos[at : at + 2]
        data.ctrl[slot : slot + 2] = (stiffness * x + damping * vx, stiffness * y + damping * vy)
        world.step(model, data, hooks)
        forces[k] = contact_force(model, data, geom, grippers[k, :2])
    return grid_readings(scene, episode, t, poses, grippers, step_averages(forces))


def contact_force(model: Any, data: Any, geom: int, tip: Floats) -> list[float]:
    """Return the contact force on the object, world axes, and its moment about the finger's centre."""
    local, total = np.empty(6), [0.0, 0.0, 0.0]
    for k in range(data.ncon):
        contact = data.contact[k]
        if geom not in (contact.geom1, contact.geom2):
            continue
        mujoco.mj_contactForce(model, data, k, local)
        force = contact.frame.reshape(3, 3).T @ local[:3]
        fx, fy = (force[:2] if contact.geom1 == geom else -force[:2]).tolist()
        rx, ry = (contact.pos[:2] - tip).tolist()
        total = [total[0] + fx, total[1] + fy, total[2] + rx * fy - ry * fx]
    return total
