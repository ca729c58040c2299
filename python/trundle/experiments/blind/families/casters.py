"""A caster: a wheel on an arm that swivels about a pivot, all of it bodies and joints of MuJoCo."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from trundle.experiments.blind.family import EpisodeContext, Family, Values
from trundle.experiments.blind.scene import Scene, Wheel, draw_point
from trundle.experiments.blind.world import add_wheel, at_site, quaternion

Floats = NDArray[np.float64]

SLIP_STIFFNESS_RATIO = 20.0
"""How much more the tyre resists side slip than the scrubbing does at the pivot."""


class CasterSwivel(Family):
    """An arm hinged to the object; the tyre resists side slip strongly, and scrubs as it swivels.

    Without its own mass the arm would turn so that the tyre's side force balances the scrubbing: at the pivot
    it resists sideways with `mu_side`, as long as it has not swivelled.
    """

    name = "caster_swivel"
    scales = ("mu_side",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return a pivot, an arm, and the direction that it has at first in each episode, object frame."""
        return {
            "point": list(draw_point(rng, scene.shape)),
            "trail": float(rng.uniform(0.03, 0.12)),
            "mu_side": float(np.exp(rng.uniform(np.log(30.0), np.log(250.0)))),
            "first": rng.uniform(-np.pi, np.pi, len(scene.pushes)).tolist(),
        }

    def extended(self, values: Values, rng: np.random.Generator) -> Values:
        """Let the arm begin in any direction: nobody turns it back."""
        return {**values, "first": [*values["first"], float(rng.uniform(-np.pi, np.pi))]}

    def add_to_world(self, context: EpisodeContext, values: Values) -> None:
        """Hang the arm on the object; it points from the wheel to the pivot."""
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
        """Return what it comes to at the pivot: the tyre slips a little."""
        slip = 1.0 + 1.0 / SLIP_STIFFNESS_RATIO
        found = {"trail": values["trail"] * slip, "mu_side": values["mu_side"] / slip}
        return {"parameters": found, "where": {"body_point": values["point"]}}

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return the caster."""
        x, y = values["point"]
        return [{"kind": self.name, "x": x, "y": y, **self.truth(scene, values)["parameters"]}]
