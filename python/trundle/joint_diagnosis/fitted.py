"""A mechanism with fitted nominal values and the effects that its model can hold."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from trundle.mechanism import Mechanism
    from trundle.mechanism.drives import Drive
    from trundle.mechanism.simulation import JointLaws
    from trundle.mechanism.transmissions import SplitModel, Transmission

__all__ = ["FittedModel", "fitted_mechanism"]

Floats = NDArray[np.float64]

NOMINAL = ("armature", "damping", "mass")
"""Nominal values that a MuJoCo model has."""
MIN_MASS_SHARE = 1e-3
"""Smallest share of a mass that remains: MuJoCo cannot simulate bodies without inertia."""
STEP_S = 0.002
"""Longest step of the simulation, s."""


class FittedModel:
    """An MJCF or URDF model with fitted values: see `trundle.joint_diagnosis.under_test.FittedMechanism`.

    Parameters
    ----------
    mechanism : Mechanism
    model : mapping
        Nominal values and effects, as in the outcome of a diagnosis.
    on_drive : collection of str
        Joints whose encoder is at the drive.
    """

    def __init__(self, mechanism: Mechanism, model: Mapping[str, Any], on_drive: Collection[str]) -> None:
        from trundle.mechanism.transmissions import can_be_split

        self.mechanism = fitted_mechanism(mechanism, model)
        self.transmissions = list(transmissions_of(model, on_drive))
        self.can_simulate = can_be_split(self.mechanism, self.transmissions)

    @cached_property
    def split(self) -> SplitModel:
        """The model with a joint for each transmission."""
        from trundle.mechanism.transmissions import split_model

        return split_model(self.mechanism, self.transmissions)

    def needed(self, t: Floats, q: Floats, v: Floats, a: Floats) -> tuple[Floats, Floats]:
        """Return the effort for a motion, and the diagonal of the mass matrix, (T, n) each."""
        found = self.mechanism.regressors(q, v, a, derivatives=False)
        return found.effort, np.einsum("tii->ti", found.mass_matrix)

    def simulate(
        self, t: Floats, q: Floats, v: Floats, drive: Drive, laws: JointLaws | None, known: Drive | None
    ) -> Floats:
        """Return positions, (T, n), in open loop from a state; NaN after a divergence."""
        from trundle.mechanism import simulate

        return simulate(self.mechanism, t, q, v, drive, laws, known=known, split=self.split, step=STEP_S)[0]


def transmissions_of(model: Mapping[str, Any], on_drive: Collection[str]) -> Iterator[Transmission]:
    """Yield the plays and elastic transmissions among the effects of a model."""
    from trundle.mechanism.transmissions import Transmission

    for one in model["effects"]:
        joint, values = one.get("joint"), one["values"]
        if one["kind"] == "joint_backlash":
            yield Transmission(joint, joint in on_drive, gap=values["gap"])
        elif one["kind"] == "joint_elasticity":
            damping = values.get("damping", 0.0)
            yield Transmission(joint, joint in on_drive, stiffness=values["stiffness"], damping=damping)


def fitted_mechanism(mechanism: Mechanism, model: Mapping[str, Any]) -> Mechanism:
    """Return a mechanism with fitted values, payloads, tilt of the base and additional armature.

    Parameters
    ----------
    mechanism : Mechanism
    model : mapping
        Nominal values and effects, as in the outcome of a diagnosis.
    """
    changes: dict[str, dict[str, float]] = {key: {} for key in NOMINAL}
    for name, value in model["nominal"].items():
        key, _, where = name.partition(":")
        if key == "mass":
            value = max(value, MIN_MASS_SHARE * mechanism.masses[where])
        if key in changes:
            changes[key][where] = value
    for one in model["effects"]:
        if one["kind"] == "rotor_inertia":
            own = changes["armature"].get(one["joint"], mechanism.armature[mechanism.column(one["joint"])])
            changes["armature"][one["joint"]] = float(own) + one["values"]["armature"]
    found = mechanism.adjusted(**changes)
    for one in model["effects"]:
        if one["kind"] == "payload":
            centre = np.array([one["values"].get(f"com_{axis}", 0.0) for axis in "xyz"])
            add_point_mass(found.compiled, one["body"], one["values"]["mass"], centre)
        elif one["kind"] == "base_tilt":
            tilt(found.compiled, one["values"]["angle_x"], one["values"]["angle_y"])
    return found


def add_point_mass(compiled: Any, body: str, mass: float, centre: NDArray[np.float64]) -> None:
    """Add a point mass, kg, at a place in the axes of a body, in place."""
    from trundle.mechanism.source import import_mujoco

    mujoco = import_mujoco()
    k = compiled.body(body).id
    axes = np.zeros(9)
    mujoco.mju_quat2Mat(axes, compiled.body_iquat[k])
    own = axes.reshape(3, 3) @ np.diag(compiled.body_inertia[k]) @ axes.reshape(3, 3).T
    masses = np.array([compiled.body_mass[k], mass])
    centres = np.array([compiled.body_ipos[k], centre])
    mean = masses @ centres / masses.sum()
    for part, place in zip(masses, centres - mean, strict=True):
        own = own + part * (place @ place * np.eye(3) - np.outer(place, place))
    moments, vectors = np.linalg.eigh(own)
    vectors[:, 2] *= np.sign(np.linalg.det(vectors))
    compiled.body_mass[k], compiled.body_ipos[k], compiled.body_inertia[k] = masses.sum(), mean, moments
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, vectors.ravel())
    compiled.body_iquat[k] = quaternion
    mujoco.mj_setConst(compiled, mujoco.MjData(compiled))


def tilt(compiled: Any, angle_x: float, angle_y: float) -> None:
    """Turn gravity about the world's x axis, then about its y axis, rad, in place."""
    (cx, sx), (cy, sy) = ((np.cos(angle), np.sin(angle)) for angle in (angle_x, angle_y))
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    compiled.opt.gravity[:] = about_y @ about_x @ compiled.opt.gravity
