"""Force terms of the ODE engine: wheels, friction, casters, floors, loads, cables, obstacles."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from trundle.experiments.blind.family import HiddenEffect, Values
from trundle.experiments.blind.scene import Wheel
from trundle.experiments.wide.outline_distance import OutlineDistance
from trundle.experiments.wide.scene import WideScene

__all__ = ["InertialProperties", "Kinematics", "Term", "make_terms", "wheel_term"]

BRISTLE_LENGTH_M = 5e-4
"""Displacement over which dry friction builds up. Shorter ones need shorter steps."""
BRISTLE_DAMPING_TIME_S = 2e-4
"""Damping of the bristles over their stiffness."""
TYRE_RELAXATION_S = 5e-3
"""Relaxation time of a caster's tyre."""
SLIP_STIFFNESS_RATIO = 20.0
"""Resistance of a tyre to side slip over that of its scrubbing, as in the MuJoCo family."""
LOAD_DAMPING_RATIO = 0.03
"""Damping ratio of a swinging load, as in the MuJoCo family."""
OBSTACLE_STIFFNESS_N_PER_M = 3e4
"""Contact stiffness of an obstacle."""


class Kinematics(NamedTuple):
    """Pose and twist of the object's origin, world axes."""

    x: float
    y: float
    c: float
    s: float
    vx: float
    vy: float
    omega: float
    theta: float


@dataclass
class InertialProperties:
    """Mass, inertia about the mass centre, mass centre in the object's frame, and changes over time."""

    mass: float
    inertia: float
    x: float
    y: float
    factors: list[Callable[[float], float]] = field(default_factory=list)
    wheel_factors: list[Callable[[float], tuple[float, float]]] = field(default_factory=list)

    def factor(self, t: float) -> float:
        """Return the factor of mass and inertia at a time."""
        found = 1.0
        for one in self.factors:
            found *= one(t)
        return found


Wrench = tuple[float, float, float]


class Term:
    """A force and moment about the object's origin, world axes, with internal states if it has any."""

    states = 0

    def __init__(self, force: Callable[[float, Kinematics], Wrench] | None = None) -> None:
        self.force = force

    def initial(self, start: Sequence[float]) -> list[float]:
        """Return the internal states at contact."""
        return []

    def act(self, t: float, at: Kinematics, z: list[float]) -> tuple[float, float, float, list[float]]:
        """Return force, moment, and the derivative of the internal states."""
        assert self.force is not None
        return *self.force(t, at), []


def point_motion(at: Kinematics, x: float, y: float) -> tuple[float, float, float, float]:
    """Return lever arm and velocity of a point of the object, world axes."""
    rx, ry = at.c * x - at.s * y, at.s * x + at.c * y
    return rx, ry, at.vx - at.omega * ry, at.vy + at.omega * rx


def wheel_term(wheel: Wheel, trait: InertialProperties | None = None) -> Term:
    """Return a viscous wheel. With inertial properties, events change its friction."""

    def force(t: float, at: Kinematics) -> Wrench:
        rx, ry, vx, vy = point_motion(at, wheel.x, wheel.y)
        mu_x, mu_y = wheel.mu_x, wheel.mu_y
        for change in trait.wheel_factors if trait is not None else ():
            more_x, more_y = change(t)
            mu_x, mu_y = mu_x * more_x, mu_y * more_y
        c, s = math.cos(at.theta + wheel.angle), math.sin(at.theta + wheel.angle)
        along, across = -mu_x * (c * vx + s * vy), -mu_y * (c * vy - s * vx)
        fx, fy = c * along - s * across, s * along + c * across
        return fx, fy, rx * fy - ry * fx

    return Term(force)


class DahlFriction(Term):
    """Dry friction at a point, as a planar bristle (Dahl 1968)."""

    states = 2

    def __init__(self, x: float, y: float, load: float) -> None:
        super().__init__()
        self.x, self.y, self.load = x, y, load

    def initial(self, start: Sequence[float]) -> list[float]:
        """Return zero deflection."""
        return [0.0, 0.0]

    def act(self, t: float, at: Kinematics, z: list[float]) -> tuple[float, float, float, list[float]]:
        """Return the bristle's force, and the rate of its deflection."""
        rx, ry, vx, vy = point_motion(at, self.x, self.y)
        slip = math.hypot(vx, vy) / BRISTLE_LENGTH_M
        zx, zy = vx - slip * z[0], vy - slip * z[1]
        stiffness = self.load / BRISTLE_LENGTH_M
        damping = BRISTLE_DAMPING_TIME_S * stiffness
        fx, fy = -stiffness * z[0] - damping * zx, -stiffness * z[1] - damping * zy
        return fx, fy, rx * fy - ry * fx, [zx, zy]


