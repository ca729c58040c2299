"""Effects of the object's parts: wheels, a caster, mass centre, changes of mass, and a swinging load."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from trundle.experiments.blind import mujoco_world as world
from trundle.experiments.blind.family import (
    UNDER_OBJECT,
    Context,
    Family,
    Hook,
    Values,
    by_name,
    draws,
    log,
    uniform,
)
from trundle.experiments.blind.push import CONTACT_TIME_S
from trundle.experiments.blind.scene import Scene, Wheel, draw_training_episode, draw_wheel
from trundle.experiments.sampling import Floats

__all__ = ["BODIES", "LOAD_DAMPING_RATIO"]

LOAD_DAMPING_RATIO = 0.03
"""Damping ratio of a swinging load."""
MIN_BODY_MASS_KG = 1e-4
"""MuJoCo requires a mass of moving bodies."""
EVENT_MARGIN_S = 1.0
"""Smallest time between an event and contact, or the end of its episode."""


def draw_event(rng: np.random.Generator, scene: Scene) -> Values:
    """Return a time in a training episode."""
    episode, begin = draw_training_episode(rng, scene), CONTACT_TIME_S + EVENT_MARGIN_S
    end = max(begin, scene.seconds[episode] - EVENT_MARGIN_S)
    return {"episode": episode, "time": float(rng.uniform(begin, end))}


def build_caster(context: Context, values: Values) -> None:
    """Add a caster with its first direction of the episode."""
    first = values["first"][context.episode]
    world.add_caster(
        context.spec, context.table, "caster", values["point"], first, values["trail"], values["mu_side"]
    )


def caster_parameters(scene: Scene, values: Values) -> Values:
    """Return the equivalent friction at the pivot, corrected for the tyre's slip."""
    slip = 1.0 + 1.0 / world.SLIP_STIFFNESS_RATIO
    return {"trail": values["trail"] * slip, "mu_side": values["mu_side"] / slip}


def extend_caster(values: Values, rng: np.random.Generator) -> Values:
    """Add a random initial direction of the arm."""
    return {**values, "first": [*values["first"], float(rng.uniform(-np.pi, np.pi))]}


def whole_damping(scene: Scene, values: Values) -> Floats:
    """Return the total damping matrix of both wheels about the object's origin."""
    return scene.wheel.damping() + Wheel(**values).damping()


def spin_law(scene: Scene, values: Values) -> list[Values]:
    """Return the rotational damping that one equivalent wheel does not explain."""
    whole = whole_damping(scene, values)
    lever = whole[:2, 2]
    spin = whole[2, 2] - lever @ np.linalg.solve(whole[:2, :2], lever)
    return [{"kind": "spin_drag", "spin": max(float(spin), 1e-3)}]


