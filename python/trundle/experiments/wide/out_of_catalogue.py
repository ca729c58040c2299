"""Families without a law in the catalogue, for both engines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from trundle.experiments.blind.families.out_of_catalogue_motion import (
    HystereticSpring,
    Magnet,
    OutOfCatalogueFamily,
    RattlingLoad,
    Shaking,
    StickyGround,
    WarmingWheel,
)
from trundle.experiments.blind.family import EpisodeContext, Family, Hook, Values
from trundle.experiments.blind.push import CONTACT_TIME_S
from trundle.experiments.blind.scene import Scene
from trundle.experiments.sampling import Floats, log_uniform
from trundle.experiments.wide.ode_terms import InertialProperties, Kinematics, Term, Wrench
from trundle.experiments.wide.scene import WideScene

__all__ = ["MOVES_RESTING_OBJECT", "OUT_OF_CATALOGUE"]


class ForceLawFamily(OutOfCatalogueFamily):
    """A family given by one force law, which both engines apply."""

    def force(self, context: EpisodeContext, values: Values, t: float, at: Kinematics) -> Wrench:
        """Return force and moment about the object's origin, world axes."""
        raise NotImplementedError

    def hook(self, model: Any, context: EpisodeContext, values: Values) -> Hook | None:
        """Apply the force in MuJoCo."""

        def apply(data: mujoco.MjData) -> None:
            x, y, theta = data.qpos[:3].tolist()
            vx, vy, omega = data.qvel[:3].tolist()
            at = Kinematics(x, y, math.cos(theta), math.sin(theta), vx, vy, omega, theta)
            data.qfrc_applied[:3] += self.force(context, values, float(data.time), at)

        return apply

    def terms(self, scene: WideScene, episode: int, values: Values, trait: InertialProperties) -> list[Term]:
        """Apply the force in the ODE engine."""
        context = EpisodeContext(None, None, scene, episode)
        return [Term(lambda t, at: self.force(context, values, t, at))]


class WideMagnet(ForceLawFamily, Magnet):
    """A point of the floor that attracts the object's origin."""

    def force(self, context: EpisodeContext, values: Values, t: float, at: Kinematics) -> Wrench:
        """Return strength · r d/(d² + r²)."""
        (x, y), reach = values["place"], 0.25
        dx, dy = x - at.x, y - at.y
        pulled = values["strength"] * reach / (dx * dx + dy * dy + reach * reach)
        return pulled * dx, pulled * dy, 0.0


class WideShaking(ForceLawFamily, Shaking):
    """A machine shakes the object along one direction of the room."""

    def force(self, context: EpisodeContext, values: Values, t: float, at: Kinematics) -> Wrench:
        """Return a sine of the time since contact."""
        force = values["force"] * math.sin(
            2 * math.pi * values["frequency"] * (t - CONTACT_TIME_S) + values["phase"]
        )
        return force * math.cos(values["direction"]), force * math.sin(values["direction"]), 0.0


class WideStickyGround(ForceLawFamily, StickyGround):
    """A floor whose drag grows steadily in one direction."""

    def force(self, context: EpisodeContext, values: Values, t: float, at: Kinematics) -> Wrench:
        """Return a drag at the object's origin."""
        way = math.cos(values["direction"]) * at.x + math.sin(values["direction"]) * at.y - values["from"]
        drag = min(values["slope"] * max(way, 0.0), 1000.0)
        return -drag * at.vx, -drag * at.vy, 0.0


class WideWarmingWheel(WarmingWheel):
    """A wheel whose friction falls as its grease warms up."""

    def terms(self, scene: WideScene, episode: int, values: Values, trait: InertialProperties) -> list[Term]:
        """Reduce the friction over time in the ODE engine."""

        def factors(t: float) -> tuple[float, float]:
            more = 1.0 + values["excess"] * math.exp(-(t - CONTACT_TIME_S) / values["seconds"])
            return more, more

        trait.wheel_factors.append(factors)
        return []