class JointFriction(Term):
    """Dry friction of two slides and a hinge, each a bristle (Dahl 1968)."""

    states = 3

    def __init__(self, forces: Sequence[float], torque: float, arm: float) -> None:
        super().__init__()
        self.loads = (*forces, torque)
        self.lengths = (BRISTLE_LENGTH_M, BRISTLE_LENGTH_M, BRISTLE_LENGTH_M / arm)

    def initial(self, start: Sequence[float]) -> list[float]:
        """Return zero deflections."""
        return [0.0, 0.0, 0.0]

    def act(self, t: float, at: Kinematics, z: list[float]) -> tuple[float, float, float, list[float]]:
        """Return the bristles' forces, and the rates of their deflections."""
        forces, rates = [], []
        for load, length, bent, speed in zip(self.loads, self.lengths, z, at[4:7], strict=True):
            rate = speed - abs(speed) / length * bent
            forces.append(-load / length * (bent + BRISTLE_DAMPING_TIME_S * rate))
            rates.append(rate)
        fx, fy, torque = forces
        return fx, fy, torque, rates


class CasterTyre(Term):
    """A trailing tyre that swivels. Its side force turns the arm against scrubbing, with a relaxation."""

    states = 2

    def __init__(self, point: Sequence[float], trail: float, side: float, first: float) -> None:
        super().__init__()
        (self.x, self.y), self.trail, self.side, self.first = point, trail, side, first

    def initial(self, start: Sequence[float]) -> list[float]:
        """Return the drawn direction, and zero rate."""
        return [start[2] + self.first, 0.0]

    def act(self, t: float, at: Kinematics, z: list[float]) -> tuple[float, float, float, list[float]]:
        """Return the side force; the tyre slips by the motion that the arm does not follow."""
        rx, ry, vx, vy = point_motion(at, self.x, self.y)
        c, s = math.cos(z[0]), math.sin(z[0])
        aside = c * vy - s * vx
        settled = aside / (self.trail * (1.0 + 1.0 / SLIP_STIFFNESS_RATIO))
        # Side force from the balance of the massless arm: scrubbing torque over the trail.
        force = -self.side * self.trail * z[1]
        fx, fy = -s * force, c * force
        return fx, fy, rx * fy - ry * fx, [z[1], (settled - z[1]) / TYRE_RELAXATION_S]


class SprungLoad(Term):
    """A load on two springs, as a particle."""

    states = 4

    def __init__(self, point: Sequence[float], mass: float, frequency: float) -> None:
        super().__init__()
        (self.x, self.y), self.mass, self.turn = point, mass, 2 * math.pi * frequency

    def initial(self, start: Sequence[float]) -> list[float]:
        """Return the load's rest position, and zero velocity."""
        c, s = math.cos(start[2]), math.sin(start[2])
        return [start[0] + c * self.x - s * self.y, start[1] + s * self.x + c * self.y, 0.0, 0.0]

    def act(self, t: float, at: Kinematics, z: list[float]) -> tuple[float, float, float, list[float]]:
        """Return the spring force at the load's position."""
        rx, ry, _, _ = point_motion(at, self.x, self.y)
        lx, ly = z[0] - at.x, z[1] - at.y
        ux, uy = z[2] - at.vx + at.omega * ly, z[3] - at.vy - at.omega * lx
        k, d = self.mass * self.turn**2, 2 * LOAD_DAMPING_RATIO * self.mass * self.turn
        fx, fy = k * (lx - rx) + d * ux, k * (ly - ry) + d * uy
        return fx, fy, lx * fy - ly * fx, [z[2], z[3], -fx / self.mass, -fy / self.mass]


