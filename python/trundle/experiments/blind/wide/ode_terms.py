"""Force terms of the ODE engine: wheels, friction, casters, floors, loads, cables, obstacles."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from trundle.experiments.blind.families.bodies import LOAD_DAMPING_RATIO
from trundle.experiments.blind.families.out_of_catalogue import remaining_mass, warming_factor
from trundle.experiments.blind.family import Context, HiddenEffect, Values
from trundle.experiments.blind.mujoco_world import SLIP_STIFFNESS_RATIO
from trundle.experiments.blind.outline import OutlineDistance
from trundle.experiments.blind.push import Kinematics, Wrench
from trundle.experiments.blind.scene import Scene, Wheel

__all__ = ["InertialProperties", "Term", "make_terms", "wheel_term"]

BRISTLE_LENGTH_M = 5e-4
"""Displacement over which dry friction builds up. Shorter ones need shorter steps."""
BRISTLE_DAMPING_TIME_S = 2e-4
"""Damping of the bristles over their stiffness."""
TYRE_RELAXATION_S = 5e-3
"""Relaxation time of a caster's tyre."""
OBSTACLE_STIFFNESS_N_PER_M = 3e4
"""Contact stiffness of an obstacle."""
OBSTACLE_FRICTION_SPEED_M_PER_S = 3e-3
"""Speed scale of the smoothed friction of an obstacle."""

Force: TypeAlias = Callable[[float, Kinematics], Wrench]
Act: TypeAlias = Callable[[float, Kinematics, list[float]], tuple[float, float, float, list[float]]]


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
        return math.prod((one(t) for one in self.factors), start=1.0)


@dataclass(frozen=True)
class Term:
    """A force and moment about the object's origin, world axes, with internal states if it has any.

    Attributes
    ----------
    act : callable
        Returns force, moment, and the derivative of the internal states.
    initial : callable
        Returns the internal states at contact from the initial pose.
    states : int
        Number of internal states.
    """

    act: Act
    initial: Callable[[Sequence[float]], list[float]] = lambda start: []
    states: int = 0


def stateless(force: Force) -> Term:
    """Return a term without internal states."""
    return Term(lambda t, at, z: (*force(t, at), []))


def bristles(count: int, act: Act) -> Term:
    """Return a term whose internal states are deflections, zero at contact."""
    return Term(act, lambda start: [0.0] * count, count)


def point_motion(at: Kinematics, x: float, y: float) -> tuple[float, float, float, float]:
    """Return lever arm and velocity of a point of the object, world axes."""
    rx, ry = at.c * x - at.s * y, at.s * x + at.c * y
    return rx, ry, at.vx - at.omega * ry, at.vy + at.omega * rx


def wheel_term(wheel: Wheel, trait: InertialProperties | None = None) -> Term:
    """Return a viscous wheel. With inertial properties, events change its friction."""
    changes = trait.wheel_factors if trait is not None else []

    def force(t: float, at: Kinematics) -> Wrench:
        rx, ry, vx, vy = point_motion(at, wheel.x, wheel.y)
        mu_x, mu_y = wheel.mu_x, wheel.mu_y
        for change in changes:
            more_x, more_y = change(t)
            mu_x, mu_y = mu_x * more_x, mu_y * more_y
        c, s = math.cos(at.theta + wheel.angle), math.sin(at.theta + wheel.angle)
        along, across = -mu_x * (c * vx + s * vy), -mu_y * (c * vy - s * vx)
        fx, fy = c * along - s * across, s * along + c * across
        return fx, fy, rx * fy - ry * fx

    return stateless(force)


def dahl_friction(x: float, y: float, load: float) -> Term:
    """Return dry friction at a point, as a planar bristle (Dahl 1968)."""
    stiffness = load / BRISTLE_LENGTH_M
    damping = BRISTLE_DAMPING_TIME_S * stiffness

    def act(t: float, at: Kinematics, z: list[float]) -> tuple[float, float, float, list[float]]:
        rx, ry, vx, vy = point_motion(at, x, y)
        slip = math.hypot(vx, vy) / BRISTLE_LENGTH_M
        zx, zy = vx - slip * z[0], vy - slip * z[1]
        fx, fy = -stiffness * z[0] - damping * zx, -stiffness * z[1] - damping * zy
        return fx, fy, rx * fy - ry * fx, [zx, zy]

    return bristles(2, act)


def coulomb(values: Values, context: Context, trait: InertialProperties) -> list[Term]:
    """Return dry friction at a point, or at all feet."""
    points = context.scene.shape.feet.tolist() if values["point"] is None else [values["point"]]
    return [dahl_friction(float(x), float(y), values["force"] / len(points)) for x, y in points]


