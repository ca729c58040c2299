"""Loading of models and their reduction to the recorded joints."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from trundle._native import TrundleError
from trundle.display.fields import DisplayedFields
from trundle.mechanism import locking
from trundle.mechanism.coupling import Coordinates
from trundle.mechanism.evaluation import switch_off
from trundle.mechanism.meshes import remove_appearance, remove_meshes
from trundle.mechanism.source import compile_model, import_mujoco, read_specification

__all__ = ["PAYLOAD", "Payload", "load_model"]

PAYLOAD = "trundle_payload"
"""Name of the body that represents a known payload."""
SINGULAR = 1e-9
"""Share of the trace below which an eigenvalue of an inertia tensor counts as zero."""


@dataclass(frozen=True, repr=False)
class Payload(DisplayedFields):
    """A known mass that an episode carries.

    Attributes
    ----------
    body : str
        The body that carries it.
    mass : float
        In kg.
    com : tuple of float
        Its place in the body's axes, m.

    Examples
    --------
    >>> from trundle.mechanism import Payload
    >>> Payload("forearm", 0.5, (0.0, 0.0, 0.1)).mass
    0.5
    """

    body: str
    mass: float
    com: tuple[float, float, float] = (0.0, 0.0, 0.0)


def load_model(
    source: str | os.PathLike[str], joints: Sequence[str], payload: Payload | None, contacts: bool
) -> tuple[Any, Any, Coordinates, list[str]]:
    """Load a model; `Mechanism.load` describes the arguments and errors.

    Returns
    -------
    spec : mujoco.MjSpec
    compiled : mujoco.MjModel
    coordinates : Coordinates
    missing_files : list of str
    """
    spec, name = read_specification(source)
    locking.name_bodies(spec)
    locking.check_joints(spec, name, joints)
    locking.remove_drives(spec)
    couplings = locking.find_couplings(spec, name, joints)
    kept = {*joints, *couplings}
    locking.lock_joints(spec, name, kept)
    moving = locking.moving_bodies(spec, kept)
    _correct_singular_inertias(spec)
    remove_appearance(spec)
    missing_files = remove_meshes(spec, name, moving)
    if payload is not None:
        _attach(spec, name, payload, moving)
    compiled = compile_model(spec, name)
    if payload is not None:
        _restore(compiled, payload)
    switch_off(compiled, contacts=contacts)
    names = tuple(compiled.joint(k).name for k in range(compiled.njnt))
    return spec, compiled, Coordinates(names, compiled.qpos0.copy(), tuple(joints), couplings), missing_files


def _correct_singular_inertias(spec: Any) -> None:
    """Replace singular inertia tensors, which MuJoCo refuses, by the nearest valid ones.

    An inertia I is that of a body if its second moments tr(I)/2 - I are not negative.
    """
    for body in spec.bodies:
        xx, yy, zz, xy, xz, yz = body.fullinertia
        full = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        if np.isnan(full).any() or abs(np.linalg.eigvalsh(full)[0]) > SINGULAR * np.trace(full):
            continue
        half = np.trace(full) / 2
        moments, axes = np.linalg.eigh(half * np.eye(3) - full)
        valid = np.maximum(moments, SINGULAR * half)
        full = axes @ np.diag(valid.sum() - valid) @ axes.T
        body.fullinertia = full[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]


def _attach(spec: Any, name: str, payload: Payload, moving: Mapping[str, str]) -> None:
    """Add a payload to a specification as a body without a joint."""
    if payload.body not in moving:
        raise TrundleError(
            f"{name}: payload: body {payload.body!r} is unknown or does not move; the moving bodies are "
            f"{', '.join(moving)}"
        )
    body = spec.body(payload.body).add_body(name=PAYLOAD)
    body.explicitinertial = True
    body.mass, body.ipos, body.inertia = payload.mass, list(payload.com), [0.0, 0.0, 0.0]


def _restore(compiled: Any, payload: Payload) -> None:
    """Undo what options of the compiler, such as `boundinertia`, did to a payload."""
    mujoco = import_mujoco()
    body = compiled.body(PAYLOAD).id
    compiled.body_mass[body], compiled.body_inertia[body] = payload.mass, 0.0
    mujoco.mj_setConst(compiled, mujoco.MjData(compiled))
