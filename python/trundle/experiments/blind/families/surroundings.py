"""Surroundings: a fixed obstacle, and a cable to a fixed point."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from trundle.experiments.blind.family import EpisodeContext, Family, Values
from trundle.experiments.blind.geometry import distance_to_outline, to_object, to_world
from trundle.experiments.blind.scene import Scene, draw_point
from trundle.experiments.blind.world import BODY_HEIGHT_M
from trundle.experiments.sampling import Floats, log_uniform

MIN_START_CLEARANCE_M = 0.03
"""Distance from the obstacle at the start of every episode."""
MIN_HIT_DEPTH_M = 0.02
"""Penetration of the undisturbed path in episodes that count as hits."""


class ObstacleContact(Family):
    """A post in the object's path: MuJoCo's contact with a fixed cylinder."""

    name = "obstacle_contact"

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return a position away from all starts that a training and a held-out episode hit."""
        radius, training = float(rng.uniform(0.04, 0.15)), len(paths) - scene.held_out
        starts = np.concatenate([path[::100] for path in paths])
        for _ in range(400):
            place = rng.choice(starts)[:2] + rng.uniform(-1.0, 1.0, 2)
            depth = [distance_to_outline(to_object(place, path[::60]), scene.shape.outline) for path in paths]
            if any(found[0] < radius + MIN_START_CLEARANCE_M for found in depth):
                continue
            hits = [found.min() < radius - MIN_HIT_DEPTH_M for found in depth]
            if any(hits[:training]) and any(hits[training:]):
                friction = float(rng.choice([0.0, 0.3]))
                return {"place": place.tolist(), "radius": radius, "friction": friction, "there": 1.0}
        return {}

    def scaled(self, values: Values, size: float) -> Values:
        """Return it with a smaller radius; at zero the post is absent."""
        return {**values, "radius": size * values["radius"], "there": size}

    def add_to_world(self, context: EpisodeContext, values: Values) -> None:
        """Add the cylinder."""
        if values["there"] == 0.0:
            return
        context.spec.worldbody.add_geom(
            name="obstacle",
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            size=[values["radius"], 0.3, 0.0],
            pos=[*values["place"], BODY_HEIGHT_M],
            friction=[values["friction"], 0.0, 0.0],
            condim=3 if values["friction"] else 1,
            priority=1,  # otherwise MuJoCo uses the larger friction of the two bodies
            solref=[0.01, 1.0],
        )

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return the position; errors of it are distances from the surface."""
        return {"parameters": {}, "where": {"world_point": values["place"], "radius": values["radius"]}}

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return the contact."""
        x, y = values["place"]
        known = {"radius": values["radius"], "friction": values["friction"]}
        return [{"kind": self.name, "x": x, "y": y, **known}]


class Tether(Family):
    """A cable: MuJoCo's tendon between two sites, slack below its rest length."""

    name = "tether"
    scales = ("stiffness",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return two ends, and a rest length that is exceeded for a third to two thirds of the time."""
        point = draw_point(rng, scene.shape)
        ways = np.concatenate([to_world(np.array(point), path[::100]) for path in paths])
        size, turn = rng.uniform(0.6, 1.5), rng.uniform(-np.pi, np.pi)
        anchor = ways.mean(axis=0) + size * np.array([np.cos(turn), np.sin(turn)])
        lengths = np.hypot(*(ways - anchor).T)
        return {
            "point": list(point),
            "anchor": anchor.tolist(),
            "stiffness": log_uniform(rng, 20.0, 250.0),
            "rest_length": float(np.quantile(lengths, rng.uniform(0.33, 0.67))),
        }

    def add_to_world(self, context: EpisodeContext, values: Values) -> None:
        """Add the tendon."""
        context.spec.worldbody.add_site(name="anchor", pos=[*values["anchor"], 0.0])
        context.table.add_site(name="tied", pos=[*values["point"], 0.0])
        slack = [0.0, values["rest_length"]]
        stiffness = [values["stiffness"], 0.0, 0.0]
        cable = context.spec.add_tendon(name="cable", stiffness=stiffness, springlength=slack)
        cable.wrap_site("anchor")
        cable.wrap_site("tied")

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return stiffness, rest length and ends."""
        found = {name: values[name] for name in ("stiffness", "rest_length")}
        where = {"body_point": values["point"], "world_point": values["anchor"]}
        return {"parameters": found, "where": where}

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return the cable."""
        (x, y), (ax, ay) = values["point"], values["anchor"]
        found = self.truth(scene, values)["parameters"]
        return [{"kind": self.name, "x": x, "y": y, "anchor_x": ax, "anchor_y": ay, **found}]
