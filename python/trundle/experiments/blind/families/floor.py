"""Floors: a slope, a patch of drag, and anisotropic drag."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from trundle.experiments.blind.family import EpisodeContext, Family, Hook, Values
from trundle.experiments.blind.geometry import world_friction_points
from trundle.experiments.blind.scene import Scene, Wheel
from trundle.experiments.blind.shapes import inside
from trundle.experiments.blind.world import add_wheel, set_wheel
from trundle.experiments.sampling import Floats, log_uniform


class FloorSlope(Family):
    """A sloping floor: gravity has a component along the floor from contact on."""

    name = "floor_slope"
    scales = ("accel_x", "accel_y")

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return a slope of 0.3° to 3° in a random direction."""
        size = 9.81 * np.radians(np.exp(rng.uniform(np.log(0.3), np.log(3.0))))
        turn = rng.uniform(-np.pi, np.pi)
        return {"accel_x": float(size * np.cos(turn)), "accel_y": float(size * np.sin(turn))}

    def add_to_world(self, context: EpisodeContext, values: Values) -> None:
        """Tilt gravity."""
        context.spec.option.gravity = [values["accel_x"], values["accel_y"], 0.0]


class FloorGrain(Family):
    """A floor that resists along one direction: a damper between the two slide joints."""

    name = "floor_grain"
    scales = ("mu",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return friction and direction."""
        mu = log_uniform(rng, 10.0, 150.0)
        return {"mu": mu, "angle": float(rng.uniform(0.0, np.pi))}

    def add_to_world(self, context: EpisodeContext, values: Values) -> None:
        """Couple the joints by a fixed tendon with damping."""
        grain = context.spec.add_tendon(name="grain", damping=[values["mu"], 0.0, 0.0])
        grain.wrap_joint("x", float(np.cos(values["angle"])))
        grain.wrap_joint("y", float(np.sin(values["angle"])))


class FloorPatch(Family):
    """A carpet: dampers under all feet, or corners, that act while they are on it."""

    name = "floor_patch"
    scales = ("mu",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return a rectangle that contains the points for 10 % to 60 % of the time."""
        points = np.concatenate([world_friction_points(scene, path[::100]).reshape(-1, 2) for path in paths])
        half = rng.uniform(0.25, 0.6, 2)
        for _ in range(20):
            values = {
                "x": float(rng.choice(points[:, 0])),
                "y": float(rng.choice(points[:, 1])),
                "half_length": float(half.max()),
                "half_width": float(half.min()),
                "angle": float(rng.uniform(0.0, np.pi)),
                "mu": log_uniform(rng, 10.0, 120.0),
            }
            if 0.1 < np.mean(inside(points, patch_corners(values))) < 0.6:
                return values
        return {}

    def add_to_world(self, context: EpisodeContext, values: Values) -> None:
        """Add a damper at each point, off at first."""
        for k, (x, y) in enumerate(context.scene.friction_points):
            add_wheel(context.spec, context.table, f"patch {k}", Wheel(float(x), float(y), 0.0, 0.0, 0.0))

    def hook(self, model: Any, context: EpisodeContext, values: Values) -> Hook | None:
        """Switch the dampers by the positions of the points."""
        points = context.scene.friction_points.tolist()
        was: dict[int, bool] = {}
        turn, across = (math.cos(values["angle"]), math.sin(values["angle"])), values["half_width"]

        def switch(data: mujoco.MjData) -> None:
            x, y, heading = data.qpos[0].item(), data.qpos[1].item(), data.qpos[2].item()
            c, s = math.cos(heading), math.sin(heading)
            for k, (px, py) in enumerate(points):
                dx, dy = x + c * px - s * py - values["x"], y + s * px + c * py - values["y"]
                along, side = turn[0] * dx + turn[1] * dy, turn[0] * dy - turn[1] * dx
                on = abs(along) < values["half_length"] and abs(side) < across
                if was.get(k) != on:
                    was[k] = on
                    set_wheel(model, f"patch {k}", on * values["mu"], on * values["mu"])

        return switch

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return friction and region."""
        return {"parameters": {"mu": values["mu"]}, "where": {"world_region": patch_corners(values).tolist()}}

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return the patch."""
        return [{"kind": self.name, **values}]


def patch_corners(values: Values) -> Floats:
    """Return the rectangle's corners."""
    c, s = np.cos(values["angle"]), np.sin(values["angle"])
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * [values["half_length"], values["half_width"]]
    return np.asarray(corners @ np.array([[c, s], [-s, c]]) + [values["x"], values["y"]])
