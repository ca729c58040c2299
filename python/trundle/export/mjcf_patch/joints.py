"""Effects at joints that MJCF expresses: friction, damping, springs, stops, play and compliance."""

from __future__ import annotations

from typing import Any

import numpy as np

from trundle._native import TrundleError
from trundle.export.mjcf_patch.actuators import find_drives
from trundle.export.mjcf_patch.specification import Patch
from trundle.mechanism import JointEffect
from trundle.mechanism.simulation import FRICTION_SOLIMP
from trundle.mechanism.source import import_mujoco
from trundle.mechanism.transmissions import PLAY_SOLIMP, couple_slides

__all__ = ["JOINT_EFFECTS", "finish_stops"]

STOP_IMPEDANCE = 1e-3
"""Constant impedance of stops, so small that the soft constraint adds no mass to the elastic contact."""
FAR = 1e6
"""Other end of the range of a one-sided stop, rad or m."""


def add_damping(patch: Patch, effect: JointEffect) -> None:
    """Add viscous friction."""
    patch.joint(effect).damping[0] += effect.parameters["damping"]


def add_drag(patch: Patch, effect: JointEffect) -> None:
    """Add a torque that is quadratic in velocity: the second coefficient of MuJoCo's damping."""
    patch.joint(effect).damping[1] += effect.parameters["coefficient"]


def add_armature(patch: Patch, effect: JointEffect) -> None:
    """Add armature."""
    patch.joint(effect).armature += effect.parameters["armature"]


def add_dry_friction(patch: Patch, effect: JointEffect) -> None:
    """Add dry friction; the callback computes the rise at low speed."""
    joint, effort = patch.joint(effect), effect.parameters["effort"]
    joint.frictionloss += effort
    harden(patch, joint)
    if effect.parameters.get("static_effort", effort) != effort:
        patch.compute(effect)


def add_load_friction(patch: Patch, effect: JointEffect) -> None:
    """Leave friction that depends on the load of the drive to the callback."""
    harden(patch, patch.joint(effect))
    find_drives(patch, patch.joint(effect).name)
    patch.compute(effect)


def harden(patch: Patch, joint: Any) -> None:
    """Make a joint stick: with MuJoCo's default impedance it creeps visibly under load."""
    joint.solimp_friction = list(FRICTION_SOLIMP)
    joint.solref_friction = [2 * patch.original.opt.timestep, 1.0]


def shift_encoder(patch: Patch, effect: JointEffect) -> None:
    """Shift the joint's reference, so that its position reads as the encoder does."""
    joint, offset = patch.joint(effect), effect.parameters["offset"]
    shift = offset * patch.angle(joint)
    joint.ref += shift
    joint.springref += shift
    joint.range = np.array(joint.range) + shift
    patch.offsets[joint.name] = offset
    patch.notes.append(
        f"The position of joint {joint.name!r} is what its encoder reads: true position + {offset:g}."
    )


def add_elasticity(patch: Patch, effect: JointEffect) -> None:
    """Add a joint for the compliance between drive and joint."""
    extra = insert_joint(patch, effect, "compliance")
    extra.stiffness[0] = effect.parameters["stiffness"]
    extra.damping[0] = effect.parameters.get("damping", 0.0)


def add_backlash(patch: Patch, effect: JointEffect) -> None:
    """Add a joint for the play between drive and joint, limited to its width."""
    mujoco = import_mujoco()
    extra = insert_joint(patch, effect, "play")
    half = effect.parameters["gap"] / 2 * patch.angle(extra)
    extra.range, extra.limited = [-half, half], mujoco.mjtLimited.mjLIMITED_TRUE
    extra.solref_limit = [2 * patch.original.opt.timestep, 1.0]
    extra.solimp_limit = list(PLAY_SOLIMP)


def insert_joint(patch: Patch, effect: JointEffect, suffix: str) -> Any:
    """Insert a joint on the same axis; drive, armature and friction remain at the existing one.

    Raises
    ------
    TrundleError
        If the drive has no inertia of its own.
    """
    joint = patch.joint(effect)
    if joint.armature <= 0:
        raise TrundleError(
            f"{effect.name}: joint {joint.name!r} has no armature, which is the inertia of the drive; "
            f'give "armature:{joint.name}" in [nominal]'
        )
    move_to_output(patch, joint)
    couple_slides(joint)
    extra = joint.parent.add_joint(name=f"{joint.name}_{suffix}", type=joint.type)
    extra.axis, extra.pos = joint.axis, joint.pos
    extra.stiffness, extra.damping = [0.0] * 3, [0.0] * 3
    extra.armature = extra.frictionloss = 0.0
    extra.limited = import_mujoco().mjtLimited.mjLIMITED_FALSE
    patch.chains[joint.name].append(extra.name)
    for tendon in patch.spec.tendons:
        if tendon.name in (f"{joint.name}_range", f"{joint.name}_spring"):
            tendon.wrap_joint(extra.name, 1.0)
    for key in list(patch.spec.keys):
        patch.spec.delete(key)
    patch.notes.append(
        f"Joint {joint.name!r} is the drive's side; the position of the body is the sum of "
        f"{' and '.join(patch.chains[joint.name])}. Keyframes are removed."
    )
    return extra


