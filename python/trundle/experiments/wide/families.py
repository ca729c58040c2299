"""Families of the wide benchmark: those of the first benchmark, adapted to any scene."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from trundle.experiments.blind.families import CATALOGUE as BASE
from trundle.experiments.blind.families.distortion import Saturation
from trundle.experiments.blind.families.inertia import ComOffset, MassChange
from trundle.experiments.blind.families.joints import AxisFriction, ThinningDrag
from trundle.experiments.blind.families.sensing import ForceBias, GripperInertia, TrackerOffset
from trundle.experiments.blind.families.surroundings import Tether
from trundle.experiments.blind.families.wheels import SecondWheel, WheelEvent
from trundle.experiments.blind.family import EpisodeContext, Family, HiddenEffect, Values
from trundle.experiments.blind.geometry import to_world
from trundle.experiments.blind.push import CONTACT_TIME_S
from trundle.experiments.blind.readings import Readings
from trundle.experiments.blind.score import INDISTINGUISHABLE_PAIR
from trundle.experiments.sampling import Floats
from trundle.experiments.wide.out_of_catalogue import MOVES_RESTING_OBJECT, OUT_OF_CATALOGUE
from trundle.experiments.wide.scene import WideScene
from trundle.experiments.wide.trajectory import first_contact_time

__all__ = [
    "CATALOGUE",
    "INDISTINGUISHABLE_PAIRS",
    "OUT_OF_CATALOGUE",
    "distort_from_contact",
    "draw_effects",
    "get_family",
    "is_allowed",
]


REFERENCE_GYRATION_M = 0.45
"""Radius of gyration of the first benchmark's furniture, from which effects are scaled."""
REFERENCE_MASS_KG = 22.0
"""Mass of the first benchmark's furniture."""
LIMIT_NAMES = ("limit_x", "limit_y", "limit_torque")
"""Limits of a sensor: forces, N, and torque, N·m."""
CUT_SHARE_RANGE = (0.15, 0.45)
"""Share of the largest load that is cut. With larger cuts the true law leaves most of the misfit."""
MIN_LIMIT = 1e-3
"""Initial limit of a fit for an axis without load, such as the torque of a finger."""
NEEDS_GRASP = frozenset({"floor_slope", "gripper_inertia"})
"""Effects that are hidden only in grasps: a free object would roll away."""
INDISTINGUISHABLE_PAIRS = (INDISTINGUISHABLE_PAIR, frozenset({"second_wheel", "wheel_event"}))
"""Pairs of effects that are never hidden together, as in the first benchmark."""


def scale_values(values: Values, names: Sequence[str], factor: float) -> Values:
    """Return values with some of them multiplied by a factor."""
    return {**values, **{name: factor * values[name] for name in names}}


def relative_size(scene: Any) -> float:
    """Return the object's radius of gyration about its centroid relative to the first benchmark's."""
    return float(math.sqrt(scene.shape.spin) / REFERENCE_GYRATION_M)


def draw_wide_event(rng: np.random.Generator, scene: WideScene) -> Values:
    """Return a time in a training episode, at least a fifth of the episode from its ends."""
    training = len(scene.pushes) - scene.held_out
    episode = int(rng.integers(min(1, training - 1), max(training - 1, min(1, training - 1) + 1)))
    span = scene.seconds[episode] - CONTACT_TIME_S
    return {"episode": episode, "time": CONTACT_TIME_S + float(rng.uniform(0.2, 0.8)) * span}


class WideMassChange(MassChange):
    """A change of mass in an episode of any length."""

    def draw(self, rng: np.random.Generator, scene: Any, paths: Sequence[Floats]) -> Values:
        """Return the mass as in the first benchmark, and a time."""
        return {**super().draw(rng, scene, paths), **draw_wide_event(rng, scene)}


class WideWheelEvent(WheelEvent):
    """A wheel event in an episode of any length."""

    def draw(self, rng: np.random.Generator, scene: Any, paths: Sequence[Floats]) -> Values:
        """Return the factors as in the first benchmark, and a time."""
        return {**super().draw(rng, scene, paths), **draw_wide_event(rng, scene)}