class BoucWenSpring(Term):
    """A hysteretic spring to the room (Bouc and Wen)."""

    states = 2

    def __init__(self, stiffness: float, yields: float) -> None:
        super().__init__()
        self.stiffness, self.yields = stiffness, yields

    def initial(self, start: Sequence[float]) -> list[float]:
        """Return zero deflection."""
        return [0.0, 0.0]

    def act(self, t: float, at: Kinematics, z: list[float]) -> tuple[float, float, float, list[float]]:
        """Return the spring force, and the rate of the deflection with yielding."""
        rates = []
        for bent, speed in ((z[0] / self.yields, at.vx), (z[1] / self.yields, at.vy)):
            rates.append(speed - 0.5 * (abs(speed) * bent * abs(bent) + speed * bent * bent))
        return -self.stiffness * z[0], -self.stiffness * z[1], 0.0, rates


def tether(values: Values) -> Term:
    """Return a cable that is slack below its rest length."""
    (x, y), (ax, ay) = values["point"], values["anchor"]

    def force(t: float, at: Kinematics) -> Wrench:
        rx, ry, _, _ = point_motion(at, x, y)
        dx, dy = ax - at.x - rx, ay - at.y - ry
        length = math.hypot(dx, dy)
        pull = values["stiffness"] * max(length - values["rest_length"], 0.0) / max(length, 1e-9)
        fx, fy = pull * dx, pull * dy
        return fx, fy, rx * fy - ry * fx

    return Term(force)


def obstacle(values: Values, scene: WideScene) -> Term:
    """Return a round post as a spring with a dashpot."""
    outline = OutlineDistance(scene.shape)
    (px, py), radius, mu = values["place"], values["radius"], values["friction"]
    damping = 0.8 * math.sqrt(OBSTACLE_STIFFNESS_N_PER_M * scene.mass)

    def force(t: float, at: Kinematics) -> Wrench:
        dx, dy = px - at.x, py - at.y
        inside, nx, ny = outline.depth(at.c * dx + at.s * dy, at.c * dy - at.s * dx)
        depth = inside + radius
        if depth <= 0.0 or values["there"] == 0.0:
            return 0.0, 0.0, 0.0
        nx, ny = at.c * nx - at.s * ny, at.s * nx + at.c * ny
        rx, ry = dx + inside * nx, dy + inside * ny
        vx, vy = at.vx - at.omega * ry, at.vy + at.omega * rx
        normal = max(OBSTACLE_STIFFNESS_N_PER_M * depth + damping * (vx * nx + vy * ny), 0.0)
        slip = vy * nx - vx * ny
        side = mu * normal * slip / math.hypot(slip, 3e-3)
        fx, fy = -normal * nx + side * ny, -normal * ny - side * nx
        return fx, fy, rx * fy - ry * fx

    return Term(force)


def patch(values: Values, scene: WideScene) -> Term:
    """Return a carpet that drags every foot, or corner, on it."""
    feet = [(float(x), float(y)) for x, y in scene.friction_points]
    c, s = math.cos(values["angle"]), math.sin(values["angle"])

    def force(t: float, at: Kinematics) -> Wrench:
        fx = fy = torque = 0.0
        for x, y in feet:
            rx, ry, vx, vy = point_motion(at, x, y)
            dx, dy = at.x + rx - values["x"], at.y + ry - values["y"]
            if abs(c * dx + s * dy) < values["half_length"] and abs(c * dy - s * dx) < values["half_width"]:
                gx, gy = -values["mu"] * vx, -values["mu"] * vy
                fx, fy, torque = fx + gx, fy + gy, torque + rx * gy - ry * gx
        return fx, fy, torque

    return Term(force)


def make_terms(one: HiddenEffect, scene: WideScene, episode: int, trait: InertialProperties) -> list[Term]:
    """Return the terms of a hidden effect, or change the inertial properties."""
    name, values = one.family.name, one.values
    own: Any = getattr(one.family, "terms", None)
    if own is not None:
        return list(own(scene, episode, values, trait))
    make = TERM_FACTORIES.get(name)
    return [] if make is None else make(values, scene, episode, trait)


def coulomb(values: Values, scene: WideScene, episode: int, trait: InertialProperties) -> list[Term]:
    """Return dry friction at a point, or at all feet."""
    points = scene.shape.feet.tolist() if values["point"] is None else [values["point"]]
    return [DahlFriction(float(x), float(y), values["force"] / len(points)) for x, y in points]


