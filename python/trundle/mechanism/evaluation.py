"""Inverse dynamics of a compiled model at many samples."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trundle.mechanism.inertial import Frames
from trundle.mechanism.source import import_mujoco

__all__ = ["Evaluation", "evaluate", "inverse_by_velocity", "inverse_dynamics", "switch_off"]

Floats = NDArray[np.float64]


def switch_off(model: Any, *, contacts: bool) -> None:
    """Disable dry friction, equality constraints, actuation, sensors and perhaps contacts in a model.

    Dry friction is added outside of MuJoCo, where it is soft. Coupled joints follow exactly. Time is
    continuous, and no body sleeps. Disabled gravity becomes zero gravity, where derivatives are taken.
    """
    mujoco = import_mujoco()
    bits, enabled = mujoco.mjtDisableBit, mujoco.mjtEnableBit
    model.opt.enableflags &= ~int(enabled.mjENBL_INVDISCRETE | enabled.mjENBL_SLEEP)
    if model.opt.disableflags & int(bits.mjDSBL_GRAVITY):
        model.opt.gravity[:] = 0.0
        model.opt.disableflags &= ~int(bits.mjDSBL_GRAVITY)
    model.opt.disableflags |= int(
        bits.mjDSBL_FRICTIONLOSS | bits.mjDSBL_EQUALITY | bits.mjDSBL_ACTUATION | bits.mjDSBL_SENSOR
    )
    if not contacts:
        model.opt.disableflags |= int(bits.mjDSBL_CONTACT)


def inverse_dynamics(model: Any, data: Any, q: Floats, v: Floats, a: Floats) -> Floats:
    """Return the efforts at all joints, (T, N), that the model needs for a motion, (T, N) each."""
    inverse = import_mujoco().mj_inverse
    position, velocity, acceleration, effort = data.qpos, data.qvel, data.qacc, data.qfrc_inverse
    out = np.empty_like(q)
    for k in range(len(q)):
        position[:], velocity[:], acceleration[:] = q[k], v[k], a[k]
        inverse(model, data)
        out[k] = effort
    return out


def inverse_by_velocity(
    model: Any, data: Any, q: Floats, motions: Sequence[tuple[Floats, Floats]]
) -> list[Floats]:
    """Return the efforts, (T, N) each, for velocities and accelerations at the same positions, (T, N).

    MuJoCo evaluates kinematics, mass matrix and contacts once for each position.
    """
    mujoco = import_mujoco()
    inverse, stage = mujoco.mj_inverseSkip, (mujoco.mjtStage.mjSTAGE_NONE, mujoco.mjtStage.mjSTAGE_POS)
    out = [np.empty_like(q) for _ in motions]
    for k in range(len(q)):
        data.qpos[:] = q[k]
        for number, (v, a) in enumerate(motions):
            data.qvel[:], data.qacc[:] = v[k], a[k]
            inverse(model, data, stage[number > 0], 1)
            out[number][k] = data.qfrc_inverse
    return out


@dataclass(frozen=True)
class Evaluation:
    """Inverse dynamics at T samples of N joints.

    Attributes
    ----------
    effort : (T, N) array
        Dry friction not included.
    constraint : (T, N) array
        The part of the effort that works against limits and contacts.
    matrix : (T, N, N) array
        Mass matrices.
    contacts : (T,) array
        Numbers of contacts.
    frames : Frames
        Poses of bodies and joints.
    """

    effort: Floats
    constraint: Floats
    matrix: Floats
    contacts: NDArray[np.intp]
    frames: Frames


def evaluate(model: Any, data: Any, q: Floats, v: Floats, a: Floats) -> Evaluation:
    """Return the inverse dynamics of a motion, (T, N) each, with what derivatives need."""
    mujoco = import_mujoco()
    n, bodies, count = model.nv, model.nbody, len(q)
    frames = Frames(
        position=np.empty((count, bodies, 3)),
        rotation=np.empty((count, bodies, 3, 3)),
        anchor=np.empty((count, n, 3)),
        axis=np.empty((count, n, 3)),
        hinge=np.array(model.jnt_type == int(mujoco.mjtJoint.mjJNT_HINGE)),
    )
    out = Evaluation(
        effort=np.empty((count, n)),
        constraint=np.empty((count, n)),
        matrix=np.empty((count, n, n)),
        contacts=np.zeros(count, dtype=np.intp),
        frames=frames,
    )
    rotation, units = frames.rotation.reshape(count, bodies, 9), np.eye(n)
    for k in range(count):
        data.qpos[:], data.qvel[:], data.qacc[:] = q[k], v[k], a[k]
        mujoco.mj_inverse(model, data)
        out.effort[k], out.contacts[k] = data.qfrc_inverse, data.ncon
        np.negative(data.qfrc_constraint, out=out.constraint[k])
        frames.position[k], rotation[k] = data.xpos, data.xmat
        frames.anchor[k], frames.axis[k] = data.xanchor, data.xaxis
        for j in range(n):
            mujoco.mj_mulM(model, data, out.matrix[k, j], units[j])
    return out