class WideComOffset(ComOffset):
    """An offset of the mass centre proportional to the object's size."""

    def draw(self, rng: np.random.Generator, scene: Any, paths: Sequence[Floats]) -> Values:
        """Return the offset."""
        size = relative_size(scene)
        return scale_values(super().draw(rng, scene, paths), ("x", "y"), size)


class WideTrackerOffset(TrackerOffset):
    """An offset of the tracker proportional to the object's size."""

    def draw(self, rng: np.random.Generator, scene: Any, paths: Sequence[Floats]) -> Values:
        """Return the offset."""
        size = relative_size(scene)
        return scale_values(super().draw(rng, scene, paths), ("offset_x", "offset_y"), size)


class WideSecondWheel(SecondWheel):
    """A second wheel with friction scaled by the mass, like the first one's."""

    def draw(self, rng: np.random.Generator, scene: Any, paths: Sequence[Floats]) -> Values:
        """Return the wheel."""
        factor = math.sqrt(scene.mass / 20.0)
        return scale_values(super().draw(rng, scene, paths), ("mu_x", "mu_y"), factor)


class WideGripperInertia(GripperInertia):
    """Inertia of the gripper, which adds to the reading only."""

    def draw(self, rng: np.random.Generator, scene: Any, paths: Sequence[Floats]) -> Values:
        """Return a mass proportional to the object's."""
        return scale_values(super().draw(rng, scene, paths), ("mass",), scene.mass / REFERENCE_MASS_KG)

    def add_to_world(self, context: EpisodeContext, values: Values) -> None:
        """Add nothing: the motion does not change."""

    def distort(self, seen: Readings, context: EpisodeContext, values: Values) -> Readings:
        """Add mass times acceleration of the gripper's origin, gripper axes."""
        step = float(seen.t[1] - seen.t[0])
        moving = seen.t >= CONTACT_TIME_S
        at, pose = seen.gripper[:, :2], np.zeros((len(seen.t), 2))
        pose[1:-1] = (at[2:] - 2 * at[1:-1] + at[:-2]) / step**2
        pose[~moving] = 0.0
        c, s = np.cos(seen.gripper[:, 2]), np.sin(seen.gripper[:, 2])
        force = values["mass"] * np.column_stack(
            [c * pose[:, 0] + s * pose[:, 1], c * pose[:, 1] - s * pose[:, 0]]
        )
        return seen.changed(wrench=seen.wrench + np.column_stack([force, np.zeros(len(force))]))


class WideForceBias(ForceBias):
    """An offset that begins with the first contact."""

    def draw(self, rng: np.random.Generator, scene: Any, paths: Sequence[Floats]) -> Values:
        """Return an offset with a torque proportional to the object's size."""
        size = relative_size(scene)
        return scale_values(super().draw(rng, scene, paths), ("torque_z",), size)

    def distort(self, seen: Readings, context: EpisodeContext, values: Values) -> Readings:
        """Add the offset to the reading."""
        return distort_from_contact(super().distort, seen, context, values)


class WideTether(Tether):
    """A cable. With free pushing it is slack at first, so that the object starts at rest."""

    def draw(self, rng: np.random.Generator, scene: Any, paths: Sequence[Floats]) -> Values:
        """Return the cable, with a stiffness proportional to the mass."""
        values = scale_values(super().draw(rng, scene, paths), ("stiffness",), scene.mass / REFERENCE_MASS_KG)
        starts = np.array([push.start for push in scene.pushes])
        ways = to_world(np.array(values["point"]), starts) - values["anchor"]
        if scene.strokes:
            longest = float(np.hypot(*ways.T).max())
            values["rest_length"] = max(values["rest_length"], 1.001 * longest)
        return values


