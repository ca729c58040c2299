"""Instruments that the catalogue knows: an offset, a gain, a late clock, a heavy gripper, a wrong frame."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from trundle.proof.family import Family, Site, Values
from trundle.proof.scene import CONTACT, Scene
from trundle.proof.seen import Seen, sampled

Floats = NDArray[np.float64]


class ForceBias(Family):
    """An offset of the reading that begins with contact, and may drift."""

    name = "force_bias"
    scales = ("force_x", "force_y", "torque_z", "drift_x", "drift_y")

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return an offset of 1 to 8 N, with a drift one case in two."""
        size = np.exp(rng.uniform(np.log(1.0), np.log(8.0)))
        turn, drifts = rng.uniform(-np.pi, np.pi), rng.random() < 0.5
        drift = rng.normal(size=2) * 0.15 * size * drifts
        return {
            "force_x": float(size * np.cos(turn)),
            "force_y": float(size * np.sin(turn)),
            "torque_z": float(rng.normal() * 0.1 * size),
            "drift_x": float(drift[0]),
            "drift_y": float(drift[1]),
        }

    def distort(self, seen: Seen, site: Site, values: Values) -> Seen:
        """Add it to the reading."""
        since = np.maximum(seen.t - CONTACT, 0.0)
        offset = np.array([values["force_x"], values["force_y"], values["torque_z"]])
        drift = np.array([values["drift_x"], values["drift_y"], 0.0])
        added = (seen.t >= CONTACT)[:, None] * (offset + since[:, None] * drift)
        return seen.changed(wrench=seen.wrench + added)

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return offset and drift."""
        return {"parameters": dict(values), "where": None}

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return the offset, and the drift where there is one."""
        law = {"kind": self.name, **values}
        drifts = values["drift_x"] != 0.0 or values["drift_y"] != 0.0
        return [law if drifts else {k: v for k, v in law.items() if not k.startswith("drift")}]


class Latency(Family):
    """The wrench's clock runs late."""

    name = "latency"
    scales = ("delay",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return a delay of 20 to 150 ms."""
        return {"delay": float(np.exp(rng.uniform(np.log(0.02), np.log(0.15))))}

    def distort(self, seen: Seen, site: Site, values: Values) -> Seen:
        """Read what was true earlier."""
        return seen.changed(wrench=sampled(seen.t, seen.wrench, seen.t - values["delay"]))

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return the delay."""
        return {"parameters": dict(values), "where": None}

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return the delay."""
        return [{"kind": self.name, **values}]