def joint_friction(values: Values, context: Context, trait: InertialProperties) -> Term:
    """Return dry friction along the room's axes and of the rotation, each a bristle (Dahl 1968)."""
    arm = math.sqrt(trait.inertia / trait.mass)
    loads = [values[name] for name in ("force_x", "force_y", "torque")]
    lengths = (BRISTLE_LENGTH_M, BRISTLE_LENGTH_M, BRISTLE_LENGTH_M / arm)

    def act(t: float, at: Kinematics, z: list[float]) -> tuple[float, float, float, list[float]]:
        forces, rates = [], []
        for load, length, bent, speed in zip(loads, lengths, z, at[4:7], strict=True):
            rate = speed - abs(speed) / length * bent
            forces.append(-load / length * (bent + BRISTLE_DAMPING_TIME_S * rate))
            rates.append(rate)
        return forces[0], forces[1], forces[2], rates

    return bristles(3, act)


def caster_tyre(values: Values, context: Context, trait: InertialProperties) -> Term:
    """Return a trailing tyre that swivels, with a relaxation time. Its side force balances scrubbing."""
    (x, y), trail, side = values["point"], values["trail"], values["mu_side"]

    def act(t: float, at: Kinematics, z: list[float]) -> tuple[float, float, float, list[float]]:
        rx, ry, vx, vy = point_motion(at, x, y)
        c, s = math.cos(z[0]), math.sin(z[0])
        settled = (c * vy - s * vx) / (trail * (1.0 + 1.0 / SLIP_STIFFNESS_RATIO))
        # Side force from the balance of the massless arm: scrubbing torque over the trail.
        force = -side * trail * z[1]
        fx, fy = -s * force, c * force
        return fx, fy, rx * fy - ry * fx, [z[1], (settled - z[1]) / TYRE_RELAXATION_S]

    return Term(act, lambda start: [start[2] + values["first"][context.episode], 0.0], 2)


def sprung_load(values: Values, context: Context, trait: InertialProperties) -> Term:
    """Move part of the mass to a particle on two springs, and return their force."""
    (x, y), mass, turn = values["point"], values["mass"], 2 * math.pi * values["frequency"]
    left = 1.0 - mass / context.scene.mass
    trait.mass, trait.inertia = left * trait.mass, left * trait.inertia
    stiffness, damping = mass * turn**2, 2 * LOAD_DAMPING_RATIO * mass * turn

    def initial(start: Sequence[float]) -> list[float]:
        c, s = math.cos(start[2]), math.sin(start[2])
        return [start[0] + c * x - s * y, start[1] + s * x + c * y, 0.0, 0.0]

    def act(t: float, at: Kinematics, z: list[float]) -> tuple[float, float, float, list[float]]:
        rx, ry, _, _ = point_motion(at, x, y)
        lx, ly = z[0] - at.x, z[1] - at.y
        ux, uy = z[2] - at.vx + at.omega * ly, z[3] - at.vy - at.omega * lx
        fx, fy = stiffness * (lx - rx) + damping * ux, stiffness * (ly - ry) + damping * uy
        return fx, fy, lx * fy - ly * fx, [z[2], z[3], -fx / mass, -fy / mass]

    return Term(act, initial, 4)


def bouc_wen_spring(values: Values, context: Context, trait: InertialProperties) -> Term:
    """Return a hysteretic spring to the room (Bouc and Wen)."""
    stiffness, yields = values["stiffness"], values["yields"]

    def act(t: float, at: Kinematics, z: list[float]) -> tuple[float, float, float, list[float]]:
        rates = []
        for bent, speed in ((z[0] / yields, at.vx), (z[1] / yields, at.vy)):
            rates.append(speed - 0.5 * (abs(speed) * bent * abs(bent) + speed * bent * bent))
        return -stiffness * z[0], -stiffness * z[1], 0.0, rates

    return bristles(2, act)


def tether(values: Values, context: Context, trait: InertialProperties) -> Term:
    """Return a cable that is slack below its rest length."""
    (x, y), (ax, ay) = values["point"], values["anchor"]

    def force(t: float, at: Kinematics) -> Wrench:
        rx, ry, _, _ = point_motion(at, x, y)
        dx, dy = ax - at.x - rx, ay - at.y - ry
        length = math.hypot(dx, dy)
        pull = values["stiffness"] * max(length - values["rest_length"], 0.0) / max(length, 1e-9)
        fx, fy = pull * dx, pull * dy
        return fx, fy, rx * fy - ry * fx

    return stateless(force)


