"""Instrument effects of the catalogue: offset, gain, delay, gripper inertia, tracker offset."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from trundle.experiments.blind.family import EpisodeContext, Family, Values
from trundle.experiments.blind.push import CONTACT_TIME_S, Grasp
from trundle.experiments.blind.readings import Readings, gripper_poses, interpolate
from trundle.experiments.blind.scene import Scene
from trundle.experiments.sampling import Floats, log_uniform


class ForceBias(Family):
    """An offset of the reading that begins with contact and may drift."""

    name = "force_bias"
    scales = ("force_x", "force_y", "torque_z", "drift_x", "drift_y")

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return an offset of 1 to 8 N, with a drift in every second case."""
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

    def distort(self, seen: Readings, context: EpisodeContext, values: Values) -> Readings:
        """Add the offset to the reading."""
        since = np.maximum(seen.t - CONTACT_TIME_S, 0.0)
        offset = np.array([values["force_x"], values["force_y"], values["torque_z"]])
        drift = np.array([values["drift_x"], values["drift_y"], 0.0])
        added = (seen.t >= CONTACT_TIME_S)[:, None] * (offset + since[:, None] * drift)
        return seen.changed(wrench=seen.wrench + added)

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return the offset, and the drift if it is not zero."""
        law = {"kind": self.name, **values}
        drifts = values["drift_x"] != 0.0 or values["drift_y"] != 0.0
        return [law if drifts else {k: v for k, v in law.items() if not k.startswith("drift")}]


class Latency(Family):
    """The wrench is delayed."""

    name = "latency"
    scales = ("delay",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return a delay of 20 to 150 ms."""
        return {"delay": log_uniform(rng, 0.02, 0.15)}

    def distort(self, seen: Readings, context: EpisodeContext, values: Values) -> Readings:
        """Delay the reading."""
        return seen.changed(wrench=interpolate(seen.t, seen.wrench, seen.t - values["delay"]))


class ForceScale(Family):
    """The sensor has a wrong gain on each axis."""

    name = "force_scale"
    scales = ("log_x", "log_y", "log_torque")

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return gains between 0.6 and 1.6. Equal gains are indistinguishable from another mass."""
        return {name: float(rng.uniform(np.log(0.6), np.log(1.6))) for name in self.scales}

    def distort(self, seen: Readings, context: EpisodeContext, values: Values) -> Readings:
        """Scale the reading."""
        return seen.changed(wrench=seen.wrench * np.exp([values[name] for name in self.scales]))

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return the gains if the mass is given; otherwise only their ratios are identifiable."""
        gains = {name.replace("log", "gain"): float(np.exp(values[name])) for name in self.scales}
        return {"parameters": gains if scene.mass_given else {}, "where": None}

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return the gains; if the mass is not given, relative to the gain of x."""
        common = 0.0 if scene.mass_given else values["log_x"]
        gains = {name.replace("log", "gain"): float(np.exp(values[name] - common)) for name in self.scales}
        return [{"kind": self.name, **gains}]


class GripperInertia(Family):
    """The part beyond the sensor has a mass: a body at the grasp."""

    name = "gripper_inertia"
    scales = ("mass",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return a mass of 1.5 to 12 kg."""
        return {"mass": log_uniform(rng, 1.5, 12.0)}

    def add_to_world(self, context: EpisodeContext, values: Values) -> None:
        """Fix the mass to the object at the grasp."""
        grasp = context.scene.pushes[context.episode].grasp
        sphere = mujoco.mjtGeom.mjGEOM_SPHERE
        tool = context.table.add_body(name="tool", pos=[grasp.x, grasp.y, 0.2])
        tool.add_geom(type=sphere, size=[0.02, 0, 0], mass=values["mass"], contype=0, conaffinity=0)


class TrackerOffset(Family):
    """The tracked frame differs from the footprint's frame."""

    name = "tracker_offset"
    scales = ("offset_x", "offset_y", "offset_theta")

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return an offset of 5 cm to 25 cm with a small rotation."""
        size, turn = rng.uniform(0.05, 0.25), rng.uniform(-np.pi, np.pi)
        x, y, theta = size * np.cos(turn), size * np.sin(turn), rng.normal() * 0.05
        return {"offset_x": float(x), "offset_y": float(y), "offset_theta": float(theta)}

    def distort(self, seen: Readings, context: EpisodeContext, values: Values) -> Readings:
        """Report the poses of the tracked frame."""
        frame = Grasp(values["offset_x"], values["offset_y"], values["offset_theta"])
        return seen.changed(pose=gripper_poses(seen.pose, frame))
