"""A case in MuJoCo: grasps that exert a servo's force, or a finger on two slides that touches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from trundle.experiments.blind.family import Hidden, Hook, Site
from trundle.experiments.blind.push import CONTACT
from trundle.experiments.blind.seen import Seen
from trundle.experiments.blind.world import HEIGHT, add_wheel, at_site, exerted, quaternion
from trundle.experiments.wide.motion import course, grasp_course, middle
from trundle.experiments.wide.scene import WideScene
from trundle.experiments.wide.strokes import Finger

__all__ = ["STEP", "simulate"]

Floats = NDArray[np.float64]

STEP = 1e-3
"""s; half of it where a finger strikes."""
TIP_RADIUS = 0.004
"""m."""
TIP_MASS = 0.3
"""kg; it lies behind the sensor, which reads the contact alone."""
TIP_SOLREF, TIP_SOLIMP = (0.01, 1.0), (0.1, 0.1, 0.001, 0.5, 2.0)
"""Of the fingertip's rubber, some 3·10⁴ N/m. At a higher impedance contacts under load are lost for single
steps, hundreds in a recording: impulses that no sampled reading shows and no finger lacks."""
TIP_BIT, TABLE_BITS = 4, 5
"""Collision bits: obstacles use 1, feet 2."""


def simulate(scene: WideScene, hidden: Sequence[Hidden], episode: int) -> Seen:
    """Return what perfect instruments would read in an episode."""
    spec, table = furnished(scene, episode)
    site = Site(spec, table, scene, episode)
    for one in hidden:
        one.family.furnish(site, one.values)
    model = spec.compile()
    found = [one.family.hook(model, site, one.values) for one in hidden]
    hooks = [hook for hook in found if hook is not None]
    run = pushed if scene.strokes else grasped
    return run(model, scene, episode, hooks)


def furnished(scene: WideScene, episode: int) -> tuple[Any, Any]:
    """Return the world without any effect, and its object."""
    spec = mujoco.MjSpec()
    spec.option.timestep = step_of(scene)
    spec.option.gravity = [0.0, 0.0, 0.0]
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 100.0
    table = spec.worldbody.add_body(name="table")
    add_slides(table, "")
    table.add_joint(name="theta", type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 0, 1])
    add_parts(spec, table, scene)
    add_wheel(spec, table, "wheel", scene.wheel)
    if scene.strokes:
        add_finger(spec, scene, episode)
        return spec, table
    grasp = scene.pushes[episode].grasp
    table.add_site(name="grasp", pos=[grasp.x, grasp.y, 0.0], quat=quaternion(grasp.angle))
    for along, index in (("x", 0), ("y", 1), ("turn", 5)):
        spec.add_actuator(name=f"gripper {along}", **at_site("grasp", index))
    return spec, table


def step_of(scene: WideScene) -> float:
    """Return the step, s."""
    return STEP / 2 if scene.strokes else STEP


def add_slides(body: Any, prefix: str) -> None:
    """Let a body slide along x and y."""
    for name, axis in (("x", [1, 0, 0]), ("y", [0, 1, 0])):
        body.add_joint(name=f"{prefix}{name}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)


def add_parts(spec: Any, table: Any, scene: WideScene) -> None:
    """Give the object its parts, of one density: a cylinder, or prisms."""
    shape: Any = scene.shape
    common = {"contype": TABLE_BITS, "conaffinity": TABLE_BITS, "condim": 1}
    if shape.disc is not None:
        x, y, radius = shape.disc
        kind = mujoco.mjtGeom.mjGEOM_CYLINDER
        table.add_geom(type=kind, size=[radius, 0.1, 0.0], pos=[x, y, HEIGHT], mass=scene.mass, **common)
        return
    for k, part in enumerate(shape.parts):
        name, low, high = f"part {k}", HEIGHT - 0.1, HEIGHT + 0.1
        corners = np.vstack([np.column_stack([part, np.full(len(part), z)]) for z in (low, high)])
        spec.add_mesh(name=name, uservert=corners.ravel().tolist())
        mass = scene.mass * area(part) / shape.area
        table.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, mass=mass, **common)


def area(ring: Floats) -> float:
    """Return the area of a polygon."""
    x, y = ring.T
    return float(abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2)


def add_finger(spec: Any, scene: WideScene, episode: int) -> None:
    """Add the finger: a small ball on two slides, held by a servo of the arm's stiffness."""
    strokes = scene.strokes[episode]
    tip = spec.worldbody.add_body(name="tip", pos=[0.0, 0.0, HEIGHT])
    add_slides(tip, "tip ")
    tip.add_geom(
        name="tip",
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[TIP_RADIUS, 0, 0],
        mass=TIP_MASS,
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


def grasped(model: Any, scene: WideScene, episode: int, hooks: Sequence[Hook]) -> Seen:
    """Simulate an episode of a grasp: its force is in proportion to the velocity that is missing."""
    push: Any = scene.pushes[episode]
    data, t, poses, forces = begun(model, scene, episode)
    wanted, slot = push.wanted(t).tolist(), model.actuator("gripper x").id
    for k in range(len(t)):
        poses[k] = data.qpos[:3]
        forces[k] = data.ctrl[slot : slot + 3] = exerted(data, scene, push, wanted[k])
        advance(model, data, hooks)
    return grasp_course(scene, episode, t, poses, middle(forces))


def pushed(model: Any, scene: WideScene, episode: int, hooks: Sequence[Hook]) -> Seen:
    """Simulate an episode of free pushing; the sensor reads the contact's force."""
    data, t, poses, forces = begun(model, scene, episode)
    strokes, damping = scene.strokes[episode], arm_damping(scene, episode)
    finger, tips = Finger(strokes, scene.shape, step_of(scene)), np.empty((len(t), 2))
    at, speed = model.joint("tip x").qposadr[0], model.joint("tip x").dofadr[0]
    slot, geom, was = model.actuator("tip x").id, model.geom("tip").id, None
    reader = Reader(model, geom)
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
        advance(model, data, hooks)
        forces[k] = reader.read(data, tips[k])
    angle = scene.pushes[episode].grasp.angle
    return course(scene, episode, t, poses, np.column_stack([tips, np.full(len(t), angle)]), middle(forces))


def begun(model: Any, scene: WideScene, episode: int) -> tuple[Any, Floats, Floats, Floats]:
    """Return the state at contact, the times of the steps, and room for poses and forces."""
    data = mujoco.MjData(model)
    data.qpos[:3] = scene.pushes[episode].start
    data.time = CONTACT
    n = round((scene.seconds[episode] - CONTACT) / step_of(scene))
    t: Floats = CONTACT + step_of(scene) * np.arange(n + 1, dtype=np.float64)
    return data, t, np.empty((n + 1, 3)), np.zeros((n + 1, 3))


def advance(model: Any, data: Any, hooks: Sequence[Hook]) -> None:
    """Do one step with what the effects add."""
    if hooks:
        data.qfrc_applied[:] = 0.0
        for hook in hooks:
            hook(data)
    mujoco.mj_step(model, data)


class Reader:
    """Reads the force of the finger on the object, world axes, and its moment about the finger's centre."""

    def __init__(self, model: Any, geom: int) -> None:
        self.model, self.geom = model, geom
        self.local = np.empty(6)

    def read(self, data: Any, tip: Floats) -> list[float]:
        """Return force and moment in the step that was just done."""
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