def move_to_output(patch: Patch, joint: Any) -> None:
    """Move limits and spring of a joint to tendons that act on the sum of drive and play."""
    compiled, dof = patch.original.joint(joint.name), patch.original.joint(joint.name).qposadr[0]
    if len(patch.chains[joint.name]) > 1:
        return
    shift = patch.offsets.get(joint.name, 0.0)
    if patch.original.jnt_limited[compiled.id]:
        limits = patch.original.jnt_range[compiled.id] + shift
        tendon = add_tendon(patch, f"{joint.name}_range", joint.name, limits)
        tendon.solref_limit, tendon.solimp_limit = joint.solref_limit, joint.solimp_limit
        tendon.margin = joint.margin
        joint.limited = import_mujoco().mjtLimited.mjLIMITED_FALSE
    if joint.stiffness[0]:
        rest = patch.original.qpos_spring[dof] + shift
        add_spring_tendon(patch, joint.name, joint.stiffness[0], rest)
        joint.stiffness[0] = 0.0


def add_spring(patch: Patch, effect: JointEffect) -> None:
    """Add a spring, combined with that of the joint."""
    joint = patch.joint(effect)
    stiffness = effect.parameters["stiffness"]
    rest = effect.parameters["rest"] + patch.offsets.get(joint.name, 0.0)
    if len(patch.chains[joint.name]) > 1:
        add_spring_tendon(patch, joint.name, stiffness, rest)
        return
    present, angle = joint.stiffness[0], patch.angle(joint)
    total = present + stiffness
    if total:
        joint.springref = (present * joint.springref + stiffness * rest * angle) / total
        joint.stiffness[0] = total


def add_stop(patch: Patch, effect: JointEffect) -> None:
    """Add an elastic stop: the limit of a tendon, so that the joint's own limits remain."""
    joint = patch.joint(effect)
    place = effect.parameters["position"] + patch.offsets.get(joint.name, 0.0)
    upper = effect.parameters["side"] > 0
    name = f"{joint.name}_stop_{len(patch.stiffness)}"
    add_tendon(patch, name, joint.name, [-FAR, place] if upper else [place, FAR])
    patch.stiffness[name] = effect.parameters["stiffness"]


def add_tendon(patch: Patch, name: str, joint: str, limits: Any) -> Any:
    """Add a limited tendon whose length is the position of a joint's output."""
    tendon = patch.spec.add_tendon(name=name)
    for each in patch.chains[joint]:
        tendon.wrap_joint(each, 1.0)
    tendon.range, tendon.limited = list(limits), import_mujoco().mjtLimited.mjLIMITED_TRUE
    return tendon


def add_spring_tendon(patch: Patch, joint: str, stiffness: float, rest: float) -> None:
    """Add a spring on the position of a joint's output."""
    count = sum(tendon.name.startswith(f"{joint}_spring") for tendon in patch.spec.tendons)
    tendon = patch.spec.add_tendon(name=f"{joint}_spring{count or ''}")
    for each in patch.chains[joint]:
        tendon.wrap_joint(each, 1.0)
    tendon.stiffness[0] = stiffness
    tendon.springlength = [rest, rest]


def finish_stops(patch: Patch, compiled: Any) -> None:
    """Give stops their stiffness, which depends on the inertia of the compiled model.

    With a constant impedance d and MuJoCo's negative `solref`, the effort per depth is -solref / ((1 - d)·w),
    where w is the tendon's inverse inertia.
    """
    for name, stiffness in patch.stiffness.items():
        weight = compiled.tendon_invweight0[compiled.tendon(name).id]
        tendon = patch.spec.tendon(name)
        tendon.solref_limit = [-stiffness * weight * (1 - STOP_IMPEDANCE), 0.0]
        tendon.solimp_limit = [STOP_IMPEDANCE, STOP_IMPEDANCE, 0.001, 0.5, 2.0]


JOINT_EFFECTS = {
    "encoder_offset": shift_encoder,
    "rotor_inertia": add_armature,
    "joint_elasticity": add_elasticity,
    "joint_backlash": add_backlash,
    "joint_viscous_friction": add_damping,
    "air_drag": add_drag,
    "joint_dry_friction": add_dry_friction,
    "joint_load_friction": add_load_friction,
    "joint_spring": add_spring,
    "joint_stop": add_stop,
}
"""Functions by the kind of the effect, in the order in which they are applied."""
