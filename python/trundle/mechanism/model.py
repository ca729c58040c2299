"""A mechanism: an MJCF or URDF model reduced to its recorded joints."""

from __future__ import annotations

import copy
import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trundle._native import TrundleError
from trundle.display.card import Card, Displayed
from trundle.mechanism.coupling import Coordinates
from trundle.mechanism.evaluation import inverse_dynamics
from trundle.mechanism.loading import PAYLOAD, Payload, load_model
from trundle.mechanism.motion import check_motion
from trundle.mechanism.regressors import Regressors, evaluate_regressors
from trundle.mechanism.rigid_groups import first_body, rigid_groups, scale_masses
from trundle.mechanism.source import import_mujoco

__all__ = ["Mechanism"]

Floats = NDArray[np.float64]


class Mechanism(Displayed):
    """A model with hinge and slide joints, evaluated by MuJoCo.

    Create one with `load`. Joints that are not recorded are locked at the model's reference `qpos0`, except
    those that follow a recorded joint by an equality constraint, which follow exactly. Actuators are removed.
    The model's own friction, springs, damping, limits, contacts and tendons remain.

    Attributes
    ----------
    joints : tuple of str
        The recorded joints. All arrays of n columns are in this order.
    bodies : tuple of str
        The moving bodies: the first of each group of bodies that move as one.
    followers : tuple of str
        Joints that follow recorded ones.
    missing_files : tuple of str
        Meshes that were not found and whose geoms were removed.

    Examples
    --------
    >>> from trundle.mechanism import Mechanism
    >>> text = '''<mujoco><worldbody><body name="arm"><joint name="elbow" axis="0 1 0" armature="0.1"/>
    ...   <inertial pos="0 0 -0.5" mass="2" diaginertia="0.01 0.01 0.01"/></body></worldbody></mujoco>'''
    >>> arm = Mechanism.load(text, ["elbow"])
    >>> arm.bodies, arm.masses, arm.armature.tolist()
    (('arm',), {'arm': 2.0}, [0.1])
    >>> effort = arm.inverse_dynamics([[0.5]], [[0.0]], [[0.0]])
    >>> round(float(effort[0, 0]), 4)  # 2 kg · 9.81 m/s² · 0.5 m · sin(0.5)
    4.7032
    """

    def __init__(
        self,
        spec: Any,
        compiled: Any,
        coordinates: Coordinates,
        joints: Sequence[str],
        missing_files: Sequence[str] = (),
    ) -> None:
        self.spec, self.compiled = spec, compiled
        self.coordinates = coordinates
        self.joints = tuple(joints)
        self.missing_files = tuple(missing_files)
        self.data = import_mujoco().MjData(compiled)
        self.groups = rigid_groups(compiled, PAYLOAD)

    def _card(self) -> Card:
        facts = [("joints", ", ".join(self.joints)), ("bodies", ", ".join(self.bodies))]
        if self.followers:
            facts.append(("followers", ", ".join(self.followers)))
        return Card("trundle.mechanism.Mechanism", facts)

    @classmethod
    def load(
        cls,
        source: str | os.PathLike[str],
        joints: Sequence[str],
        *,
        payload: Payload | None = None,
        contacts: bool = True,
    ) -> Mechanism:
        """Load a model.

        Parameters
        ----------
        source : path or str
            An MJCF or URDF file, or its text. Meshes need not exist, unless the inertia of a moving body
            comes from them.
        joints : sequence of str
            The recorded joints.
        payload : Payload, optional
            A known mass on one of the moving bodies.
        contacts : bool
            Whether bodies can touch; see `touching_bodies`.

        Raises
        ------
        TrundleError
            If a joint is unknown; the model has free or ball joints, a closed loop or a tendon between
            recorded and other joints; an inertia depends on a missing mesh; or MuJoCo refuses the model.

        Examples
        --------
        >>> from trundle.mechanism import Mechanism
        >>> Mechanism.load("<mujoco/>", ["elbow"])
        Traceback (most recent call last):
        trundle.TrundleError: model text: unknown joint 'elbow'; the joints of the model are none
        """
        spec, compiled, coordinates, missing_files = load_model(source, joints, payload, contacts)
        return cls(spec, compiled, coordinates, joints, missing_files)

    @property
    def bodies(self) -> tuple[str, ...]:
        """The moving bodies, the first of each rigid group."""
        return tuple(group.name for group in self.groups)

    @property
    def followers(self) -> tuple[str, ...]:
        """The joints that follow recorded ones."""
        names = (self.compiled.joint(k).name for k in range(self.compiled.njnt))
        return tuple(name for name in names if name not in self.joints)

    @property
    def masses(self) -> dict[str, float]:
        """Mass of each moving body and those fixed to it, kg, without the payload."""
        return {group.name: group.mass for group in self.groups}

    @property
    def armature(self) -> Floats:
        """(n,) Armature of the joints, kg·m² or kg."""
        return self._at_joints(self.compiled.dof_armature)

    @property
    def damping(self) -> Floats:
        """(n,) Linear viscous damping of the joints, N·m·s/rad or N·s/m."""
        return self._at_joints(self.compiled.dof_damping)

    @property
    def frictionloss(self) -> Floats:
        """(n,) Dry friction of the joints, N·m or N."""
        return self._at_joints(self.compiled.dof_frictionloss)

    @property
    def stiffness(self) -> Floats:
        """(n,) Stiffness of the joints' springs, N·m/rad or N/m."""
        return self._at_joints(self.compiled.jnt_stiffness)

    @property
    def ranges(self) -> Floats:
        """(n, 2) Limits of the joints, rad or m; infinite without a limit."""
        limited = self.compiled.jnt_limited.astype(bool)[:, None]
        return self._at_joints(np.where(limited, self.compiled.jnt_range, [-np.inf, np.inf]))

    def rigid_group(self, body: str) -> str:
        """Return the moving body that a body of the model is fixed to.

        Raises
        ------
        TrundleError
            If the body is unknown or does not move.
        """
        return first_body(self.compiled, body)

    def adjusted(
        self,
        *,
        armature: Mapping[str, float] | None = None,
        damping: Mapping[str, float] | None = None,
        mass: Mapping[str, float] | None = None,
    ) -> Mechanism:
        """Return the mechanism with other values, by joint or body.

        Parameters
        ----------
        armature, damping : mapping of str to float, optional
            New values of recorded joints.
        mass : mapping of str to float, optional
            New masses, kg, of moving bodies with the bodies fixed to them. Inertias scale with the masses.

        Raises
        ------
        TrundleError
            If a joint or body is unknown.
        """
        model = copy.copy(self.compiled)
        for values, changes in ((model.dof_armature, armature), (model.dof_damping, damping)):
            for name, value in (changes or {}).items():
                values[self.coordinates.index[self.column(name)]] = value
        scale_masses(model, self.groups, mass or {})
        return Mechanism(self.spec, model, self.coordinates, self.joints, self.missing_files)

    def inverse_dynamics(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Floats:
        """Return the effort at the recorded joints that the model needs for a motion.

        Parameters
        ----------
        q, v, a : (T, n) array_like
            Positions, velocities and accelerations, rad or m.

        Returns
        -------
        (T, n) array
            In N·m or N. Gravity, inertia, armature, damping, springs, tendons, limits and contacts are
            MuJoCo's (`mj_inverse`). The model's dry friction is loss·sign(v), 0 at rest, instead of MuJoCo's
            soft constraint.

        Raises
        ------
        TrundleError
            If shapes differ or a value is not finite.
        """
        motion = check_motion(self.joints, q, v, a)
        _, velocity, _, slope = self.coordinates.expand(*motion)
        friction = self.compiled.dof_frictionloss * np.sign(velocity)
        return self.smooth_effort(*motion) + self.coordinates.project(friction, slope)

    def regressors(self, q: ArrayLike, v: ArrayLike, a: ArrayLike, *, derivatives: bool = True) -> Regressors:
        """Return the effort as `inverse_dynamics`, and its derivatives: see `Regressors`.

        Those by position and velocity take most of the time; `derivatives=False` leaves them out.
        """
        return evaluate_regressors(self, *check_motion(self.joints, q, v, a), derivatives=derivatives)

    def effort_with_offset(
        self, q: ArrayLike, v: ArrayLike, a: ArrayLike, joint: str, value: float
    ) -> Floats:
        """Return the effort for a motion in which the encoder of a joint reads true position + value."""
        true = np.array(q, dtype=float)
        true[:, self.column(joint)] -= value
        return self.inverse_dynamics(true, v, a)

    def smooth_effort(self, q: Floats, v: Floats, a: Floats) -> Floats:
        """Return the effort without the model's dry friction, for arrays that are valid."""
        *motion, slope = self.coordinates.expand(q, v, a)
        return self.coordinates.project(inverse_dynamics(self.compiled, self.data, *motion), slope)

    def column(self, joint: str) -> int:
        """Return the column of a recorded joint, or raise a TrundleError."""
        if joint not in self.joints:
            known = ", ".join(self.joints)
            raise TrundleError(f"joint {joint!r} is not recorded; the recorded joints are {known}")
        return self.joints.index(joint)

    def _at_joints(self, values: Any) -> Floats:
        """Return the rows of the recorded joints of an array of the compiled model."""
        return np.array(values[self.coordinates.index], dtype=float)
