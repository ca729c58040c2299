"""What the floor does beyond dry friction: a slope, a patch, a grain."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from trundle.proof.family import Family, Site, Values
from trundle.proof.scene import Scene

Floats = NDArray[np.float64]


class FloorSlope(Family):
    """A floor that slopes: gravity has a part along the joints; the brake goes off at contact."""

    name = "floor_slope"
    scales = ("accel_x", "accel_y")

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return a slope of 0.3° to 3° in any direction."""
        size = 9.81 * np.radians(np.exp(rng.uniform(np.log(0.3), np.log(3.0))))
        turn = rng.uniform(-np.pi, np.pi)
        return {"accel_x": float(size * np.cos(turn)), "accel_y": float(size * np.sin(turn))}

    def furnish(self, site: Site, values: Values) -> None:
        """Tilt gravity."""
        site.spec.option.gravity = [values["accel_x"], values["accel_y"], 0.0]

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return the acceleration."""
        return {"parameters": dict(values), "where": None}

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return the slope."""
        return [{"kind": "floor_slope", **values}]
