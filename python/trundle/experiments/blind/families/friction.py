"""Dry friction: feet with MuJoCo contacts, pressed on the floor by a constant force."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from trundle.experiments.blind.family import EpisodeContext, Family, Values
from trundle.experiments.blind.scene import Scene, draw_point
from trundle.experiments.sampling import Floats, log_uniform

TOTAL_FOOT_LOAD_N = 100.0
"""Load of all feet together; the friction coefficient scales the force."""
FOOT_RADIUS_M = 0.02
"""Radius of a foot."""
FOOT_CONTACT = {"contype": 2, "conaffinity": 2, "condim": 3}
"""Feet collide with the floor only."""


class CoulombFriction(Family):
    """Dry friction at a point, or shared by all feet: MuJoCo contacts with an elliptic cone."""

    name = "coulomb_friction"
    scales = ("force",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return a force, and a point; without a point (one case in three) all feet share the force."""
        force = log_uniform(rng, 3.0, 30.0)
        whole = bool(rng.random() < 1 / 3)
        return {"force": force, "point": None if whole else list(draw_point(rng, scene.shape))}

    def add_to_world(self, context: EpisodeContext, values: Values) -> None:
        """Add the floor and the feet."""
        points = context.scene.shape.feet.tolist() if values["point"] is None else [values["point"]]
        friction = [values["force"] / TOTAL_FOOT_LOAD_N, 0.0, 0.0]
        plane = mujoco.mjtGeom.mjGEOM_PLANE
        context.spec.worldbody.add_geom(type=plane, size=[50.0, 50.0, 1.0], friction=friction, **FOOT_CONTACT)
        for k, (x, y) in enumerate(points):
            add_foot(context, f"foot {k}", (x, y), TOTAL_FOOT_LOAD_N / len(points), friction)

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return force and point."""
        where = None if values["point"] is None else {"body_point": values["point"]}
        return {"parameters": {"force": values["force"]}, "where": where}

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return friction at the point, or under the supports."""
        if values["point"] is None:
            return [{"kind": "support_friction", "force": values["force"], "spread": 1.0}]
        x, y = values["point"]
        return [{"kind": "coulomb_friction", "x": x, "y": y, "force": values["force"]}]


def add_foot(
    context: EpisodeContext, name: str, point: tuple[float, float], load: float, friction: list[float]
) -> None:
    """Add a light foot that slides vertically and is pressed on the floor."""
    foot = context.table.add_body(name=name, pos=[*point, FOOT_RADIUS_M])
    joint = mujoco.mjtJoint.mjJNT_SLIDE
    foot.add_joint(name=f"{name} lift", type=joint, axis=[0, 0, 1], damping=1.0)
    sphere = mujoco.mjtGeom.mjGEOM_SPHERE
    foot.add_geom(type=sphere, size=[FOOT_RADIUS_M, 0.0, 0.0], mass=0.01, friction=friction, **FOOT_CONTACT)
    context.spec.add_actuator(
        name=f"{name} load",
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        target=f"{name} lift",
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        biasprm=[-load] + [0.0] * 9,
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        gainprm=[0.0] * 10,
    )
