"""Instruments that mix, cut or distort what they read, or read it late, as the catalogue knows them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from trundle.experiments.blind.family import EpisodeContext, Family, Values
from trundle.experiments.blind.push import CONTACT_TIME_S
from trundle.experiments.blind.readings import Readings, interpolate
from trundle.experiments.blind.scene import Scene

Floats = NDArray[np.float64]


class CrossTalk(Family):
    """Each axis of the sensor reads some of the others."""

    name = "cross_talk"
    scales = ("leak",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return how much of each axis every other reads; N·m by N, N by N·m."""
        leak = rng.normal(size=(3, 3)) * [[0.0, 0.15, 0.6], [0.15, 0.0, 0.6], [0.1, 0.1, 0.0]]
        return {"leak": leak.tolist()}

    def scaled(self, values: Values, size: float) -> Values:
        """Return it `size` times as strong."""
        return {"leak": (size * np.array(values["leak"])).tolist()}

    def distort(self, seen: Readings, context: EpisodeContext, values: Values) -> Readings:
        """Mix the axes."""
        return seen.changed(wrench=seen.wrench @ (np.eye(3) + np.array(values["leak"])).T)

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return what each axis reads of the others."""
        return {"parameters": cross_talk_parameters(values), "where": None}

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return the same."""
        return [{"kind": self.name, **cross_talk_parameters(values)}]


class DeadBand(Family):
    """Small forces are not read at all, larger ones too low."""

    name = "dead_band"
    scales = ("force",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return its width."""
        return {"force": float(np.exp(rng.uniform(np.log(2.0), np.log(12.0))))}

    def distort(self, seen: Readings, context: EpisodeContext, values: Values) -> Readings:
        """Shrink forces towards zero, and the torque by a tenth of it per newton."""
        band = values["force"] * np.array([1.0, 1.0, 0.1])
        return seen.changed(wrench=np.sign(seen.wrench) * np.maximum(np.abs(seen.wrench) - band, 0.0))

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return half the width of the band, of forces and of the torque."""
        return {"parameters": {"force": values["force"], "torque": 0.1 * values["force"]}, "where": None}

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return the same."""
        return [{"kind": self.name, "force": values["force"], "torque": 0.1 * values["force"]}]


class Saturation(Family):
    """The sensor reads no more than so much."""

    name = "saturation"
    scales = ("cut",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return by which share of its range the reading is cut."""
        return {"cut": float(rng.uniform(0.3, 0.7))}

    def distort(self, seen: Readings, context: EpisodeContext, values: Values) -> Readings:
        """Cut the reading of each axis."""
        most = (1.0 - values["cut"]) * np.max(np.abs(seen.wrench), axis=0)
        return seen.changed(wrench=np.clip(seen.wrench, -most, most))

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return nothing to compare: the limits hang on the push."""
        return {"parameters": {}, "where": None}


class ClockDrift(Family):
    """The sensor's clock runs at another pace; it is right at contact."""

    name = "clock_drift"
    scales = ("pace",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return by how much, either way."""
        return {"pace": float(rng.uniform(0.02, 0.08) * rng.choice([-1.0, 1.0]))}

    def distort(self, seen: Readings, context: EpisodeContext, values: Values) -> Readings:
        """Read what was true before or will be."""
        when = seen.t - values["pace"] * np.maximum(seen.t - CONTACT_TIME_S, 0.0)
        return seen.changed(wrench=interpolate(seen.t, seen.wrench, when))

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return the drift: seconds of the sensor's clock for each true one, less one."""
        return {"parameters": {"drift": clock_drift(values)}, "where": None}

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return the drift."""
        return [{"kind": self.name, "drift": clock_drift(values)}]


class SensorPlay(Family):
    """The reading follows with play: it stays where it is until the force has moved on by so much."""

    name = "sensor_play"
    scales = ("width",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return the width, N; a tenth of it in N·m for the torque."""
        return {"width": float(np.exp(rng.uniform(np.log(3.0), np.log(15.0))))}

    def distort(self, seen: Readings, context: EpisodeContext, values: Values) -> Readings:
        """Follow each axis with play."""
        half = values["width"] / 2 * np.array([1.0, 1.0, 0.1])
        followed, last = np.empty_like(seen.wrench), np.zeros(3)
        for k, true in enumerate(seen.wrench):
            last = np.minimum(np.maximum(last, true - half), true + half)
            followed[k] = last
        return seen.changed(wrench=followed)

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return the width, of forces and of the torque."""
        return {"parameters": {"force": values["width"], "torque": 0.1 * values["width"]}, "where": None}

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return the same."""
        return [{"kind": self.name, "force": values["width"], "torque": 0.1 * values["width"]}]


class SensorLag(Family):
    """The sensor's filter is slow: a reading of first order."""

    name = "sensor_lag"
    scales = ("time_constant",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return a time constant of 20 to 120 ms."""
        return {"time_constant": float(np.exp(rng.uniform(np.log(0.02), np.log(0.12))))}

    def distort(self, seen: Readings, context: EpisodeContext, values: Values) -> Readings:
        """Filter the reading."""
        step = float(seen.t[1] - seen.t[0])
        if values["time_constant"] < 1e-3 * step:
            return seen
        share = -np.expm1(-step / values["time_constant"])
        followed, last = np.empty_like(seen.wrench), np.zeros(3)
        for k, true in enumerate(seen.wrench):
            last = last + share * (true - last)
            followed[k] = last
        return seen.changed(wrench=followed)

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return the time constant."""
        return {"parameters": dict(values), "where": None}

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return the time constant."""
        return [{"kind": self.name, **values}]


def cross_talk_parameters(values: Values) -> dict[str, float]:
    """Return what each axis reads of each other, by the catalogue's names."""
    axes = ("x", "y", "torque")
    leak = values["leak"]
    pairs = [(i, k) for i in range(3) for k in range(3) if i != k]
    return {f"{axes[i]}_from_{axes[k]}": float(leak[i][k]) for i, k in pairs}


def clock_drift(values: Values) -> float:
    """Return seconds of the sensor's clock for each true one, less one."""
    return float(values["pace"] / (1.0 - values["pace"]))


DISTORTIONS: tuple[Family, ...] = (
    CrossTalk(),
    Saturation(),
    DeadBand(),
    SensorPlay(),
    ClockDrift(),
    SensorLag(),
)
