"""Sensor faults of the catalogue: cross-talk, dead band, saturation, clock drift, play and lag."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trundle.experiments.blind.family import EpisodeContext, Family, Values
from trundle.experiments.blind.push import CONTACT_TIME_S
from trundle.experiments.blind.readings import Readings, interpolate
from trundle.experiments.blind.scene import Scene
from trundle.experiments.sampling import Floats, log_uniform


class CrossTalk(Family):
    """Each axis of the sensor reads a part of the others."""

    name = "cross_talk"
    scales = ("leak",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return the gain from each axis to each other one; N·m per N, N per N·m."""
        leak = rng.normal(size=(3, 3)) * [[0.0, 0.15, 0.6], [0.15, 0.0, 0.6], [0.1, 0.1, 0.0]]
        return {"leak": leak.tolist()}

    def scaled(self, values: Values, size: float) -> Values:
        """Return the values of the effect `size` times as strong."""
        return {"leak": (size * np.array(values["leak"])).tolist()}

    def distort(self, seen: Readings, context: EpisodeContext, values: Values) -> Readings:
        """Mix the axes."""
        return seen.changed(wrench=seen.wrench @ (np.eye(3) + np.array(values["leak"])).T)

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return the gains between axes."""
        return {"parameters": cross_talk_parameters(values), "where": None}


class DeadBand(Family):
    """Small forces read zero, larger ones too low."""

    name = "dead_band"
    scales = ("force",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return half the width of the band."""
        return {"force": log_uniform(rng, 2.0, 12.0)}

    def distort(self, seen: Readings, context: EpisodeContext, values: Values) -> Readings:
        """Shrink forces towards zero, and the torque by 0.1 N·m per newton."""
        band = values["force"] * np.array([1.0, 1.0, 0.1])
        return seen.changed(wrench=np.sign(seen.wrench) * np.maximum(np.abs(seen.wrench) - band, 0.0))

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return half the width of the band, for forces and for the torque."""
        return {"parameters": {"force": values["force"], "torque": 0.1 * values["force"]}, "where": None}


class Saturation(Family):
    """The reading is limited."""

    name = "saturation"
    scales = ("cut",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return the share of the range that is cut."""
        return {"cut": float(rng.uniform(0.3, 0.7))}

    def distort(self, seen: Readings, context: EpisodeContext, values: Values) -> Readings:
        """Limit the reading of each axis."""
        most = (1.0 - values["cut"]) * np.max(np.abs(seen.wrench), axis=0)
        return seen.changed(wrench=np.clip(seen.wrench, -most, most))

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return no parameters: the limits depend on the push."""
        return {"parameters": {}, "where": None}

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return no law: the catalogue has one range for all episodes."""
        return []


class ClockDrift(Family):
    """The sensor's clock has another rate; it is correct at contact."""

    name = "clock_drift"
    scales = ("pace",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return the relative rate error, of either sign."""
        return {"pace": float(rng.uniform(0.02, 0.08) * rng.choice([-1.0, 1.0]))}

    def distort(self, seen: Readings, context: EpisodeContext, values: Values) -> Readings:
        """Read the wrench at another time."""
        when = seen.t - values["pace"] * np.maximum(seen.t - CONTACT_TIME_S, 0.0)
        return seen.changed(wrench=interpolate(seen.t, seen.wrench, when))

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return the drift: seconds of the sensor's clock per true second, minus one."""
        return {"parameters": {"drift": clock_drift(values)}, "where": None}


class SensorPlay(Family):
    """The reading has play: it changes only after the force has moved by the width."""

    name = "sensor_play"
    scales = ("width",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return the width in N; the width of the torque is a tenth of it in N·m."""
        return {"width": log_uniform(rng, 3.0, 15.0)}

    def distort(self, seen: Readings, context: EpisodeContext, values: Values) -> Readings:
        """Apply play to each axis."""
        half = values["width"] / 2 * np.array([1.0, 1.0, 0.1])
        followed, last = np.empty_like(seen.wrench), np.zeros(3)
        for k, true in enumerate(seen.wrench):
            last = np.minimum(np.maximum(last, true - half), true + half)
            followed[k] = last
        return seen.changed(wrench=followed)

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return the width, of forces and of the torque."""
        return {"parameters": {"force": values["width"], "torque": 0.1 * values["width"]}, "where": None}


class SensorLag(Family):
    """The reading is low-pass filtered by a filter of first order."""

    name = "sensor_lag"
    scales = ("time_constant",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return a time constant of 20 to 120 ms."""
        return {"time_constant": log_uniform(rng, 0.02, 0.12)}

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


def cross_talk_parameters(values: Values) -> dict[str, float]:
    """Return the gains between axes by the catalogue's names."""
    axes = ("x", "y", "torque")
    leak = values["leak"]
    pairs = [(i, k) for i in range(3) for k in range(3) if i != k]
    return {f"{axes[i]}_from_{axes[k]}": float(leak[i][k]) for i, k in pairs}


def clock_drift(values: Values) -> float:
    """Return seconds of the sensor's clock per true second, minus one."""
    return float(values["pace"] / (1.0 - values["pace"]))


DISTORTIONS: tuple[Family, ...] = (
    CrossTalk(),
    Saturation(),
    DeadBand(),
    SensorPlay(),
    ClockDrift(),
    SensorLag(),
)
