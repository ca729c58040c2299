"""Families of hidden effects, scaled to an object of any size and mass."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from trundle.experiments.blind import families
from trundle.experiments.blind.families.out_of_catalogue import sticky_force
from trundle.experiments.blind.family import Context, Draw, Family, HiddenEffect, Values
from trundle.experiments.blind.outline import to_world
from trundle.experiments.blind.push import CONTACT_TIME_S
from trundle.experiments.blind.readings import Readings
from trundle.experiments.blind.scene import Scene, Wheel, draw_training_episode
from trundle.experiments.blind.wide.measurement import rotated
from trundle.experiments.blind.wide.scene import REFERENCE_WHEEL_MASS_KG
from trundle.experiments.sampling import Floats

__all__ = ["CATALOGUE", "FAMILIES", "OUT_OF_CATALOGUE", "is_allowed", "merge_wheels"]

REFERENCE_GYRATION_M = 0.45
"""Radius of gyration of furniture, from which effects are scaled."""
REFERENCE_MASS_KG = 22.0
"""Mass of furniture."""
LIMIT_NAMES = ("limit_x", "limit_y", "limit_torque")
"""Limits of a sensor: forces, N, and torque, N·m."""
CUT_SHARE_RANGE = (0.15, 0.45)
"""Share of the largest load that is cut. With larger cuts the true law leaves most of the misfit."""
MIN_LIMIT = 1e-3
"""Initial limit of a fit for an axis without load, such as the torque of a finger."""
STICKY_GROUND_MOST = 1000.0
"""Largest drag of the sticky ground, N·s/m."""
NEEDS_GRASP = frozenset({"floor_slope", "gripper_inertia", "magnet", "shaking", "gusts", "floor_waves"})
"""Effects that are hidden only in grasps: they would move a free object at rest, or need a gripper."""
UNKNOWN_NAMES = """
magnet warming_wheel shaking rattling_load hysteretic_spring sticky_ground lateral_lift gusts floor_waves
leaking_load
"""
"""Families outside the catalogue, in the order on which the drawn cases depend."""


def size(scene: Scene) -> float:
    """Return the radius of gyration about the centroid relative to furniture."""
    return float(math.sqrt(scene.shape.spin) / REFERENCE_GYRATION_M)


def load(scene: Scene) -> float:
    """Return the mass relative to furniture."""
    return scene.mass / REFERENCE_MASS_KG


SCALING: dict[str, list[tuple[Callable[[Scene], float], tuple[str, ...]]]] = {
    "com_offset": [(size, ("x", "y"))],
    "tracker_offset": [(size, ("offset_x", "offset_y"))],
    "second_wheel": [(lambda scene: math.sqrt(scene.mass / REFERENCE_WHEEL_MASS_KG), ("mu_x", "mu_y"))],
    "gripper_inertia": [(load, ("mass",))],
    "force_bias": [(size, ("torque_z",))],
    "tether": [(load, ("stiffness",))],
    "axis_friction": [(load, ("force_x", "force_y", "torque")), (size, ("torque",))],
    "thinning_drag": [(load, ("drag",)), (size, ("ring",))],
}
"""Values that are proportional to a factor of the scene, by effect."""


def scaled_draw(family: Family) -> Draw:
    """Return a function that draws values of a family for an object of any size and mass."""

    def draw(rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        values: Values = family.draw(rng, scene, paths)
        for factor, names in SCALING.get(family.name, ()):
            values |= {name: factor(scene) * values[name] for name in names}
        if "time" in values:
            values |= draw_event(rng, scene)
        if family.name == "tether" and scene.strokes:
            # The cable is slack at first, so that the object starts at rest.
            starts = np.array([push.start for push in scene.pushes])
            ways = to_world(np.array(values["point"]), starts) - values["anchor"]
            values["rest_length"] = max(values["rest_length"], 1.001 * float(np.hypot(*ways.T).max()))
        return values

    return draw


def draw_event(rng: np.random.Generator, scene: Scene) -> Values:
    """Return a time in a training episode, at least a fifth of the episode from its ends."""
    episode = draw_training_episode(rng, scene)
    span = scene.seconds[episode] - CONTACT_TIME_S
    return {"episode": episode, "time": CONTACT_TIME_S + float(rng.uniform(0.2, 0.8)) * span}


def add_inertia(seen: Readings, context: Context, values: Values) -> Readings:
    """Add mass times acceleration of the gripper's origin to the reading; the motion does not change."""
    step = float(seen.t[1] - seen.t[0])
    moving = seen.t >= CONTACT_TIME_S
    at, rate = seen.gripper[:, :2], np.zeros((len(seen.t), 2))
    rate[1:-1] = (at[2:] - 2 * at[1:-1] + at[:-2]) / step**2
    rate[~moving] = 0.0
    along = values["mass"] * np.column_stack(rotated(rate, -seen.gripper[:, 2]))
    return seen.changed(wrench=seen.wrench + np.column_stack([along, np.zeros(len(along))]))


