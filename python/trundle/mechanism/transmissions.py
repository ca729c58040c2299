"""Plays and elastic transmissions between drives and joints, as further joints of a MuJoCo model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from trundle.display.fields import DisplayedFields
from trundle.mechanism.source import compile_model, import_mujoco

if TYPE_CHECKING:
    from trundle.mechanism.model import Mechanism

__all__ = ["PLAY_SOLIMP", "SplitModel", "Transmission", "can_be_split", "couple_slides", "split_model"]

Floats = NDArray[np.float64]

PLAY_SOLIMP = (0.99, 0.999, 0.001, 0.5, 2.0)
"""Impedance of the faces of a play."""


@dataclass(frozen=True)
class Transmission:
    """A play or a spring between the drive and the link of a joint.

    Attributes
    ----------
    joint : str
    on_drive : bool
        Whether the encoder is at the drive.
    gap : float
        Width of the play in all, rad or m; 0 for a spring.
    stiffness, damping : float
        Of the spring, N·m/rad and N·m·s/rad, or N/m and N·s/m.

    Examples
    --------
    >>> from trundle.mechanism import Transmission
    >>> spring = Transmission("elbow", on_drive=True, stiffness=200.0)
    >>> spring.deflection(5.0)
    -0.025
    """

    joint: str
    on_drive: bool
    gap: float = 0.0
    stiffness: float = 0.0
    damping: float = 0.0

    def deflection(self, load: float) -> float:
        """Return the link's position less the drive's, at rest, for the effort that the link needs."""
        return -0.5 * self.gap * float(np.sign(load)) if self.gap > 0 else -load / self.stiffness


@dataclass(frozen=True, repr=False)
class SplitModel(DisplayedFields):
    """A model with a further joint for each transmission.

    Attributes
    ----------
    compiled : mujoco.MjModel
    transmissions : tuple of Transmission
    index : (N,) array
        Where each joint of the mechanism's model is; those with a transmission are the drives.
    links : (m,) array
        Where the joints of the transmissions are.
    columns : (m,) array
        Their columns among the recorded joints.

    Examples
    --------
    See `split_model`.

    >>> from trundle.mechanism import SplitModel
    """

    compiled: Any = field(repr=False)
    transmissions: tuple[Transmission, ...]
    index: NDArray[np.intp]
    links: NDArray[np.intp]
    columns: NDArray[np.intp]


def can_be_split(mechanism: Mechanism, transmissions: Sequence[Transmission]) -> bool:
    """Return whether every drive has inertia, and no spring, other joint or follower acts at its joint."""
    model, source = mechanism.compiled, mechanism.coordinates.source
    for one in transmissions:
        k = model.joint(one.joint).id
        has_follower = np.count_nonzero(source == mechanism.column(one.joint)) > 1
        alone = model.body_jntnum[model.jnt_bodyid[k]] == 1 and not has_follower
        if not (alone and model.dof_armature[k] > 0 and not np.any(model.jnt_stiffness[k])):
            return False
    return True


def split_model(mechanism: Mechanism, transmissions: Sequence[Transmission]) -> SplitModel:
    """Return the model with a joint for each transmission. The existing ones become the drives.

    Parameters
    ----------
    mechanism : Mechanism
    transmissions : sequence of Transmission
        At joints whose drives have inertia (an armature) and that no spring or other joint acts on.

    Returns
    -------
    SplitModel
        To be given to `simulate`.

    Examples
    --------
    A slide of 2 kg, of which 1 kg is the drive's. After a push of 0.1 s the effort is reversed; with a play
    of 20 mm the drive then moves without its load.

    >>> import numpy as np
    >>> from trundle.mechanism import EffortDrive, Mechanism, Transmission, simulate, split_model
    >>> cart = Mechanism.load(
    ...     '<mujoco><worldbody><body><joint name="rail" type="slide" axis="1 0 0" armature="1"/>'
    ...     '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></worldbody></mujoco>',
    ...     ["rail"],
    ... )
    >>> play = split_model(cart, [Transmission("rail", on_drive=True, gap=0.02)])
    >>> for split in (None, play):
    ...     push = EffortDrive([0.0, 0.1], [[1.0], [-1.0]], hold=True)
    ...     q, v = simulate(cart, [0.0, 0.1, 0.2], [0.0], [0.0], push, split=split)
    ...     print(f"{1e3 * q[-1, 0]:.1f} mm")
    5.0 mm
    2.5 mm
    """
    if not transmissions:
        every = np.arange(mechanism.compiled.njnt, dtype=np.intp)
        return SplitModel(mechanism.compiled, (), every, every[:0], every[:0])
    mujoco = import_mujoco()
    spec, own = mechanism.spec.copy(), mechanism.compiled
    names = [own.joint(k).name for k in range(own.njnt)]
    for one in transmissions:
        joint = spec.joint(one.joint)
        couple_slides(joint)
        # Without the drive's inertia, which a fit may have added, the inertia of both joints is singular.
        joint.armature = own.joint(one.joint).armature[0]
        link = joint.parent.add_joint(name=link_name(one.joint, names), type=joint.type)
        link.axis, link.pos = joint.axis, joint.pos
        link.stiffness[0], link.damping[0] = one.stiffness, one.damping
        link.armature = link.frictionloss = 0.0
        if one.gap > 0:
            half = 0.5 * one.gap * (1.0 if not spec.compiler.degree or is_slide(joint) else 180.0 / np.pi)
            link.range, link.limited = [-half, half], mujoco.mjtLimited.mjLIMITED_TRUE
            link.solimp_limit = list(PLAY_SOLIMP)
    compiled = compile_model(spec, "mechanism with transmissions")
    bodies = [compiled.body(own.body(k).name).id for k in range(1, own.nbody)]
    for name in ("body_mass", "body_inertia", "body_ipos", "body_iquat"):
        getattr(compiled, name)[bodies] = getattr(own, name)[1:]
    compiled.opt.gravity[:], compiled.opt.disableflags = own.opt.gravity, own.opt.disableflags
    compiled.opt.enableflags, compiled.opt.timestep = own.opt.enableflags, own.opt.timestep
    index = np.array([compiled.joint(name).id for name in names], dtype=np.intp)
    for name in ("dof_armature", "dof_damping", "dof_frictionloss"):
        getattr(compiled, name)[index] = getattr(own, name)
    links = np.array([compiled.joint(link_name(one.joint, names)).id for one in transmissions], dtype=np.intp)
    columns = np.array([mechanism.column(one.joint) for one in transmissions], dtype=np.intp)
    mujoco.mj_setConst(compiled, mujoco.MjData(compiled))
    return SplitModel(compiled, tuple(transmissions), index, links, columns)


def couple_slides(joint: Any) -> None:
    """Add a body without mass to the body of a slide in a specification.

    MuJoCo treats all slides of a body as independent, also parallel ones, if the body only slides and has no
    child and no offset of its centre.
    """
    if is_slide(joint):
        joint.parent.add_body()


def link_name(joint: str, names: Sequence[str]) -> str:
    """Return a name for the joint of a transmission that no other joint has."""
    found = f"{joint}_link"
    while found in names:
        found += "_"
    return found


def is_slide(joint: Any) -> bool:
    """Return whether a joint of a specification is a slide."""
    return bool(joint.type == import_mujoco().mjtJoint.mjJNT_SLIDE)