def draw_wheel_event(rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
    """Return a training episode, a time, and the factors of a wheel that locks or unlocks."""
    locks = rng.uniform(np.log(2.5), np.log(12.0)) * (1.0 if rng.random() < 0.5 else -1.0)
    event = draw_event(rng, scene)
    return {**event, "log_x": float(locks), "log_y": float(locks * rng.uniform(0.3, 1.0))}


def hook_wheel_event(model: Any, context: Context, values: Values) -> Hook | None:
    """Change the wheel's actuators from the event on, permanently."""
    wheel, episode = context.scene.wheel, context.episode
    changed = (wheel.mu_x * np.exp(values["log_x"]), wheel.mu_y * np.exp(values["log_y"]))
    if episode > values["episode"]:
        world.set_wheel(model, "wheel", *changed)
    if episode != values["episode"]:
        return None
    return lambda data: world.set_wheel(model, "wheel", *changed) if data.time >= values["time"] else None


def wheel_factors(scene: Scene, values: Values) -> Values:
    """Return the factors of the wheel's friction."""
    return {f"factor_{axis}": float(np.exp(values[f"log_{axis}"])) for axis in "xy"}


def draw_com_offset(rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
    """Return an offset of the mass centre of 5 cm to 25 cm."""
    size, turn = rng.uniform(0.05, 0.25), rng.uniform(-np.pi, np.pi)
    return {"x": float(size * np.cos(turn)), "y": float(size * np.sin(turn))}


def set_inertia(context: Context, offset: tuple[float, float], factor: float) -> None:
    """Move the mass centre of the object, and scale the inertia about it."""
    body, table = context.spec.compile().body("table"), context.table
    flat = np.empty(9)
    mujoco.mju_quat2Mat(flat, body.iquat)
    frame = flat.reshape(3, 3)
    spin = factor * float((frame @ np.diag(body.inertia) @ frame.T)[2, 2])
    x, y, z = body.ipos
    table.explicitinertial, table.mass = True, float(body.mass[0])
    table.ipos, table.iquat = [x + offset[0], y + offset[1], z], [1.0, 0.0, 0.0, 0.0]
    table.inertia = [spin, spin, spin]


def mass_centre(scene: Scene, values: Values) -> list[float]:
    """Return the mass centre in the object's frame."""
    return [float(c + values[axis]) for c, axis in zip(scene.shape.centroid, "xy", strict=True)]


def draw_mass_spread(rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
    """Return the logarithm of a factor of the inertia: mass in the middle, or at the edge."""
    inwards = rng.random() < 0.5
    limits = (np.log(0.4), np.log(0.75)) if inwards else (np.log(1.35), np.log(2.5))
    return {"log_factor": float(rng.uniform(*limits))}


def draw_mass_change(rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
    """Return a training episode, a time, and the mass that is added or removed."""
    share = rng.uniform(0.25, 1.0) if rng.random() < 0.5 else -rng.uniform(0.2, 0.5)
    return {**draw_event(rng, scene), "mass": float(share * scene.mass)}


def hook_mass_change(model: Any, context: Context, values: Values) -> Hook | None:
    """Scale the object's mass and inertia from the event on, permanently."""
    factor = 1.0 + values["mass"] / context.scene.mass
    body, done = model.body("table").id, [False]

    def change() -> None:
        if not done[0]:
            model.body_mass[body] *= factor
            model.body_inertia[body] *= factor
            done[0] = True

    if context.episode > values["episode"]:
        change()
    if context.episode != values["episode"]:
        return None
    return lambda data: change() if data.time >= values["time"] else None


def move_mass(context: Context, mass: float) -> float:
    """Remove a mass from the object's geometry, and return it, at least MuJoCo's smallest mass."""
    mass = max(mass, MIN_BODY_MASS_KG)
    for geom in context.table.geoms:
        geom.mass *= 1.0 - mass / context.scene.mass
    return mass


def build_swinging_load(context: Context, values: Values) -> None:
    """Move part of the mass to a separate body on two springs."""
    mass, omega = move_mass(context, values["mass"]), 2 * np.pi * values["frequency"]
    load = world.add_point_mass(context.table, "load", values["point"], mass)
    for joint in world.add_slides(load, "load "):
        joint.stiffness = [mass * omega**2, 0.0, 0.0]
        joint.damping = [2 * LOAD_DAMPING_RATIO * mass * omega, 0.0, 0.0]


BODIES = by_name(
    Family(
        "caster_swivel",
        draws(
            point=UNDER_OBJECT,
            trail=uniform(0.03, 0.12),
            mu_side=log(30.0, 250.0),
            # Initial direction of the arm in each episode, object frame.
            first=lambda rng, scene, paths: rng.uniform(-np.pi, np.pi, len(scene.pushes)).tolist(),
        ),
        ("mu_side",),
        extend=extend_caster,
        build=build_caster,
        parameters=caster_parameters,
    ),
    Family(
        "second_wheel",
        lambda rng, scene, paths: dict(vars(draw_wheel(rng, scene.shape))),
        ("mu_x", "mu_y"),
        build=lambda context, v: world.add_wheel(context.spec, context.table, "second wheel", Wheel(**v)),
        parameters=lambda scene, v: {"damping": whole_damping(scene, v).tolist()},
        laws=spin_law,
    ),
    Family(
        "com_offset",
        draw_com_offset,
        ("x", "y"),
        build=lambda context, v: set_inertia(context, (v["x"], v["y"]), 1.0),
        parameters=lambda scene, v: dict(zip(("com_x", "com_y"), mass_centre(scene, v), strict=True)),
        where=lambda scene, v: {"body_point": mass_centre(scene, v)},
    ),
    Family(
        "mass_spread",
        draw_mass_spread,
        ("log_factor",),
        build=lambda context, v: set_inertia(context, (0.0, 0.0), math.exp(v["log_factor"])),
        parameters=lambda scene, v: {"inertia_factor": math.exp(v["log_factor"])},
    ),
    Family(
        "wheel_event",
        draw_wheel_event,
        ("log_x", "log_y"),
        hook=hook_wheel_event,
        parameters=wheel_factors,
    ),
    Family(
        "mass_change",
        draw_mass_change,
        ("mass",),
        hook=hook_mass_change,
    ),
    Family(
        "swinging_load",
        draws(
            point=UNDER_OBJECT,
            mass=lambda rng, scene, paths: float(rng.uniform(0.15, 0.5) * scene.mass),
            frequency=log(0.5, 3.0),
        ),
        ("mass",),
        build=build_swinging_load,
        fixed={"damping_ratio": LOAD_DAMPING_RATIO},
    ),
)
