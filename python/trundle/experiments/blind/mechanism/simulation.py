"""Simulate the controlled motion of a mechanism with hidden effects, by one of two engines.

MuJoCo's engine uses MuJoCo's features: dry friction as a constraint, springs, limits, joints for play and
elasticity, implicit integration. The other engine takes only the mass matrix and the bias forces from
MuJoCo. It adds LuGre friction (Canudas de Wit et al., 1995), penalty contacts and springs of its own, and
integrates by the linearly implicit Euler method.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np

from trundle.experiments.blind.mechanism.family import HiddenEffect, State
from trundle.experiments.blind.mechanism.scene import TIME_STEP, Scene
from trundle.experiments.sampling import Floats

__all__ = ["Motion", "simulate"]

BRISTLE_DEFLECTION = 2e-4
"""Deflection at which LuGre friction slides, as a share of the joint's span."""
WORKSPACE = 50.0
"""Largest position of a stable simulation, rad or m."""
CONTROL_STEPS = 4
"""Largest number of time steps between commands of a controller whose effort is measured."""


@dataclass(frozen=True)
class Motion:
    """An episode at every time step.

    Attributes
    ----------
    t : (T,) array
    q, drive, v : (T, n) arrays
        Positions of the joints and of their drives, and speeds of the joints.
    command, effort, target : (T, n) arrays
        Commanded and acting efforts; commanded positions.
    """

    t: Floats
    q: Floats
    drive: Floats
    v: Floats
    command: Floats
    effort: Floats
    target: Floats


class World:
    """A compiled MuJoCo model of a scene with the effects, and the places of its joints."""

    def __init__(
        self, scene: Scene, hidden: Sequence[HiddenEffect], payload: float | None, native: bool
    ) -> None:
        spec = mujoco.MjSpec.from_string(scene.robot.text)
        spec.option.timestep = TIME_STEP
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        for joint in scene.robot.joints:
            found = spec.joint(joint)
            found.armature *= scene.truth["armature"][joint]
            found.damping = [found.damping[0] * scene.truth["damping"][joint], 0.0, 0.0]
        for one in hidden:
            for build in (one.family.model, one.family.native if native else None):
                if build is not None:
                    build(spec, scene.robot.joints[one.values["joint"]], one.values)
        if payload is not None:
            extra = spec.body(scene.last_body).add_body(name="payload")
            extra.mass, extra.inertia, extra.explicitinertial = payload, [1e-8, 1e-8, 1e-8], True
        self.model = spec.compile()
        for body, factor in scene.truth["mass"].items():
            k = self.model.body(body).id
            self.model.body_mass[k] *= factor
            self.model.body_inertia[k] *= factor
        self.data = mujoco.MjData(self.model)
        mujoco.mj_setConst(self.model, self.data)
        joints = scene.robot.joints
        self.dofs = np.array([self.model.joint(joint).dofadr[0] for joint in joints])
        names = {self.model.joint(k).name for k in range(self.model.njnt)}
        self.plays = [
            (i, int(self.model.joint(f"{joint}_play").dofadr[0]))
            for i, joint in enumerate(joints)
            if f"{joint}_play" in names
        ]
        self.matrix = np.zeros((self.model.nv, self.model.nv))

    def external(self, acceleration: Floats) -> Floats:
        """Return bias forces and the efforts of the other joints' accelerations, (n,)."""
        mujoco.mj_fullM(self.model, self.data, self.matrix)
        own = np.diag(self.matrix)
        total = self.matrix @ acceleration - own * acceleration + self.data.qfrc_bias
        found: Floats = total[self.dofs]
        return found


