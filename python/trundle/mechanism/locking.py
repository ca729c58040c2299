"""Reduction of a model to its recorded joints and those that follow them."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial

from trundle._native import TrundleError
from trundle.mechanism.coupling import Coupling
from trundle.mechanism.source import import_mujoco

__all__ = ["check_joints", "find_couplings", "lock_joints", "moving_bodies", "name_bodies", "remove_drives"]


def check_joints(spec: Any, name: str, joints: Sequence[str]) -> None:
    """Check that recorded joints exist, and that every joint of the model is a hinge or a slide.

    Raises
    ------
    TrundleError
        If a joint is unknown or named twice, or the model has a free or ball joint.
    """
    mujoco = import_mujoco()
    known = [joint.name for joint in spec.joints if joint.name]
    if not joints:
        raise TrundleError(f"{name}: joints = []: name at least one of {_listed(known)}")
    unknown = [joint for joint in joints if joint not in known]
    if unknown:
        near = difflib.get_close_matches(unknown[0], known, n=1)
        hint = f"did you mean {near[0]!r}? " if near else ""
        raise TrundleError(
            f"{name}: unknown joint {_listed(unknown)}; {hint}the joints of the model are {_listed(known)}"
        )
    twice = sorted({joint for joint in joints if joints.count(joint) > 1})
    if twice:
        raise TrundleError(f"{name}: joint {_listed(twice)} is named twice")
    reasons = {
        mujoco.mjtJoint.mjJNT_FREE: "a free joint: a body that is not attached to the world cannot be locked "
        "or recorded; attach the base to the world, and remove loose objects",
        mujoco.mjtJoint.mjJNT_BALL: "a ball joint: recordings hold hinge and slide joints only; "
        "replace it by three hinges or fix it",
    }
    for joint in spec.joints:
        if joint.type in reasons:
            named = f"joint {joint.name!r}" if joint.name else "its joint without a name"
            raise TrundleError(f"{name}: body {joint.parent.name!r}: {named} is {reasons[joint.type]}")


def name_bodies(spec: Any) -> None:
    """Give unnamed bodies a name, so that masses and payloads can refer to them."""
    taken = {body.name for body in spec.bodies}
    for number, body in enumerate(spec.bodies):
        if not body.name:
            name = f"body_{number}"
            body.name = name if name not in taken else f"unnamed_{name}"


def find_couplings(spec: Any, name: str, joints: Sequence[str]) -> dict[str, Coupling]:
    """Return the joints that follow recorded joints, directly or through others, by equality constraints.

    Raises
    ------
    TrundleError
        If two recorded joints are coupled, or one is held by a constraint.
    """
    mujoco = import_mujoco()
    open_ties = [
        tie for tie in spec.equalities if tie.active and tie.type == mujoco.mjtEq.mjEQ_JOINT and tie.name2
    ]
    couplings: dict[str, Coupling] = {}
    found = True
    while found:
        found = False
        for tie in list(open_ties):
            known = [one in joints or one in couplings for one in (tie.name1, tie.name2)]
            if all(known):
                raise TrundleError(
                    f"{name}: joints {tie.name1!r} and {tie.name2!r} are coupled by an equality constraint; "
                    "record only one of them: the other follows it"
                )
            if any(known):
                follower, coupling = _follow(tie, name, driver_known=known[1])
                couplings[follower] = coupling
                open_ties.remove(tie)
                found = True
    return couplings


def _follow(tie: Any, name: str, *, driver_known: bool) -> tuple[str, Coupling]:
    polynomial = np.array(tie.data[:5])
    if driver_known:
        return tie.name1, Coupling(tie.name2, Polynomial(polynomial))
    if np.any(polynomial[2:]) or polynomial[1] == 0:
        raise TrundleError(
            f"{name}: joint {tie.name1!r} follows {tie.name2!r} by a polynomial without a unique inverse; "
            f"record {tie.name2!r} instead"
        )
    inverse = Polynomial([-polynomial[0] / polynomial[1], 1 / polynomial[1]])
    return tie.name2, Coupling(tie.name1, inverse)


def moving_bodies(spec: Any, kept: Collection[str] | None = None) -> dict[str, str]:
    """Return the bodies below a kept joint, or any joint, each with the first body of its rigid group."""
    first: dict[str, str] = {}
    open_bodies = [(body, "") for body in spec.worldbody.bodies]
    while open_bodies:
        body, group = open_bodies.pop()
        if any(kept is None or joint.name in kept for joint in body.joints):
            group = body.name
        if group:
            first[body.name] = group
        open_bodies += [(child, group) for child in body.bodies]
    return first


def remove_drives(spec: Any) -> None:
    """Remove actuators, and sensors and keyframes, which refer to elements that may be removed."""
    for element in (*spec.actuators, *spec.sensors, *spec.keys):
        spec.delete(element)


def lock_joints(spec: Any, name: str, kept: Collection[str]) -> None:
    """Remove all joints but those in `kept`, and what refers to the removed ones.

    A body without its joint stays in its pose at the model's reference `qpos0`.

    Raises
    ------
    TrundleError
        If a tendon or a constraint couples kept joints with others, or closes a loop of moving bodies.
    """
    groups = moving_bodies(spec, kept)
    removed = _lock_tendons(spec, name, kept)
    _lock_equalities(spec, name, kept, groups, removed)
    for tendon in list(spec.tendons):
        if tendon.name in removed:
            spec.delete(tendon)
    _exclude_new_contacts(spec, groups)
    for joint in list(spec.joints):
        if joint.name not in kept:
            spec.delete(joint)


def _exclude_new_contacts(spec: Any, groups: Mapping[str, str]) -> None:
    """Exclude contacts that appear because a parent becomes static.

    MuJoCo ignores contacts of a body with its parent, unless the parent is fixed to the world.
    """
    before = moving_bodies(spec)
    for first in set(groups.values()):
        parent = spec.body(first).parent.name
        if parent not in before or parent in groups:
            continue
        fixed = [body for body, group in before.items() if group == before[parent] and body not in groups]
        for body in (body for body, group in groups.items() if group == first):
            for other in fixed:
                spec.add_exclude(bodyname1=body, bodyname2=other)


def _lock_tendons(spec: Any, name: str, kept: Collection[str]) -> set[str]:
    """Return the names of the tendons to remove: those of locked joints."""
    removed = set()
    for number, tendon in enumerate(spec.tendons):
        tendon.name = tendon.name or f"tendon_{number}"
        joints = list(_joints_of(tendon))
        locked = [joint for joint in joints if joint not in kept]
        if len(locked) < len(joints) and locked and _exerts_force(tendon):
            raise TrundleError(
                f"{name}: tendon {tendon.name!r} couples recorded joints with {_listed(locked)}, which are "
                "not recorded; record them too, or remove the tendon from the model"
            )
        if locked:
            removed.add(tendon.name)
    return removed


def _joints_of(tendon: Any) -> Iterator[str]:
    """Yield the names of the joints of a fixed tendon."""
    joint_wrap = import_mujoco().mjtWrap.mjWRAP_JOINT
    for k in range(len(tendon.path)):
        if tendon.path[k].type == joint_wrap:
            yield tendon.path[k].target.name


def _exerts_force(tendon: Any) -> bool:
    values = (tendon.stiffness, tendon.damping, tendon.frictionloss, tendon.range)
    return any(bool(np.any(np.asarray(value))) for value in values)


def _lock_equalities(
    spec: Any, name: str, kept: Collection[str], groups: Mapping[str, str], removed: Collection[str]
) -> None:
    """Remove constraints without effect on kept joints; refuse those outside the inverse dynamics."""
    mujoco = import_mujoco()
    kinds = mujoco.mjtEq
    for tie in list(spec.equalities):
        if tie.active and tie.type == kinds.mjEQ_JOINT:
            if tie.name1 in kept and tie.name2 in kept:
                continue
            if tie.name1 in kept:
                raise TrundleError(
                    f"{name}: joint {tie.name1!r} is recorded, but an equality constraint holds it in place"
                )
        if tie.active and tie.type == kinds.mjEQ_TENDON and not {tie.name1, tie.name2} & set(removed):
            raise TrundleError(
                f"{name}: an equality constraint on tendon {tie.name1!r} couples recorded joints; "
                "replace it by an equality of joints, and record one of them"
            )
        if tie.active and tie.type in (kinds.mjEQ_CONNECT, kinds.mjEQ_WELD):
            _check_loop(spec, name, tie, groups)
        spec.delete(tie)


def _check_loop(spec: Any, name: str, tie: Any, groups: Mapping[str, str]) -> None:
    """Refuse a constraint between bodies that move relative to each other; mocap bodies are drives."""
    mujoco = import_mujoco()
    bodies = [tie.name1, tie.name2 or "world"]
    if tie.objtype == mujoco.mjtObj.mjOBJ_SITE:
        bodies = [spec.site(site).parent.name for site in bodies]
    if any(spec.body(body) is not None and spec.body(body).mocap for body in bodies):
        return
    if groups.get(bodies[0]) != groups.get(bodies[1]):
        raise TrundleError(
            f"{name}: a constraint between bodies {bodies[0]!r} and {bodies[1]!r} closes a loop; its forces "
            "cannot be computed from the recorded joints; remove it, or model the loop by coupled joints"
        )


def _listed(names: Sequence[str]) -> str:
    return ", ".join(map(repr, names)) or "none"
