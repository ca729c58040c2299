"""What can be hidden in the wide benchmark: the old benchmark's families, adapted to any scene."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trundle.experiments.blind.families import CATALOGUE as BASE
from trundle.experiments.blind.families.distortion import Saturation
from trundle.experiments.blind.families.inertia import ComOffset, MassChange
from trundle.experiments.blind.families.joints import AxisFriction, ThinningDrag
from trundle.experiments.blind.families.sensing import ForceBias, GripperInertia, TrackerOffset
from trundle.experiments.blind.families.surroundings import Tether
from trundle.experiments.blind.families.wheels import SecondWheel, WheelEvent
from trundle.experiments.blind.family import Family, Hidden, Site, Values
from trundle.experiments.blind.places import in_room
from trundle.experiments.blind.push import CONTACT
from trundle.experiments.blind.score import TWINS
from trundle.experiments.blind.seen import Seen
from trundle.experiments.wide.motion import first_touch
from trundle.experiments.wide.outside import OUTSIDE, PUSHES_AT_REST
from trundle.experiments.wide.scene import WideScene

__all__ = ["CATALOGUE", "INSEPARABLE", "OUTSIDE", "allowed", "by_name", "clocked", "draw_hidden"]

Floats = NDArray[np.float64]

REFERENCE_GYRATION = 0.45
"""Radius of gyration of the old benchmark's furniture, m; its effects are scaled from it."""
REFERENCE_MASS = 22.0
"""Its mass, kg."""
LIMITS = ("limit_x", "limit_y", "limit_torque")
"""Of a sensor's range: forces, N, and torque, N·m."""
CUT = (0.15, 0.45)
"""Share of the largest load that is cut: of more than that the best law leaves most of the misfit."""
LEAST_LIMIT = 1e-3
"""Limit that a fit begins with where an axis reads nothing: a finger bears no torque."""
NEEDS_GRASP = frozenset({"floor_slope", "gripper_inertia"})
"""Effects that are not hidden under a free finger: the object rolls away, or the gripper moves alone."""
INSEPARABLE = (TWINS, frozenset({"second_wheel", "wheel_event"}))
"""Pairs that are not hidden together, as in the old benchmark."""


def scale(rng: np.random.Generator, values: Values, names: Sequence[str], factor: float) -> Values:
    """Return values some of which are multiplied."""
    return {**values, **{name: factor * values[name] for name in names}}


def wide_event(rng: np.random.Generator, scene: WideScene) -> Values:
    """Return a moment of a training episode, at least a fifth of the episode from its ends."""
    training = len(scene.pushes) - scene.held_out
    episode = int(rng.integers(min(1, training - 1), max(training - 1, min(1, training - 1) + 1)))
    span = scene.seconds[episode] - CONTACT
    return {"episode": episode, "time": CONTACT + float(rng.uniform(0.2, 0.8)) * span}


class WideMassChange(MassChange):
    """A change of mass in an episode of any length."""

    def draw(self, rng: np.random.Generator, scene: Any, paths: Sequence[Floats]) -> Values:
        """Return the mass as in the old benchmark, and a moment."""
        return {**super().draw(rng, scene, paths), **wide_event(rng, scene)}


class WideWheelEvent(WheelEvent):
    """A wheel event in an episode of any length."""

    def draw(self, rng: np.random.Generator, scene: Any, paths: Sequence[Floats]) -> Values:
        """Return the factors as in the old benchmark, and a moment."""
        return {**super().draw(rng, scene, paths), **wide_event(rng, scene)}


class WideComOffset(ComOffset):
    """An offset of the mass centre in proportion to the object's size."""

    def draw(self, rng: np.random.Generator, scene: Any, paths: Sequence[Floats]) -> Values:
        """Return the offset."""
        size = math.sqrt(scene.shape.spin) / REFERENCE_GYRATION
        return scale(rng, super().draw(rng, scene, paths), ("x", "y"), size)


class WideTrackerOffset(TrackerOffset):
    """An offset of the tracker in proportion to the object's size."""

    def draw(self, rng: np.random.Generator, scene: Any, paths: Sequence[Floats]) -> Values:
        """Return the offset."""
        size = math.sqrt(scene.shape.spin) / REFERENCE_GYRATION
        return scale(rng, super().draw(rng, scene, paths), ("offset_x", "offset_y"), size)


class WideSecondWheel(SecondWheel):
    """A second wheel whose friction goes with the mass, as the first one's does."""

    def draw(self, rng: np.random.Generator, scene: Any, paths: Sequence[Floats]) -> Values:
        """Return the wheel."""
        factor = math.sqrt(scene.mass / 20.0)
        return scale(rng, super().draw(rng, scene, paths), ("mu_x", "mu_y"), factor)


class WideGripperInertia(GripperInertia):
    """The gripper's mass, in the reading in proportion to the gripper's own acceleration."""

    def draw(self, rng: np.random.Generator, scene: Any, paths: Sequence[Floats]) -> Values:
        """Return a mass in proportion to the object's."""
        return scale(rng, super().draw(rng, scene, paths), ("mass",), scene.mass / REFERENCE_MASS)

    def furnish(self, site: Site, values: Values) -> None:
        """Add nothing to the motion."""

    def distort(self, seen: Seen, site: Site, values: Values) -> Seen:
        """Add mass times acceleration of the gripper's origin, gripper axes."""
        step = float(seen.t[1] - seen.t[0])
        moving = seen.t >= CONTACT
        at, pose = seen.gripper[:, :2], np.zeros((len(seen.t), 2))
        pose[1:-1] = (at[2:] - 2 * at[1:-1] + at[:-2]) / step**2
        pose[~moving] = 0.0
        c, s = np.cos(seen.gripper[:, 2]), np.sin(seen.gripper[:, 2])
        force = values["mass"] * np.column_stack(
            [c * pose[:, 0] + s * pose[:, 1], c * pose[:, 1] - s * pose[:, 0]]
        )
        return seen.changed(wrench=seen.wrench + np.column_stack([force, np.zeros(len(force))]))


