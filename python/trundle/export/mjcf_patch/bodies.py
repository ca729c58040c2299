"""Effects at bodies: masses, payloads and the direction of gravity."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from trundle._native import TrundleError
from trundle.export.mjcf_patch.specification import Patch
from trundle.mechanism import JointEffect
from trundle.mechanism.source import import_mujoco

__all__ = ["BODY_EFFECTS", "scale_mass"]


def scale_mass(patch: Patch, body: str, mass: float) -> None:
    """Give a body, with those that are fixed to it, another mass; inertias scale with it."""
    mechanism = patch.mechanism
    group = mechanism.groups[mechanism.bodies.index(mechanism.rigid_group(body))]
    make_inertias_explicit(patch)
    for member in group.members:
        element = patch.spec.body(mechanism.compiled.body(member).name)
        set_inertia(patch, element, mass / group.mass)


def make_inertias_explicit(patch: Patch) -> None:
    """If the model takes all inertias from geoms, write them into the bodies instead."""
    rule = import_mujoco().mjtInertiaFromGeom
    if patch.spec.compiler.inertiafromgeom == rule.mjINERTIAFROMGEOM_TRUE:
        for body in patch.spec.bodies:
            if patch.original.body(body.name).mass[0] > 0:
                set_inertia(patch, body, 1.0)
        patch.spec.compiler.inertiafromgeom = rule.mjINERTIAFROMGEOM_AUTO


def set_inertia(patch: Patch, body: Any, factor: float) -> None:
    """Write the compiled inertia of a body, times a factor, as an explicit one."""
    compiled = patch.original.body(body.name)
    body.explicitinertial = True
    body.mass = float(compiled.mass[0] * factor)
    body.ipos, body.iquat = compiled.ipos, compiled.iquat
    body.fullinertia = np.full(6, np.nan)
    body.inertia = compiled.inertia * factor


def add_payload(patch: Patch, effect: JointEffect) -> None:
    """Add a point mass as a body without a joint and without geoms."""
    values = effect.parameters
    carrier = patch.spec.body(effect.body or "")
    if carrier is None:
        known = ", ".join(patch.mechanism.bodies)
        raise TrundleError(f"{effect.name}: the model has no such body; the moving bodies are {known}")
    taken = sum(body.name.startswith("payload_") for body in patch.spec.bodies)
    body = carrier.add_body(name=f"payload_{taken + 1}")
    body.explicitinertial, body.mass = True, values["mass"]
    body.ipos = [values.get(f"com_{axis}", 0.0) for axis in "xyz"]
    body.inertia = [0.0, 0.0, 0.0]


def tilt_base(patch: Patch, effect: JointEffect) -> None:
    """Turn gravity about the world's x axis, then about its y axis."""
    x, y = effect.parameters.get("angle_x", 0.0), effect.parameters.get("angle_y", 0.0)
    about_x = [[1, 0, 0], [0, math.cos(x), -math.sin(x)], [0, math.sin(x), math.cos(x)]]
    about_y = [[math.cos(y), 0, math.sin(y)], [0, 1, 0], [-math.sin(y), 0, math.cos(y)]]
    patch.spec.option.gravity = np.array(about_y) @ np.array(about_x) @ np.array(patch.spec.option.gravity)


BODY_EFFECTS = {"payload": add_payload, "base_tilt": tilt_base}
"""Functions by the kind of the effect."""
