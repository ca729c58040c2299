"""Inertia: an offset mass centre, a change of mass, and a swinging load."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from trundle.experiments.blind.family import EpisodeContext, Family, Hook, Values
from trundle.experiments.blind.scene import Scene, draw_event, draw_point
from trundle.experiments.sampling import Floats, log_uniform

LOAD_DAMPING_RATIO = 0.03
"""Damping ratio of a swinging load."""
MIN_BODY_MASS_KG = 1e-4
"""MuJoCo requires a mass of moving bodies."""


class ComOffset(Family):
    """The mass centre differs from the centroid of the footprint; the inertia about it is unchanged."""

    name = "com_offset"
    scales = ("x", "y")

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return an offset of 5 cm to 25 cm."""
        size, turn = rng.uniform(0.05, 0.25), rng.uniform(-np.pi, np.pi)
        return {"x": float(size * np.cos(turn)), "y": float(size * np.sin(turn))}

    def add_to_world(self, context: EpisodeContext, values: Values) -> None:
        """Move the inertia of the object."""
        model = context.spec.compile()
        body = model.body("table")
        flat = np.empty(9)
        mujoco.mju_quat2Mat(flat, body.iquat)
        frame = flat.reshape(3, 3)
        spin = float((frame @ np.diag(body.inertia) @ frame.T)[2, 2])
        x, y, z = body.ipos
        context.table.explicitinertial = True
        context.table.mass = float(body.mass[0])
        context.table.ipos = [x + values["x"], y + values["y"], z]
        context.table.iquat = [1.0, 0.0, 0.0, 0.0]
        context.table.inertia = [spin, spin, spin]

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return the mass centre in the object's frame."""
        x, y = (float(c + values[axis]) for c, axis in zip(scene.shape.centroid, "xy", strict=True))
        return {"parameters": {"com_x": x, "com_y": y}, "where": {"body_point": [x, y]}}


class MassChange(Family):
    """Load is added or removed at one time of a training episode, permanently."""

    name = "mass_change"
    scales = ("mass",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return a training episode, a time, and a signed mass."""
        on = rng.random() < 0.5
        share = rng.uniform(0.25, 1.0) if on else -rng.uniform(0.2, 0.5)
        return {
            **draw_event(rng, scene),
            "mass": float(share * scene.mass),
        }

    def hook(self, model: Any, context: EpisodeContext, values: Values) -> Hook | None:
        """Scale the object's mass and inertia from that time on."""
        factor = 1.0 + values["mass"] / context.scene.mass
        body, done = model.body("table").id, [False]

        def change() -> None:
            if not done[0]:
                model.body_mass[body] *= factor
                model.body_inertia[body] *= factor
                done[0] = True

        if context.episode > values["episode"]:
            change()
        if context.episode != values["episode"]:
            return None
        return lambda data: change() if data.time >= values["time"] else None

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return mass and time."""
        event = {"episode": f"episode_{values['episode']:02}", "time": values["time"]}
        return {"parameters": {"mass": values["mass"]}, "where": {"event": event}}

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return the event."""
        return [{"kind": self.name, **values}]


class SwingingLoad(Family):
    """Part of the mass is a separate body on two springs."""

    name = "swinging_load"
    scales = ("mass",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return a position, a mass, and a frequency."""
        return {
            "point": list(draw_point(rng, scene.shape)),
            "mass": float(rng.uniform(0.15, 0.5) * scene.mass),
            "frequency": log_uniform(rng, 0.5, 3.0),
        }

    def add_to_world(self, context: EpisodeContext, values: Values) -> None:
        """Move the mass from the object to a body on springs."""
        mass, omega = max(values["mass"], MIN_BODY_MASS_KG), 2 * np.pi * values["frequency"]
        for geom in context.table.geoms:
            geom.mass *= 1.0 - mass / context.scene.mass
        load = context.table.add_body(name="load", pos=[*values["point"], 0.2])
        for name, axis in (("load x", [1, 0, 0]), ("load y", [0, 1, 0])):
            joint = load.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
            joint.stiffness = [mass * omega**2, 0.0, 0.0]
            joint.damping = [2 * LOAD_DAMPING_RATIO * mass * omega, 0.0, 0.0]
        sphere = mujoco.mjtGeom.mjGEOM_SPHERE
        load.add_geom(type=sphere, size=[0.02, 0, 0], mass=mass, contype=0, conaffinity=0)

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return mass, frequency and position."""
        found = {name: values[name] for name in ("mass", "frequency")}
        return {"parameters": found, "where": {"body_point": values["point"]}}

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return the load."""
        x, y = values["point"]
        found = self.truth(scene, values)["parameters"]
        return [{"kind": self.name, "x": x, "y": y, "damping_ratio": LOAD_DAMPING_RATIO, **found}]