class WideForceBias(ForceBias):
    """An offset that begins with the first touch."""

    def draw(self, rng: np.random.Generator, scene: Any, paths: Sequence[Floats]) -> Values:
        """Return an offset whose torque goes with the object's size."""
        size = math.sqrt(scene.shape.spin) / REFERENCE_GYRATION
        return scale(rng, super().draw(rng, scene, paths), ("torque_z",), size)

    def distort(self, seen: Seen, site: Site, values: Values) -> Seen:
        """Add it to the reading."""
        return clocked(super().distort, seen, site, values)


class WideTether(Tether):
    """A cable; where a free finger pushes it is slack at first, else the object would not be at rest."""

    def draw(self, rng: np.random.Generator, scene: Any, paths: Sequence[Floats]) -> Values:
        """Return the cable, with a stiffness that goes with the mass."""
        values = scale(rng, super().draw(rng, scene, paths), ("stiffness",), scene.mass / REFERENCE_MASS)
        starts = np.array([push.start for push in scene.pushes])
        ways = in_room(np.array(values["point"]), starts) - values["anchor"]
        if scene.strokes:
            longest = float(np.hypot(*ways.T).max())
            values["rest_length"] = max(values["rest_length"], 1.001 * longest)
        return values


class WideSaturation(Saturation):
    """A sensor with one range for all episodes; its reading is cut there."""

    reads = True

    def draw(self, rng: np.random.Generator, scene: Any, paths: Sequence[Floats]) -> Values:
        """Return the limits: a share of the largest load of each axis, in most episodes."""
        largest = np.median([np.max(np.abs(wrench), axis=0) for wrench in paths], axis=0)
        cut = rng.uniform(*CUT)
        return dict(zip(LIMITS, map(float, (1.0 - cut) * largest), strict=True))

    def distort(self, seen: Seen, site: Site, values: Values) -> Seen:
        """Cut the reading of each axis."""
        most = np.array([values[name] for name in LIMITS])
        return seen.changed(wrench=np.clip(seen.wrench, -most, most))

    def truth(self, scene: Any, values: Values) -> Values:
        """Return the limits."""
        return {"parameters": dict(values), "where": None}

    def laws(self, scene: Any, values: Values) -> list[Values]:
        """Return the limits, and about the excess of a ramp that is cut half-way."""
        limits = {name: max(values[name], LEAST_LIMIT) for name in LIMITS}
        return [{"kind": self.name, **limits, "excess": 0.4}]


class WideAxisFriction(AxisFriction):
    """Dry friction of slides in proportion to the object's mass, of their hinge to its size as well."""

    def draw(self, rng: np.random.Generator, scene: Any, paths: Sequence[Floats]) -> Values:
        """Return the forces and the torque."""
        load, size = scene.mass / REFERENCE_MASS, math.sqrt(scene.shape.spin) / REFERENCE_GYRATION
        values = scale(rng, super().draw(rng, scene, paths), self.scales, load)
        return scale(rng, values, ("torque",), size)


class WideThinningDrag(ThinningDrag):
    """Drag in proportion to the object's mass, on a ring in proportion to its size."""

    def draw(self, rng: np.random.Generator, scene: Any, paths: Sequence[Floats]) -> Values:
        """Return the drag and its ring."""
        values = scale(rng, super().draw(rng, scene, paths), ("drag",), scene.mass / REFERENCE_MASS)
        return scale(rng, values, ("ring",), math.sqrt(scene.shape.spin) / REFERENCE_GYRATION)


def clocked(distort: Any, seen: Seen, site: Site, values: Values) -> Seen:
    """Distort with the clock set so that the first touch is at `CONTACT`."""
    late = first_touch(seen) - CONTACT
    found = distort(seen.changed(t=seen.t - late), site, values)
    return Seen(seen.t, found.pose, found.gripper, found.wrench)


REPLACED: dict[str, Family] = {
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
CATALOGUE: dict[str, Family] = {name: REPLACED.get(name, family) for name, family in BASE.items()}
"""Effects of the catalogue by name."""


def by_name(name: str) -> Family:
    """Return a family."""
    return CATALOGUE[name] if name in CATALOGUE else OUTSIDE[name]


def allowed(name: str, scene: WideScene) -> bool:
    """Tell whether a family can be hidden in a scene."""
    if scene.strokes and name in NEEDS_GRASP | PUSHES_AT_REST:
        return False
    if name == "gripper_inertia" and any(scene.compliance):
        return False
    return scene.engine in getattr(by_name(name), "engines", (scene.engine,))


def draw_hidden(
    names: Sequence[str], seed: int, attempt: int, scene: WideScene, bare: Sequence[Seen]
) -> list[Hidden] | None:
    """Return families with their values; None where this scene has no place for them.

    They are placed on what is seen without them: most on the poses from contact on, a sensor's range on the
    readings.
    """
    if not all(allowed(name, scene) for name in names):
        return None
    paths, readings = [seen.pose[1000:] for seen in bare], [seen.wrench for seen in bare]
    hidden = []
    for k, name in enumerate(names):
        seen = readings if getattr(by_name(name), "reads", False) else paths
        values = by_name(name).draw(np.random.default_rng([seed, attempt, 13, k]), scene, seen)
        if not values:
            return None
        hidden.append(Hidden(by_name(name), values))
    return hidden
