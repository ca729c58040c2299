"""Rigid groups: bodies that move as one, with their inertial parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trundle._native import TrundleError
from trundle.mechanism.source import import_mujoco

__all__ = ["SECOND_MOMENTS", "RigidGroup", "first_body", "rigid_groups", "scale_masses"]

Floats = NDArray[np.float64]

SECOND_MOMENTS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Order of the second moments among the inertial parameters: xx, yy, zz, xy, xz, yz."""


@dataclass(frozen=True)
class RigidGroup:
    """Bodies without a joint between them.

    Attributes
    ----------
    name : str
        Name of the first body, which carries the group's joints.
    body : int
        Index of the first body.
    members : tuple of int
        Indices of the bodies whose masses scale together; payloads are not among them.
    chain : tuple of int
        Degrees of freedom on which the group's motion depends, from the base.
    mass : float
        Of the members, kg.
    parameters : (10,) array
        Mass, first moments and second moments of the members, in the first body's axes.
    compensated : (10,) array
        The same, each body weighted by the share of its weight that `gravcomp` cancels; second moments are 0.
    carried : (10,) array
        Inertial parameters of the payload.
    """

    name: str
    body: int
    members: tuple[int, ...]
    chain: tuple[int, ...]
    mass: float
    parameters: Floats
    compensated: Floats
    carried: Floats


def rigid_groups(model: Any, payload: str) -> list[RigidGroup]:
    """Return the moving groups of a compiled model.

    Parameters
    ----------
    model : mujoco.MjModel
    payload : str
        Name of the body that represents a payload; it keeps its mass when the group's mass is scaled.
    """
    mujoco = import_mujoco()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    firsts = [body for body in range(1, model.nbody) if model.body_weldid[body] == body]
    return [_group(model, data, first, payload) for first in firsts]


def _group(model: Any, data: Any, first: int, payload: str) -> RigidGroup:
    bodies = [body for body in range(first, model.nbody) if model.body_weldid[body] == first]
    parameters = {body: body_parameters(model, data, first, body) for body in bodies}
    members = tuple(body for body in bodies if model.body(body).name != payload)
    compensated = [model.body_gravcomp[body] * np.r_[parameters[body][:4], np.zeros(6)] for body in members]
    return RigidGroup(
        name=model.body(first).name,
        body=first,
        members=members,
        chain=tuple(_chain(model, first)),
        mass=float(model.body_mass[list(members)].sum()),
        parameters=np.sum([parameters[body] for body in members], axis=0),
        compensated=np.sum(compensated, axis=0),
        carried=np.sum([np.zeros(10), *(parameters[body] for body in bodies if body not in members)], axis=0),
    )


def _chain(model: Any, body: int) -> Iterator[int]:
    """Yield the degrees of freedom of a body and its ancestors, from the base."""
    if body:
        yield from _chain(model, model.body_parentid[body])
        yield from range(model.body_dofadr[body], model.body_dofadr[body] + model.body_dofnum[body])


def body_parameters(model: Any, data: Any, frame: int, body: int) -> Floats:
    """Return mass, first and second moments of a body in the axes of another body of its group."""
    rotation = data.xmat[frame].reshape(3, 3)
    centre = rotation.T @ (data.xipos[body] - data.xpos[frame])
    axes = rotation.T @ data.ximat[body].reshape(3, 3)
    mass, inertia = model.body_mass[body], model.body_inertia[body]
    # Second moments of a body about its centre: half the trace of the inertia, less the inertia.
    moments = axes @ np.diag(inertia.sum() / 2 - inertia) @ axes.T + mass * np.outer(centre, centre)
    return np.array([mass, *(mass * centre), *(moments[i, j] for i, j in SECOND_MOMENTS)])


def first_body(model: Any, body: str) -> str:
    """Return the moving body that a body is fixed to; `Mechanism.rigid_group` describes the errors."""
    mujoco = import_mujoco()
    found = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, body)
    first = model.body_weldid[found] if found >= 0 else 0
    if first == 0:
        reason = "does not move" if found >= 0 else "is not in the model"
        names = [model.body(k).name for k in range(1, model.nbody) if model.body_weldid[k] == k]
        raise TrundleError(f"body {body!r} {reason}; the moving bodies are {', '.join(names)}")
    return str(model.body(first).name)


def scale_masses(model: Any, groups: Sequence[RigidGroup], masses: Mapping[str, float]) -> None:
    """Give groups other masses in place; inertias scale with them."""
    mujoco = import_mujoco()
    by_name = {group.name: group for group in groups}
    for body, mass in masses.items():
        group = by_name[first_body(model, body)]
        members = list(group.members)
        model.body_mass[members] *= mass / group.mass
        model.body_inertia[members] *= mass / group.mass
    mujoco.mj_setConst(model, mujoco.MjData(model))