def obstacle(values: Values, context: Context, trait: InertialProperties) -> Term:
    """Return a round post as a spring with a dashpot."""
    outline = OutlineDistance(context.scene.shape)
    (px, py), radius, mu = values["place"], values["radius"], values["friction"]
    damping = 0.8 * math.sqrt(OBSTACLE_STIFFNESS_N_PER_M * context.scene.mass)

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
        side = mu * normal * slip / math.hypot(slip, OBSTACLE_FRICTION_SPEED_M_PER_S)
        fx, fy = -normal * nx + side * ny, -normal * ny - side * nx
        return fx, fy, rx * fy - ry * fx

    return stateless(force)


def patch(values: Values, context: Context, trait: InertialProperties) -> Term:
    """Return a carpet that drags every foot, or corner, on it."""
    feet = context.scene.friction_points.tolist()
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

    return stateless(force)


def slope(values: Values, context: Context, trait: InertialProperties) -> Term:
    """Return gravity's component along the floor, at the mass centre."""

    def force(t: float, at: Kinematics) -> Wrench:
        mass = trait.mass * trait.factor(t)
        rx, ry, _, _ = point_motion(at, trait.x, trait.y)
        fx, fy = mass * values["accel_x"], mass * values["accel_y"]
        return fx, fy, rx * fy - ry * fx

    return stateless(force)


def grain(values: Values, context: Context, trait: InertialProperties) -> Term:
    """Return a drag on the origin along one direction of the room."""
    c, s = math.cos(values["angle"]), math.sin(values["angle"])

    def force(t: float, at: Kinematics) -> Wrench:
        drag = -values["mu"] * (c * at.vx + s * at.vy)
        return drag * c, drag * s, 0.0

    return stateless(force)


def com_offset(values: Values, context: Context, trait: InertialProperties) -> None:
    """Move the mass centre."""
    trait.x, trait.y = trait.x + values["x"], trait.y + values["y"]


def mass_spread(values: Values, context: Context, trait: InertialProperties) -> None:
    """Scale the inertia about the mass centre."""
    trait.inertia *= math.exp(values["log_factor"])


def happened(values: Values, context: Context) -> Callable[[float], bool]:
    """Return a function that reports whether an event has happened at a time of an episode."""
    if context.episode != values["episode"]:
        return lambda t: context.episode > values["episode"]
    return lambda t: bool(t >= values["time"])


def mass_change(values: Values, context: Context, trait: InertialProperties) -> None:
    """Scale mass and inertia from the event on."""
    after, factor = happened(values, context), 1.0 + values["mass"] / context.scene.mass
    trait.factors.append(lambda t: factor if after(t) else 1.0)


def wheel_event(values: Values, context: Context, trait: InertialProperties) -> None:
    """Scale the wheel's friction from the event on."""
    after = happened(values, context)
    factors = (float(np.exp(values["log_x"])), float(np.exp(values["log_y"])))
    trait.wheel_factors.append(lambda t: factors if after(t) else (1.0, 1.0))


TERMS: dict[str, Callable[[Values, Context, InertialProperties], Term | list[Term] | None]] = {
    "axis_friction": joint_friction,
    "caster_swivel": caster_tyre,
    "com_offset": com_offset,
    "coulomb_friction": coulomb,
    "floor_grain": grain,
    "floor_patch": patch,
    "floor_slope": slope,
    "hysteretic_spring": bouc_wen_spring,
    "leaking_load": lambda v, context, trait: trait.factors.append(lambda t: remaining_mass(context, v, t)),
    "mass_change": mass_change,
    "mass_spread": mass_spread,
    "obstacle_contact": obstacle,
    "second_wheel": lambda values, context, trait: wheel_term(Wheel(**values)),
    "swinging_load": sprung_load,
    "tether": tether,
    "warming_wheel": lambda v, context, trait: trait.wheel_factors.append(
        lambda t: (warming_factor(v, t),) * 2
    ),
    "wheel_event": wheel_event,
}
"""Functions by family that return terms, or change the inertial properties."""


def make_terms(one: HiddenEffect, scene: Scene, episode: int, trait: InertialProperties) -> list[Term]:
    """Return the terms of a hidden effect, or change the inertial properties.

    Instrument effects add no force.
    """
    family, values, context = one.family, one.values, Context(scene, episode)
    law = family.force
    if law is not None:
        return [stateless(lambda t, at: law(context, values, t, at))]
    found = TERMS[family.name](values, context, trait) if family.name in TERMS else None
    return found if isinstance(found, list) else [found] if found is not None else []
