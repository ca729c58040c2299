"""Friction of joints, and drag with a sublinear dependence on speed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from trundle.experiments.blind.family import EpisodeContext, Family, Hook, Values
from trundle.experiments.blind.scene import Scene
from trundle.experiments.sampling import Floats, log_uniform

RING_RADIUS_M = 0.4
"""Radius of the ring on which the thinning drag acts."""
REFERENCE_SPEED_M_PER_S = 0.1
"""Speed at which the catalogue states the force of a thinning drag."""


class AxisFriction(Family):
    """Dry friction of the slides and the hinge of the object: MuJoCo's `frictionloss`."""

    name = "axis_friction"
    scales = ("force_x", "force_y", "torque")

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return forces along x and y that differ by a factor of at least 1.5, and a torque."""
        small = log_uniform(rng, 2.0, 10.0)
        forces = [small, small * float(rng.uniform(1.5, 4.0))]
        rng.shuffle(forces)
        torque = log_uniform(rng, 0.3, 3.0)
        return {"force_x": forces[0], "force_y": forces[1], "torque": torque}

    def add_to_world(self, context: EpisodeContext, values: Values) -> None:
        """Set the friction of the joints."""
        for joint, name in zip(context.table.joints, self.scales, strict=True):
            joint.frictionloss = values[name]

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return the forces, and the direction of the first axis."""
        return {"parameters": {**values, "angle": 0.0}, "where": None}


class ThinningDrag(Family):
    """A drag that grows with the square root of the speed."""

    name = "thinning_drag"
    scales = ("drag",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return the force at 1 m/s, and the radius of the ring."""
        return {"drag": log_uniform(rng, 10.0, 80.0), "ring": RING_RADIUS_M}

    def hook(self, model: Any, context: EpisodeContext, values: Values) -> Hook | None:
        """Apply a force at the object's origin, and a torque as on a ring."""
        ring = values["ring"]

        def brake(data: mujoco.MjData) -> None:
            vx, vy, spin = data.qvel[0].item(), data.qvel[1].item(), ring * data.qvel[2].item()
            drag = values["drag"] / (vx * vx + vy * vy + spin * spin + 1e-4) ** 0.25
            data.qfrc_applied[:3] += (-drag * vx, -drag * vy, -drag * ring * spin)

        return brake

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return the force at the catalogue's reference speed, and the exponent."""
        return {
            "parameters": {"force": values["drag"] * REFERENCE_SPEED_M_PER_S**0.5, "exponent": 0.5},
            "where": None,
        }

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return drag under the whole body, which approximates the ring."""
        law = {"kind": self.name, "force": values["drag"] * REFERENCE_SPEED_M_PER_S**0.5, "exponent": 0.5}
        return [{**law, "spread": values["ring"] / scene.shape.gyration}]
