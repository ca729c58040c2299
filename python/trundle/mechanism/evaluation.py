"""Inverse dynamics of a compiled model at many samples."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trundle.mechanism.inertial import Frames
from trundle.mechanism.source import import_mujoco

__all__ = ["inverse_dynamics", "inverse_with_frames", "switch_off"]

Floats = NDArray[np.float64]


def switch_off(model: Any) -> None:
    """Disable dry friction, equality constraints, actuation and sensors in a model.

    Dry friction is added outside of MuJoCo, where it is soft. Coupled joints follow exactly.
    """
    bits = import_mujoco().mjtDisableBit
    model.opt.disableflags |= int(
        bits.mjDSBL_FRICTIONLOSS | bits.mjDSBL_EQUALITY | bits.mjDSBL_ACTUATION | bits.mjDSBL_SENSOR
    )


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


def inverse_with_frames(
    model: Any, data: Any, q: Floats, v: Floats, a: Floats
) -> tuple[Floats, Floats, Frames]:
    """Return efforts (T, N), mass matrices (T, N, N), and the poses of bodies and joints."""
    mujoco = import_mujoco()
    n, bodies, count = model.nv, model.nbody, len(q)
    effort, matrix = np.empty((count, n)), np.empty((count, n, n))
    frames = Frames(
        position=np.empty((count, bodies, 3)),
        rotation=np.empty((count, bodies, 3, 3)),
        anchor=np.empty((count, n, 3)),
        axis=np.empty((count, n, 3)),
        hinge=np.array(model.jnt_type == int(mujoco.mjtJoint.mjJNT_HINGE)),
    )
    rotation = frames.rotation.reshape(count, bodies, 9)
    units = np.eye(n)
    for k in range(count):
        data.qpos[:], data.qvel[:], data.qacc[:] = q[k], v[k], a[k]
        mujoco.mj_inverse(model, data)
        effort[k] = data.qfrc_inverse
        frames.position[k], rotation[k] = data.xpos, data.xmat
        frames.anchor[k], frames.axis[k] = data.xanchor, data.xaxis
        for j in range(n):
            mujoco.mj_mulM(model, data, matrix[k, j], units[j])
    return effort, matrix, frames
