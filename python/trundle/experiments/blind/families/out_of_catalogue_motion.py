"""Physics of the object or the floor without a law in the catalogue."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from trundle.experiments.blind.family import EpisodeContext, Family, Hook, Values
from trundle.experiments.blind.push import CONTACT_TIME_S
from trundle.experiments.blind.scene import Scene
from trundle.experiments.blind.world import set_wheel
from trundle.experiments.sampling import Floats, log_uniform


class OutOfCatalogueFamily(Family):
    """A family outside the catalogue."""

    out_of_catalogue = True


class Magnet(OutOfCatalogueFamily):
    """A point of the floor that attracts the object's origin."""

    name = "magnet"
    scales = ("strength",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return a position near the paths."""
        place = np.mean([path[:, :2].mean(axis=0) for path in paths], axis=0) + rng.uniform(-0.3, 0.3, 2)
        return {"strength": log_uniform(rng, 8.0, 40.0), "place": place.tolist()}

    def hook(self, model: Any, context: EpisodeContext, values: Values) -> Hook | None:
        """Apply a force of strength · d/(d² + r²) · r, at most half the strength."""
        (x, y), reach = values["place"], 0.25

        def pull(data: mujoco.MjData) -> None:
            dx, dy = x - data.qpos[0], y - data.qpos[1]
            pulled = values["strength"] * reach / (dx * dx + dy * dy + reach * reach)
            data.qfrc_applied[0] += pulled * dx
            data.qfrc_applied[1] += pulled * dy

        return pull


class WarmingWheel(OutOfCatalogueFamily):
    """A wheel whose friction falls as its grease warms up."""

    name = "warming_wheel"
    scales = ("excess",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return the initial excess of friction, and the time constant."""
        return {"excess": float(rng.uniform(2.0, 10.0)), "seconds": float(rng.uniform(1.0, 3.0))}

    def hook(self, model: Any, context: EpisodeContext, values: Values) -> Hook | None:
        """Let the friction fall to that of the warm wheel in each episode."""
        wheel = context.scene.wheel

        def warm(data: mujoco.MjData) -> None:
            factor = 1.0 + values["excess"] * np.exp(-(data.time - CONTACT_TIME_S) / values["seconds"])
            set_wheel(model, "wheel", wheel.mu_x * factor, wheel.mu_y * factor)

        return warm


class Shaking(OutOfCatalogueFamily):
    """A machine shakes the object along one direction of the room."""

    name = "shaking"
    scales = ("force",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return force, frequency, direction and phase."""
        return {
            "force": log_uniform(rng, 4.0, 25.0),
            "frequency": float(rng.uniform(0.5, 2.0)),
            "direction": float(rng.uniform(-np.pi, np.pi)),
            "phase": float(rng.uniform(-np.pi, np.pi)),
        }

    def hook(self, model: Any, context: EpisodeContext, values: Values) -> Hook | None:
        """Apply a sine of the time since contact."""
        c, s = np.cos(values["direction"]), np.sin(values["direction"])

        def shake(data: mujoco.MjData) -> None:
            turn = 2 * np.pi * values["frequency"] * (data.time - CONTACT_TIME_S) + values["phase"]
            force = values["force"] * np.sin(turn)
            data.qfrc_applied[0] += force * c
            data.qfrc_applied[1] += force * s

        return shake


class RattlingLoad(OutOfCatalogueFamily):
    """A drawer that slides freely and hits its ends: MuJoCo's joint limits."""

    name = "rattling_load"
    scales = ("mass",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return a mass, a direction, and the travel."""
        return {
            "mass": float(rng.uniform(0.25, 0.6) * scene.mass),
            "direction": float(rng.uniform(-np.pi, np.pi)),
            "range": float(rng.uniform(0.05, 0.2)),
        }

    def add_to_world(self, context: EpisodeContext, values: Values) -> None:
        """Move the mass from the object to the drawer."""
        mass = max(values["mass"], 1e-4)
        for geom in context.table.geoms:
            geom.mass *= 1.0 - mass / context.scene.mass
        drawer = context.table.add_body(name="drawer", pos=[*context.scene.shape.centroid, 0.2])
        joint = drawer.add_joint(name="drawer", type=mujoco.mjtJoint.mjJNT_SLIDE)
        joint.axis = [np.cos(values["direction"]), np.sin(values["direction"]), 0.0]
        joint.limited, joint.range = True, [-values["range"], values["range"]]
        sphere = mujoco.mjtGeom.mjGEOM_SPHERE
        drawer.add_geom(type=sphere, size=[0.02, 0, 0], mass=mass, contype=0, conaffinity=0)


class HystereticSpring(OutOfCatalogueFamily):
    """A hysteretic spring to the room (Bouc-Wen model)."""

    name = "hysteretic_spring"
    scales = ("stiffness",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return stiffness and yield displacement."""
        return {
            "stiffness": log_uniform(rng, 40.0, 250.0),
            "yields": float(rng.uniform(0.08, 0.25)),
        }

    def hook(self, model: Any, context: EpisodeContext, values: Values) -> Hook | None:
        """Apply the force at the object's origin; its state is reset in each episode."""
        memory, step, limit = [0.0, 0.0], model.opt.timestep, values["yields"]

        def pull(data: mujoco.MjData) -> None:
            for axis in (0, 1):
                speed, bent = data.qvel[axis].item(), memory[axis] / limit
                memory[axis] += step * (speed - 0.5 * bent * (abs(speed) + speed * np.sign(bent)) * abs(bent))
                data.qfrc_applied[axis] -= values["stiffness"] * memory[axis]

        return pull


class StickyGround(OutOfCatalogueFamily):
    """A floor whose drag grows steadily in one direction."""

    name = "sticky_ground"
    scales = ("slope",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return friction per metre, and the direction in which it grows."""
        turn = float(rng.uniform(-np.pi, np.pi))
        ways = np.concatenate([path[::100, :2] for path in paths]) @ [np.cos(turn), np.sin(turn)]
        slope = log_uniform(rng, 40.0, 300.0)
        return {"slope": slope, "direction": turn, "from": float(ways.min())}

    def hook(self, model: Any, context: EpisodeContext, values: Values) -> Hook | None:
        """Apply a drag at the object's origin."""
        c, s = np.cos(values["direction"]), np.sin(values["direction"])

        def brake(data: mujoco.MjData) -> None:
            way = c * data.qpos[0] + s * data.qpos[1] - values["from"]
            drag = min(values["slope"] * max(way, 0.0), 1500.0)
            data.qfrc_applied[0] -= drag * data.qvel[0]
            data.qfrc_applied[1] -= drag * data.qvel[1]

        return brake


class MagneticLine(OutOfCatalogueFamily):
    """A line of the floor that attracts the object's origin."""

    name = "magnetic_line"
    scales = ("strength",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return a line across the paths."""
        turn = float(rng.uniform(-np.pi, np.pi))
        normal = np.array([np.cos(turn), np.sin(turn)])
        middle = np.mean([path[:, :2].mean(axis=0) for path in paths], axis=0)
        strength = log_uniform(rng, 15.0, 60.0)
        offset = float(middle @ normal + rng.uniform(-0.2, 0.2))
        return {"strength": strength, "direction": turn, "offset": offset}

    def hook(self, model: Any, context: EpisodeContext, values: Values) -> Hook | None:
        """Apply a force of −strength · s/(1 + s²)², with s the distance over 0.15 m."""
        c, s = np.cos(values["direction"]), np.sin(values["direction"])

        def pull(data: mujoco.MjData) -> None:
            off = (c * data.qpos[0] + s * data.qpos[1] - values["offset"]) / 0.15
            pulled = values["strength"] * off / (1.0 + off * off) ** 2
            data.qfrc_applied[0] -= pulled * c
            data.qfrc_applied[1] -= pulled * s

        return pull


class RateAndState(OutOfCatalogueFamily):
    """Rate-and-state friction at the object's origin (Dieterich): heals at rest, weakens when sliding."""

    name = "rate_and_state"
    scales = ("force",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return the friction of a fresh contact, the critical slip distance, and the healing rate."""
        return {
            "force": log_uniform(rng, 6.0, 25.0),
            "slip": float(rng.uniform(0.02, 0.1)),
            "evolution": float(rng.uniform(0.1, 0.25)),
        }

    def hook(self, model: Any, context: EpisodeContext, values: Values) -> Hook | None:
        """Apply the force; each episode begins after ten seconds at rest."""
        age, step = [10.0], model.opt.timestep

        def rub(data: mujoco.MjData) -> None:
            speed = float(np.hypot(data.qvel[0], data.qvel[1]))
            age[0] = max(age[0] + step * (1.0 - speed * age[0] / values["slip"]), 0.0)
            healed = values["evolution"] * np.log(1.0 + 0.1 * age[0] / values["slip"])
            drag = values["force"] * (1.0 + healed) / np.hypot(speed, 1e-3)
            data.qfrc_applied[0] -= drag * data.qvel[0]
            data.qfrc_applied[1] -= drag * data.qvel[1]

        return rub


class FadingFriction(OutOfCatalogueFamily):
    """Dry friction at the object's origin that falls with the distance slid in an episode."""

    name = "fading_friction"
    scales = ("force",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return the initial friction, and the distance over which it falls to 1/e."""
        force = log_uniform(rng, 10.0, 40.0)
        return {"force": force, "distance": float(rng.uniform(0.1, 0.4))}

    def hook(self, model: Any, context: EpisodeContext, values: Values) -> Hook | None:
        """Apply the force; the distance is reset in each episode."""
        slid, step = [0.0], model.opt.timestep

        def rub(data: mujoco.MjData) -> None:
            speed = float(np.hypot(data.qvel[0], data.qvel[1]))
            slid[0] += step * speed
            drag = values["force"] * np.exp(-slid[0] / values["distance"]) / np.hypot(speed, 1e-3)
            data.qfrc_applied[0] -= drag * data.qvel[0]
            data.qfrc_applied[1] -= drag * data.qvel[1]

        return rub


class Sail(OutOfCatalogueFamily):
    """A draught along one direction of the room whose force depends on the heading, with a torque."""

    name = "sail"
    scales = ("force",)

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return the largest force, the direction, and the lever arm."""
        return {
            "force": log_uniform(rng, 5.0, 20.0),
            "direction": float(rng.uniform(-np.pi, np.pi)),
            "lever": float(rng.uniform(0.05, 0.2)),
        }

    def hook(self, model: Any, context: EpisodeContext, values: Values) -> Hook | None:
        """Apply a force with the square of the sine between heading and draught, and its torque."""
        c, s = np.cos(values["direction"]), np.sin(values["direction"])

        def blow(data: mujoco.MjData) -> None:
            across = np.sin(values["direction"] - data.qpos[2])
            force = values["force"] * across * across
            data.qfrc_applied[0] += force * c
            data.qfrc_applied[1] += force * s
            data.qfrc_applied[2] -= force * values["lever"] * across

        return blow


MOTIONS: tuple[Family, ...] = (
    Magnet(),
    WarmingWheel(),
    Shaking(),
    RattlingLoad(),
    HystereticSpring(),
    StickyGround(),
    MagneticLine(),
    RateAndState(),
    FadingFriction(),
    Sail(),
)
