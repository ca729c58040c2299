"""A caster: a wheel on an arm that swivels about a pivot, built of MuJoCo bodies and joints."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from trundle.experiments.blind.family import EpisodeContext, Family, Values
from trundle.experiments.blind.scene import Scene, Wheel, draw_point
from trundle.experiments.blind.world import add_wheel, at_site, quaternion
from trundle.experiments.sampling import Floats, log_uniform

SLIP_STIFFNESS_RATIO = 20.0
"""Resistance of the tyre to side slip over the resistance of its scrubbing at the pivot."""


class CasterSwivel(Family):
    """An arm hinged to the object. The tyre resists side slip strongly, and scrubs as it swivels.

    A massless arm turns so that the tyre's side force balances the scrubbing torque. At the pivot it then
    resists sideways motion with `mu_side`.
    """

    name = "caster_swivel"
    scales = ("mu_side",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return a pivot, an arm, and its initial direction in each episode, object frame."""
        return {
            "point": list(draw_point(rng, scene.shape)),
            "trail": float(rng.uniform(0.03, 0.12)),
            "mu_side": log_uniform(rng, 30.0, 250.0),
            "first": rng.uniform(-np.pi, np.pi, len(scene.pushes)).tolist(),
        }

    def extended(self, values: Values, rng: np.random.Generator) -> Values:
        """Add a random initial direction of the arm."""
        return {**values, "first": [*values["first"], float(rng.uniform(-np.pi, np.pi))]}

    def add_to_world(self, context: EpisodeContext, values: Values) -> None:
        """Add the arm, which points from the wheel to the pivot."""
        trail, side = values["trail"], values["mu_side"]
        turn = quaternion(values["first"][context.episode])
        arm = context.table.add_body(name="caster", pos=[*values["point"], 0.0], quat=turn)
        arm.add_joint(name="swivel", type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 0, 1])
        arm.explicitinertial = True
        arm.mass, arm.inertia, arm.ipos = 0.01, [1e-4, 1e-4, 1e-5], [0.0, 0.0, 0.0]
        add_wheel(context.spec, arm, "caster", Wheel(-trail, 0.0, 0.0, 0.0, SLIP_STIFFNESS_RATIO * side))
        scrub = {**at_site("caster", 5), "gainprm": [0.0] * 10}
        kind = mujoco.mjtBias.mjBIAS_AFFINE
        damping = side * trail**2
        context.spec.add_actuator(name="scrub", biastype=kind, biasprm=[0, 0, -damping] + [0.0] * 7, **scrub)

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return the equivalent friction at the pivot, corrected for the tyre's slip."""
        slip = 1.0 + 1.0 / SLIP_STIFFNESS_RATIO
        found = {"trail": values["trail"] * slip, "mu_side": values["mu_side"] / slip}
        return {"parameters": found, "where": {"body_point": values["point"]}}

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return the caster."""
        x, y = values["point"]
        return [{"kind": self.name, "x": x, "y": y, **self.truth(scene, values)["parameters"]}]