class WideSaturation(Saturation):
    """A sensor with one range for all episodes."""

    reads = True

    def draw(self, rng: np.random.Generator, scene: Any, paths: Sequence[Floats]) -> Values:
        """Return the limits: a share of the median over episodes of the largest load on each axis."""
        largest = np.median([np.max(np.abs(wrench), axis=0) for wrench in paths], axis=0)
        cut = rng.uniform(*CUT_SHARE_RANGE)
        return dict(zip(LIMIT_NAMES, map(float, (1.0 - cut) * largest), strict=True))

    def distort(self, seen: Readings, context: EpisodeContext, values: Values) -> Readings:
        """Limit the reading of each axis."""
        most = np.array([values[name] for name in LIMIT_NAMES])
        return seen.changed(wrench=np.clip(seen.wrench, -most, most))

    def truth(self, scene: Any, values: Values) -> Values:
        """Return the limits."""
        return {"parameters": dict(values), "where": None}

    def laws(self, scene: Any, values: Values) -> list[Values]:
        """Return the limits, and an approximate excess for a linear rise that is cut half-way."""
        limits = {name: max(values[name], MIN_LIMIT) for name in LIMIT_NAMES}
        return [{"kind": self.name, **limits, "excess": 0.4}]


class WideAxisFriction(AxisFriction):
    """Friction of slides proportional to the object's mass; of the hinge also to its size."""

    def draw(self, rng: np.random.Generator, scene: Any, paths: Sequence[Floats]) -> Values:
        """Return the forces and the torque."""
        load, size = scene.mass / REFERENCE_MASS_KG, relative_size(scene)
        values = scale_values(super().draw(rng, scene, paths), self.scales, load)
        return scale_values(values, ("torque",), size)


class WideThinningDrag(ThinningDrag):
    """Drag proportional to the object's mass, on a ring proportional to its size."""

    def draw(self, rng: np.random.Generator, scene: Any, paths: Sequence[Floats]) -> Values:
        """Return the drag and its ring."""
        values = scale_values(super().draw(rng, scene, paths), ("drag",), scene.mass / REFERENCE_MASS_KG)
        return scale_values(values, ("ring",), relative_size(scene))


def distort_from_contact(distort: Any, seen: Readings, context: EpisodeContext, values: Values) -> Readings:
    """Distort readings with the clock shifted so that the first contact is at `CONTACT_TIME_S`."""
    late = first_contact_time(seen) - CONTACT_TIME_S
    found = distort(seen.changed(t=seen.t - late), context, values)
    return Readings(seen.t, found.pose, found.gripper, found.wrench)


WIDE_FAMILIES: dict[str, Family] = {
    family.name: family
    for family in (
        WideMassChange(),
        WideWheelEvent(),
        WideComOffset(),
        WideTrackerOffset(),
        WideSecondWheel(),
        WideGripperInertia(),
        WideForceBias(),
        WideTether(),
        WideSaturation(),
        WideAxisFriction(),
        WideThinningDrag(),
    )
}
CATALOGUE: dict[str, Family] = {name: WIDE_FAMILIES.get(name, family) for name, family in BASE.items()}
"""Effects of the catalogue by name."""


def get_family(name: str) -> Family:
    """Return a family."""
    return CATALOGUE[name] if name in CATALOGUE else OUT_OF_CATALOGUE[name]


def is_allowed(name: str, scene: WideScene) -> bool:
    """Return whether a family can be hidden in a scene."""
    if scene.strokes and name in NEEDS_GRASP | MOVES_RESTING_OBJECT:
        return False
    if name == "gripper_inertia" and any(scene.compliance):
        return False
    return scene.engine in getattr(get_family(name), "engines", (scene.engine,))


def draw_effects(
    names: Sequence[str], seed: int, attempt: int, scene: WideScene, bare: Sequence[Readings]
) -> list[HiddenEffect] | None:
    """Return families with their values; None if one does not fit this scene.

    Places are drawn from the motion without the effects: from the poses from contact on, and for a sensor's
    range from the readings.
    """
    if not all(is_allowed(name, scene) for name in names):
        return None
    paths, readings = [seen.pose[1000:] for seen in bare], [seen.wrench for seen in bare]
    hidden = []
    for k, name in enumerate(names):
        seen = readings if getattr(get_family(name), "reads", False) else paths
        values = get_family(name).draw(np.random.default_rng([seed, attempt, 13, k]), scene, seen)
        if not values:
            return None
        hidden.append(HiddenEffect(get_family(name), values))
    return hidden