def slope(values: Values, scene: WideScene, episode: int, trait: InertialProperties) -> list[Term]:
    """Return gravity's component along the floor, at the mass centre."""

    def force(t: float, at: Kinematics) -> Wrench:
        mass = trait.mass * trait.factor(t)
        rx, ry, _, _ = point_motion(at, trait.x, trait.y)
        fx, fy = mass * values["accel_x"], mass * values["accel_y"]
        return fx, fy, rx * fy - ry * fx

    return [Term(force)]


def grain(values: Values, scene: WideScene, episode: int, trait: InertialProperties) -> list[Term]:
    """Return a drag on the origin along one direction of the room."""
    c, s = math.cos(values["angle"]), math.sin(values["angle"])

    def force(t: float, at: Kinematics) -> Wrench:
        drag = -values["mu"] * (c * at.vx + s * at.vy)
        return drag * c, drag * s, 0.0

    return [Term(force)]


def slides(values: Values, scene: WideScene, episode: int, trait: InertialProperties) -> list[Term]:
    """Return dry friction along the room's axes and of the rotation."""
    arm = math.sqrt(trait.inertia / trait.mass)
    return [JointFriction((values["force_x"], values["force_y"]), values["torque"], arm)]


def thinning(values: Values, scene: WideScene, episode: int, trait: InertialProperties) -> list[Term]:
    """Return a drag with the square root of the speed of the object's origin and of a ring about it."""
    ring = values["ring"]

    def force(t: float, at: Kinematics) -> Wrench:
        spin = ring * at.omega
        drag = values["drag"] / (at.vx * at.vx + at.vy * at.vy + spin * spin + 1e-4) ** 0.25
        return -drag * at.vx, -drag * at.vy, -drag * ring * spin

    return [Term(force)]


def com_offset(values: Values, scene: WideScene, episode: int, trait: InertialProperties) -> list[Term]:
    """Move the mass centre."""
    trait.x, trait.y = trait.x + values["x"], trait.y + values["y"]
    return []


def event_predicate(values: Values, episode: int) -> Callable[[float], bool]:
    """Return a function that reports whether an event has happened at a time of an episode."""
    if episode != values["episode"]:
        return lambda t: episode > values["episode"]
    return lambda t: t >= values["time"]


def mass_change(values: Values, scene: WideScene, episode: int, trait: InertialProperties) -> list[Term]:
    """Scale mass and inertia from the event on."""
    happened, factor = event_predicate(values, episode), 1.0 + values["mass"] / scene.mass
    trait.factors.append(lambda t: factor if happened(t) else 1.0)
    return []


def wheel_event(values: Values, scene: WideScene, episode: int, trait: InertialProperties) -> list[Term]:
    """Scale the wheel's friction from the event on."""
    happened = event_predicate(values, episode)
    factors = (float(np.exp(values["log_x"])), float(np.exp(values["log_y"])))
    trait.wheel_factors.append(lambda t: factors if happened(t) else (1.0, 1.0))
    return []


def swinging(values: Values, scene: WideScene, episode: int, trait: InertialProperties) -> list[Term]:
    """Move the load's mass from the object to a sprung load."""
    left = 1.0 - values["mass"] / scene.mass
    trait.mass, trait.inertia = left * trait.mass, left * trait.inertia
    return [SprungLoad(values["point"], values["mass"], values["frequency"])]


TermFactory = Callable[[Values, WideScene, int, InertialProperties], list[Term]]
TERM_FACTORIES: dict[str, TermFactory] = {
    "coulomb_friction": coulomb,
    "caster_swivel": lambda v, s, k, m: [CasterTyre(v["point"], v["trail"], v["mu_side"], v["first"][k])],
    "second_wheel": lambda v, s, k, m: [wheel_term(Wheel(**v))],
    "axis_friction": slides,
    "thinning_drag": thinning,
    "com_offset": com_offset,
    "floor_slope": slope,
    "floor_patch": lambda v, s, k, m: [patch(v, s)],
    "floor_grain": grain,
    "wheel_event": wheel_event,
    "mass_change": mass_change,
    "obstacle_contact": lambda v, s, k, m: [obstacle(v, s)],
    "tether": lambda v, s, k, m: [tether(v)],
    "swinging_load": swinging,
    "hysteretic_spring": lambda v, s, k, m: [BoucWenSpring(v["stiffness"], v["yields"])],
}
"""By the family's name. Instrument effects add no force."""