def add_offset_from_contact(seen: Readings, context: Context, values: Values) -> Readings:
    """Add an offset that begins with the first force."""
    touches = np.flatnonzero(np.hypot(seen.wrench[:, 0], seen.wrench[:, 1]) > 1e-6)
    late = float(seen.t[touches[0]] if len(touches) else seen.t[-1]) - CONTACT_TIME_S
    bias = HiddenEffect(families.CATALOGUE["force_bias"], values)
    return bias.distort(seen.changed(t=seen.t - late), context).changed(t=seen.t)


def draw_limits(rng: np.random.Generator, scene: Scene, wrenches: Sequence[Floats]) -> Values:
    """Return a share of the median over episodes of the largest load on each axis."""
    largest = np.median([np.max(np.abs(wrench), axis=0) for wrench in wrenches], axis=0)
    cut = rng.uniform(*CUT_SHARE_RANGE)
    return dict(zip(LIMIT_NAMES, map(float, (1.0 - cut) * largest), strict=True))


def limit_axes(seen: Readings, context: Context, values: Values) -> Readings:
    """Limit the reading of each axis, in all episodes to the same range."""
    most = np.array([values[name] for name in LIMIT_NAMES])
    return seen.changed(wrench=np.clip(seen.wrench, -most, most))


def limit_laws(scene: Scene, values: Values) -> list[Values]:
    """Return the limits, and an approximate excess for a linear rise that is cut half-way."""
    limits = {name: max(values[name], MIN_LIMIT) for name in LIMIT_NAMES}
    return [{"kind": "saturation", **limits, "excess": 0.4}]


def merge_wheels(wheel: Wheel, other: Wheel) -> Wheel:
    """Return the one wheel that is equivalent to two, except for a rotational damping."""
    whole = wheel.damping() + other.damping()
    lever = np.linalg.solve(whole[:2, :2], whole[:2, 2])
    sizes, axes = np.linalg.eigh(whole[:2, :2])
    angle = float(np.arctan2(axes[1, 0], axes[0, 0]))
    return Wheel(float(lever[1]), float(-lever[0]), angle, float(sizes[0]), float(sizes[1]))


def varied(family: Family) -> Family:
    """Return a family of furniture adapted to any scene."""
    changes: dict[str, Family] = {
        "gripper_inertia": replace(family, build=None, distort=add_inertia),
        "force_bias": replace(family, distort=add_offset_from_contact),
        "second_wheel": replace(family, merge_wheel=lambda wheel, v: merge_wheels(wheel, Wheel(**v))),
        "saturation": Family("saturation", draw_limits, distort=limit_axes, laws=limit_laws, reads=True),
        "sticky_ground": replace(family, force=sticky_force(STICKY_GROUND_MOST)),
    }
    changed = changes.get(family.name, family)
    return replace(changed, draw=scaled_draw(changed))


CATALOGUE = {name: varied(family) for name, family in families.CATALOGUE.items()}
"""Effects of the catalogue by name."""
OUT_OF_CATALOGUE = {name: varied(families.UNKNOWN[name]) for name in UNKNOWN_NAMES.split()}
"""Families without a law in the catalogue, by name."""
FAMILIES = {**CATALOGUE, **OUT_OF_CATALOGUE}


def is_allowed(name: str, scene: Scene) -> bool:
    """Return whether a family can be hidden in a scene."""
    if scene.strokes and name in NEEDS_GRASP:
        return False
    if name == "gripper_inertia" and any(scene.compliance):
        return False
    return scene.engine in FAMILIES[name].engines
