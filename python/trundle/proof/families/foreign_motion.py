"""Physics of the object or the floor that the catalogue does not have."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from trundle.proof.family import Family, Hook, Site, Values
from trundle.proof.scene import CONTACT, Scene
from trundle.proof.world import set_wheel

Floats = NDArray[np.float64]


class Foreign(Family):
    """A family outside the catalogue: its truth names nothing."""

    foreign = True

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return nothing that an answer could be compared with."""
        return {"parameters": {}, "where": None}


class AirDrag(Foreign):
    """A sail: MuJoCo's fluid, a drag in proportion to the square of the speed."""

    name = "quadratic_drag"
    scales = ("density",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return a fluid as dense as makes a light sail of the object."""
        return {"density": float(np.exp(rng.uniform(np.log(400.0), np.log(4000.0))))}

    def furnish(self, site: Site, values: Values) -> None:
        """Fill the room."""
        site.spec.option.density = values["density"]


class Magnet(Foreign):
    """A point of the floor that attracts the object's origin, the more the nearer."""

    name = "magnet"
    scales = ("strength",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return a place near the paths."""
        place = np.mean([path[:, :2].mean(axis=0) for path in paths], axis=0) + rng.uniform(-0.3, 0.3, 2)
        return {"strength": float(np.exp(rng.uniform(np.log(8.0), np.log(40.0)))), "place": place.tolist()}

    def hook(self, model: Any, site: Site, values: Values) -> Hook | None:
        """Return a force of strength · d/(d² + r²) · r, at most half the strength."""
        (x, y), reach = values["place"], 0.25

        def pull(data: mujoco.MjData) -> None:
            dx, dy = x - data.qpos[0], y - data.qpos[1]
            pulled = values["strength"] * reach / (dx * dx + dy * dy + reach * reach)
            data.qfrc_applied[0] += pulled * dx
            data.qfrc_applied[1] += pulled * dy

        return pull


class WarmingWheel(Foreign):
    """A wheel whose grease is stiff at first and thins as it rolls."""

    name = "warming_wheel"
    scales = ("excess",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return by how much it is stiffer, and how long it takes to warm."""
        return {"excess": float(rng.uniform(2.0, 10.0)), "seconds": float(rng.uniform(1.0, 3.0))}

    def hook(self, model: Any, site: Site, values: Values) -> Hook | None:
        """Let the friction fall to that of the warm wheel in each episode."""
        wheel = site.scene.wheel

        def warm(data: mujoco.MjData) -> None:
            factor = 1.0 + values["excess"] * np.exp(-(data.time - CONTACT) / values["seconds"])
            set_wheel(model, "wheel", wheel.mu_x * factor, wheel.mu_y * factor)

        return warm


class Shaking(Foreign):
    """A machine nearby shakes the object to and fro along one direction of the room."""

    name = "shaking"
    scales = ("force",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return force, frequency and direction."""
        return {
            "force": float(np.exp(rng.uniform(np.log(4.0), np.log(25.0)))),
            "frequency": float(rng.uniform(0.5, 2.0)),
            "direction": float(rng.uniform(-np.pi, np.pi)),
            "phase": float(rng.uniform(-np.pi, np.pi)),
        }

    def hook(self, model: Any, site: Site, values: Values) -> Hook | None:
        """Return a sine of the time since contact."""
        c, s = np.cos(values["direction"]), np.sin(values["direction"])

        def shake(data: mujoco.MjData) -> None:
            turn = 2 * np.pi * values["frequency"] * (data.time - CONTACT) + values["phase"]
            force = values["force"] * np.sin(turn)
            data.qfrc_applied[0] += force * c
            data.qfrc_applied[1] += force * s

        return shake


MOTIONS: tuple[Family, ...] = (AirDrag(), Magnet(), WarmingWheel(), Shaking())