class LateralLift(ForceLawFamily):
    """A force perpendicular to the velocity and proportional to it, like that of a skewed brush.

    No dissipative damping matrix has such a part.
    """

    name = "lateral_lift"
    scales = ("lift",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return N·s/m, of either sign."""
        size = log_uniform(rng, 20.0, 120.0) * math.sqrt(scene.mass / 20.0)
        return {"lift": size * float(rng.choice([-1.0, 1.0]))}

    def force(self, context: EpisodeContext, values: Values, t: float, at: Kinematics) -> Wrench:
        """Return a force to the left of the velocity."""
        return -values["lift"] * at.vy, values["lift"] * at.vx, 0.0


class Gusts(ForceLawFamily):
    """Aperiodic wind: a sum of sines with random phases in every episode."""

    name = "gusts"
    scales = ("force",)
    WAVES = 8

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return the size, the frequencies, and phases by episode and axis."""
        shape = (len(scene.pushes), 2, self.WAVES)
        return {
            "force": log_uniform(rng, 3.0, 15.0),
            "frequency": rng.uniform(0.05, 1.0, self.WAVES).tolist(),
            "phase": rng.uniform(-np.pi, np.pi, shape).tolist(),
        }

    def force(self, context: EpisodeContext, values: Values, t: float, at: Kinematics) -> Wrench:
        """Return the wind at a time."""
        size = values["force"] * math.sqrt(2.0 / self.WAVES)
        x, y = (
            size
            * sum(math.sin(2 * math.pi * f * t + p) for f, p in zip(values["frequency"], phases, strict=True))
            for phases in values["phase"][context.episode]
        )
        return x, y, 0.0


class FloorWaves(ForceLawFamily):
    """A wavy floor: the object's origin feels the slope of the surface."""

    name = "floor_waves"
    scales = ("force",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return the largest force, the wave vectors, and phases."""
        lengths, turns = rng.uniform(0.25, 0.7, 3), rng.uniform(-np.pi, np.pi, 3)
        vectors = 2 * np.pi / lengths[:, None] * np.column_stack([np.cos(turns), np.sin(turns)])
        return {
            "force": log_uniform(rng, 4.0, 25.0),
            "vectors": vectors.tolist(),
            "phases": rng.uniform(-np.pi, np.pi, 3).tolist(),
        }

    def force(self, context: EpisodeContext, values: Values, t: float, at: Kinematics) -> Wrench:
        """Return minus the slope of the surface times a weight."""
        fx = fy = 0.0
        for (kx, ky), phase in zip(values["vectors"], values["phases"], strict=True):
            size = values["force"] * math.cos(kx * at.x + ky * at.y + phase) / math.hypot(kx, ky) / 1.7
            fx, fy = fx - size * kx, fy - size * ky
        return fx, fy, 0.0


class LeakingLoad(OutOfCatalogueFamily):
    """Sand that leaks during every episode, and is refilled before the next."""

    name = "leaking_load"
    scales = ("share",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return the share of the mass that leaks, and the time constant as a share of the episode."""
        return {"share": float(rng.uniform(0.4, 0.75)), "pace": float(rng.uniform(0.3, 0.8))}

    def left(self, context: EpisodeContext, values: Values, t: float) -> float:
        """Return the remaining share of the mass."""
        scene: Any = context.scene
        seconds = float(values["pace"]) * (float(scene.seconds[context.episode]) - CONTACT_TIME_S)
        return 1.0 - float(values["share"]) * (1.0 - math.exp(-max(t - CONTACT_TIME_S, 0.0) / seconds))

    def hook(self, model: Any, context: EpisodeContext, values: Values) -> Hook | None:
        """Scale mass and inertia in MuJoCo. The lost mass keeps its velocity."""
        body = model.body("table").id
        mass, inertia = float(model.body_mass[body]), model.body_inertia[body].copy()

        def leak(data: mujoco.MjData) -> None:
            left = self.left(context, values, float(data.time))
            model.body_mass[body], model.body_inertia[body] = mass * left, inertia * left

        return leak

    def terms(self, scene: WideScene, episode: int, values: Values, trait: InertialProperties) -> list[Term]:
        """Scale mass and inertia in the ODE engine."""
        context = EpisodeContext(None, None, scene, episode)
        trait.factors.append(lambda t: self.left(context, values, t))
        return []


class WideRattlingLoad(RattlingLoad):
    """A drawer that slides freely and hits its ends: MuJoCo's joint limits."""

    engines = ("mujoco",)


MOVES_RESTING_OBJECT: frozenset[str] = frozenset({"magnet", "shaking", "gusts", "floor_waves"})
"""Families that would move a free object at rest."""
OUT_OF_CATALOGUE: dict[str, Family] = {
    family.name: family
    for family in (
        WideMagnet(),
        WideWarmingWheel(),
        WideShaking(),
        WideRattlingLoad(),
        HystereticSpring(),
        WideStickyGround(),
        LateralLift(),
        Gusts(),
        FloorWaves(),
        LeakingLoad(),
    )
}
"""By name. The correct answer is "unexplained"."""
