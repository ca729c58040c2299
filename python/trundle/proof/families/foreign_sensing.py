"""Instruments with faults that the catalogue does not have."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from trundle.proof.families.foreign_motion import Foreign
from trundle.proof.family import Family, Site, Values
from trundle.proof.scene import Scene
from trundle.proof.seen import Seen

Floats = NDArray[np.float64]


class CrossTalk(Foreign):
    """Each axis of the sensor reads some of the others."""

    name = "cross_talk"
    scales = ("leak",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return how much of each axis every other reads; N·m by N, N by N·m."""
        leak = rng.normal(size=(3, 3)) * [[0.0, 0.15, 0.6], [0.15, 0.0, 0.6], [0.1, 0.1, 0.0]]
        return {"leak": leak.tolist()}

    def sized(self, values: Values, size: float) -> Values:
        """Return it `size` times as strong."""
        return {"leak": (size * np.array(values["leak"])).tolist()}

    def distort(self, seen: Seen, site: Site, values: Values) -> Seen:
        """Mix the axes."""
        return seen.changed(wrench=seen.wrench @ (np.eye(3) + np.array(values["leak"])).T)


class DeadBand(Foreign):
    """Small forces are not read at all, larger ones too low."""

    name = "dead_band"
    scales = ("force",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return its width."""
        return {"force": float(np.exp(rng.uniform(np.log(2.0), np.log(12.0))))}

    def distort(self, seen: Seen, site: Site, values: Values) -> Seen:
        """Shrink forces towards zero, and the torque by a tenth of it per newton."""
        band = values["force"] * np.array([1.0, 1.0, 0.1])
        return seen.changed(wrench=np.sign(seen.wrench) * np.maximum(np.abs(seen.wrench) - band, 0.0))


SENSINGS: tuple[Family, ...] = (CrossTalk(), DeadBand())