class MuJoCoEngine:
    """Steps of MuJoCo itself."""

    def __init__(self, scene: Scene, hidden: Sequence[HiddenEffect], payload: float | None) -> None:
        self.world = World(scene, hidden, payload, native=True)
        self.levels = [one for one in hidden if one.family.level is not None]
        self.forces = [one for one in hidden if one.family.force is not None and one.family.native is None]
        self.own = self.world.model.dof_frictionloss.copy()

    def start(self, q: Floats) -> None:
        """Begin at rest."""
        mujoco.mj_resetData(self.world.model, self.world.data)
        self.world.data.qpos[self.world.dofs] = q
        mujoco.mj_forward(self.world.model, self.world.data)

    def state(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Return positions of joints and drives, speeds and accelerations of joints."""
        data, dofs = self.world.data, self.world.dofs
        drive, v, a = data.qpos[dofs], data.qvel[dofs], data.qacc[dofs]
        q = drive.copy() if self.world.plays else drive
        for i, k in self.world.plays:
            q[i] += data.qpos[k]
            v[i] += data.qvel[k]
        return q, drive, v, a

    def step(self, effort: Floats, s: State) -> None:
        """Advance by a time step."""
        world = self.world
        data, model = world.data, world.model
        s.external = lambda: world.external(data.qacc)
        applied = np.zeros(len(effort))
        for one in self.forces:
            one.family.force(one.values, s, applied)  # type: ignore[misc]
        if self.levels:
            model.dof_frictionloss[:] = self.own
        for one in self.levels:
            model.dof_frictionloss[world.dofs[one.values["joint"]]] += one.family.level(one.values, s)  # type: ignore[misc]
        data.qfrc_applied[:] = 0.0
        data.qfrc_applied[world.dofs] = effort + applied
        for i, k in world.plays:
            data.qfrc_applied[k] = applied[i]
        mujoco.mj_step(model, data)


class StiffEngine:
    """Equations of motion with LuGre friction, by the linearly implicit Euler method."""

    def __init__(self, scene: Scene, hidden: Sequence[HiddenEffect], payload: float | None) -> None:
        self.world = World(scene, hidden, payload, native=False)
        self.forces = [one for one in hidden if one.family.force is not None]
        self.levels = [one for one in hidden if one.family.level is not None]
        self.links = [one for one in hidden if one.family.transmission is not None]
        model = self.world.model
        self.damping, self.armature = model.dof_damping.copy(), model.dof_armature.copy()
        model.dof_damping[:] = 0.0
        self.split = np.isin(np.arange(scene.n), [one.values["joint"] for one in self.links])
        for one in self.links:
            model.dof_armature[one.values["joint"]] = 0.0
        spans = np.array([high - low for low, high in scene.robot.spans.values()])
        self.deflection = BRISTLE_DEFLECTION * spans

    def start(self, q: Floats) -> None:
        """Begin at rest."""
        n = len(q)
        self.q, self.v, self.a = q.copy(), np.zeros(n), np.zeros(n)
        self.drive, self.drive_v, self.bristles = q.copy(), np.zeros(n), np.zeros(n)

    def state(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Return positions of joints and drives, speeds and accelerations of joints."""
        return self.q, np.where(self.split, self.drive, self.q), self.v, self.a

    def step(self, effort: Floats, s: State) -> None:
        """Advance by a time step."""
        world, dt, n = self.world, TIME_STEP, len(self.q)
        data, model = world.data, world.model
        data.qpos[:], data.qvel[:] = self.q, self.v
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        s.external = lambda: world.external(self.a)
        applied = np.zeros(n)
        for one in self.forces:
            one.family.force(one.values, s, applied)  # type: ignore[misc]
        # Drives: efforts, damping and friction act on them; without a transmission the drive is the joint.
        level = np.zeros(n)
        for one in self.levels:
            level[one.values["joint"]] += one.family.level(one.values, s)  # type: ignore[misc]
        split = {one.values["joint"]: one for one in self.links}
        drive_v = np.where(self.split, self.drive_v, self.v)
        slope = np.where(level > 0, level / self.deflection, 0.0)
        grown = 1.0 + dt * np.abs(drive_v) / self.deflection
        implicit = self.damping + dt * slope / grown
        push = effort - self.damping * drive_v - slope * (self.bristles + dt * drive_v) / grown
        mujoco.mj_fullM(model, data, world.matrix)
        total, diagonal = applied - data.qfrc_bias, np.zeros(n)
        for j in range(n):
            if j not in split:
                total[j] += push[j]
                diagonal[j] = implicit[j]
                continue
            x, xv = self.drive[j] - self.q[j], self.drive_v[j] - self.v[j]
            through = split[j].family.transmission(split[j].values, x, xv)  # type: ignore[misc]
            total[j] += through
            rotor = (push[j] - through) / (self.armature[j] + dt * implicit[j])
            self.drive_v[j] += dt * rotor
            self.drive[j] += dt * self.drive_v[j]
        self.a = np.linalg.solve(world.matrix + dt * np.diag(diagonal), total)
        self.v = self.v + dt * self.a
        self.q = self.q + dt * self.v
        new_v = np.where(self.split, self.drive_v, self.v)
        self.bristles = (self.bristles + dt * new_v) / grown


ENGINES: dict[str, Any] = {"mujoco": MuJoCoEngine, "lugre": StiffEngine}


def simulate(engine: str, scene: Scene, hidden: Sequence[HiddenEffect]) -> list[Motion] | None:
    """Return the motions of all episodes; None if one is unstable."""
    motions = []
    spans = np.array([high - low for low, high in scene.robot.spans.values()])
    for episode, payload in enumerate(scene.payloads):
        motion = simulate_episode(ENGINES[engine](scene, hidden, payload), scene, hidden, episode)
        reference = scene.reference(episode)
        if motion is None or np.any(np.abs(motion.q - reference).max(0) > 0.7 * spans):
            return None
        motions.append(motion)
    return motions


def simulate_episode(
    engine: Any, scene: Scene, hidden: Sequence[HiddenEffect], episode: int
) -> Motion | None:
    """Return the motion of an episode; None if it leaves the workspace."""
    reference = scene.reference(episode)
    kp, kd = scene.gains()
    every = round(1.0 / scene.rate / TIME_STEP)
    held = scene.source in ("commanded", "target")
    drives = [one.family.drive(one.values) for one in hidden if one.family.drive is not None]
    engine.start(reference[0])
    nominal = mujoco.MjModel.from_xml_string(scene.robot.text)
    planned = mujoco.MjData(nominal)
    rows: list[tuple[Floats, ...]] = []
    memory: dict[str, float] = {}
    command = np.zeros(scene.n)
    for k, wanted in enumerate(reference):
        q, drive, v, a = engine.state()
        if k % (every if held else min(CONTROL_STEPS, every)) == 0:
            if not np.abs(q).max() < WORKSPACE:
                return None
            target = wanted
            planned.qpos[:] = q
            mujoco.mj_fwdPosition(nominal, planned)
            mujoco.mj_fwdVelocity(nominal, planned)
            command = kp * (wanted - q) - kd * v + planned.qfrc_bias
        if scene.source == "target":
            acting = target
            for act in drives:
                acting = act(acting)
            effort = kp * (acting - drive) - kd * v
        else:
            effort = command
            for act in drives:
                effort = act(effort)
        rows.append((q, drive, v, command.copy(), effort, target))
        s = SimpleNamespace(t=k * TIME_STEP, q=q, v=v, a=a, u=effort, memory=memory)
        engine.step(effort, s)
    t: Floats = np.arange(len(reference), dtype=np.float64) * TIME_STEP
    return Motion(t, *(np.array(column) for column in zip(*rows, strict=True)))
