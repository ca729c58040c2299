"""Physics of the object or the floor without a law in the catalogue."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import mujoco
import numpy as np

from trundle.experiments.blind import mujoco_world as world
from trundle.experiments.blind.families.bodies import move_mass
from trundle.experiments.blind.family import (
    ANGLE,
    Context,
    Draw,
    Family,
    Hook,
    Values,
    by_name,
    draws,
    log,
    uniform,
)
from trundle.experiments.blind.push import CONTACT_TIME_S, Kinematics, Wrench
from trundle.experiments.blind.scene import Scene
from trundle.experiments.sampling import Floats, log_uniform

__all__ = ["FORCES", "STICKY_GROUND_MOST", "remaining_mass", "sticky_force", "warming_factor"]

MAGNET_REACH_M, LINE_REACH_M = 0.25, 0.15
GUST_WAVES = 8
STICKY_GROUND_MOST = 1500.0
"""Largest drag of the sticky ground, N·s/m."""
REST_BEFORE_EPISODE_S = 10.0
"""Age of a contact at the start of an episode."""
MIN_SLIDING_SPEED_M_PER_S = 1e-3
"""Speed below which dry friction is smoothed."""


def mean_place(paths: Sequence[Floats]) -> Floats:
    """Return the mean position of the object's origin."""
    return np.asarray(np.mean([path[:, :2].mean(axis=0) for path in paths], axis=0))


DRAW_PLACE: Draw = lambda rng, scene, paths: (mean_place(paths) + rng.uniform(-0.3, 0.3, 2)).tolist()  # noqa: E731


def magnet_force(context: Context, values: Values, t: float, at: Kinematics) -> Wrench:
    """Attract the object's origin to a point of the floor: strength · r d/(d² + r²)."""
    (x, y), reach = values["place"], MAGNET_REACH_M
    dx, dy = x - at.x, y - at.y
    pulled = values["strength"] * reach / (dx * dx + dy * dy + reach * reach)
    return pulled * dx, pulled * dy, 0.0


def warming_factor(values: Values, t: float) -> float:
    """Return the factor of the friction of a wheel whose grease warms up in each episode."""
    return 1.0 + float(values["excess"]) * math.exp(-(t - CONTACT_TIME_S) / values["seconds"])


def hook_warming_wheel(model: Any, context: Context, values: Values) -> Hook:
    """Let the friction fall to that of the warm wheel."""
    wheel = context.scene.wheel

    def warm(data: mujoco.MjData) -> None:
        factor = 1.0 + values["excess"] * np.exp(-(data.time - CONTACT_TIME_S) / values["seconds"])
        world.set_wheel(model, "wheel", wheel.mu_x * factor, wheel.mu_y * factor)

    return warm


def shaking_force(context: Context, values: Values, t: float, at: Kinematics) -> Wrench:
    """Shake the object along one direction of the room: a sine of the time since contact."""
    turn = 2 * math.pi * values["frequency"] * (t - CONTACT_TIME_S) + values["phase"]
    force = values["force"] * math.sin(turn)
    return force * math.cos(values["direction"]), force * math.sin(values["direction"]), 0.0


def build_rattling_load(context: Context, values: Values) -> None:
    """Move part of the mass to a drawer that slides freely and hits its ends, MuJoCo's joint limits."""
    mass = move_mass(context, values["mass"])
    drawer = world.add_point_mass(context.table, "drawer", context.scene.shape.centroid.tolist(), mass)
    joint = drawer.add_joint(name="drawer", type=mujoco.mjtJoint.mjJNT_SLIDE)
    joint.axis = [np.cos(values["direction"]), np.sin(values["direction"]), 0.0]
    joint.limited, joint.range = True, [-values["range"], values["range"]]


def hook_hysteretic_spring(model: Any, context: Context, values: Values) -> Hook:
    """Apply a hysteretic spring to the room (Bouc and Wen) at the origin; reset in each episode."""
    memory, step, limit = [0.0, 0.0], model.opt.timestep, values["yields"]

    def pull(data: mujoco.MjData) -> None:
        for axis in (0, 1):
            speed, bent = data.qvel[axis].item(), memory[axis] / limit
            memory[axis] += step * (speed - 0.5 * bent * (abs(speed) + speed * np.sign(bent)) * abs(bent))
            data.qfrc_applied[axis] -= values["stiffness"] * memory[axis]

    return pull


def draw_sticky_ground(rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
    """Return friction per metre, and the direction in which it grows."""
    turn = float(rng.uniform(-np.pi, np.pi))
    ways = np.concatenate([path[::100, :2] for path in paths]) @ [np.cos(turn), np.sin(turn)]
    return {"slope": log_uniform(rng, 40.0, 300.0), "direction": turn, "from": float(ways.min())}


def sticky_force(most: float) -> Callable[[Context, Values, float, Kinematics], Wrench]:
    """Return a drag on the origin that grows steadily in one direction, up to a largest drag."""

    def force(context: Context, values: Values, t: float, at: Kinematics) -> Wrench:
        way = math.cos(values["direction"]) * at.x + math.sin(values["direction"]) * at.y - values["from"]
        drag = min(values["slope"] * max(way, 0.0), most)
        return -drag * at.vx, -drag * at.vy, 0.0

    return force


def draw_magnetic_line(rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
    """Return a line across the paths."""
    turn = float(rng.uniform(-np.pi, np.pi))
    normal = np.array([np.cos(turn), np.sin(turn)])
    strength = log_uniform(rng, 15.0, 60.0)
    offset = float(mean_place(paths) @ normal + rng.uniform(-0.2, 0.2))
    return {"strength": strength, "direction": turn, "offset": offset}


def line_force(context: Context, values: Values, t: float, at: Kinematics) -> Wrench:
    """Attract the origin to a line: −strength · s/(1 + s²)², with s the distance over the reach."""
    c, s = math.cos(values["direction"]), math.sin(values["direction"])
    off = (c * at.x + s * at.y - values["offset"]) / LINE_REACH_M
    pulled = values["strength"] * off / (1.0 + off * off) ** 2
    return -pulled * c, -pulled * s, 0.0


def hook_sliding(model: Any, context: Context, values: Values) -> Hook:
    """Apply dry friction at the object's origin that depends on a state, which each episode resets.

    Rate-and-state friction (Dieterich) heals at rest and weakens when sliding; its state is the age of the
    contact. Fading friction falls with the distance slid.
    """
    heals, step = "evolution" in values, model.opt.timestep
    state = [REST_BEFORE_EPISODE_S if heals else 0.0]

    def rub(data: mujoco.MjData) -> None:
        speed = float(np.hypot(data.qvel[0], data.qvel[1]))
        if heals:
            state[0] = max(state[0] + step * (1.0 - speed * state[0] / values["slip"]), 0.0)
            factor = 1.0 + values["evolution"] * np.log(1.0 + 0.1 * state[0] / values["slip"])
        else:
            state[0] += step * speed
            factor = np.exp(-state[0] / values["distance"])
        drag = values["force"] * factor / np.hypot(speed, MIN_SLIDING_SPEED_M_PER_S)
        data.qfrc_applied[0] -= drag * data.qvel[0]
        data.qfrc_applied[1] -= drag * data.qvel[1]

    return rub


def sail_force(context: Context, values: Values, t: float, at: Kinematics) -> Wrench:
    """Apply a draught with the square of the sine between heading and draught, and its torque."""
    across = math.sin(values["direction"] - at.theta)
    force = values["force"] * across * across
    c, s = math.cos(values["direction"]), math.sin(values["direction"])
    return force * c, force * s, -force * values["lever"] * across


def draw_lift(rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
    """Return N·s/m, of either sign."""
    size = log_uniform(rng, 20.0, 120.0) * math.sqrt(scene.mass / 20.0)
    return {"lift": size * float(rng.choice([-1.0, 1.0]))}


def lift_force(context: Context, values: Values, t: float, at: Kinematics) -> Wrench:
    """Apply a force to the left of the velocity. No dissipative damping matrix has such a part."""
    return -values["lift"] * at.vy, values["lift"] * at.vx, 0.0


def draw_gusts(rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
    """Return the size of an aperiodic wind, its frequencies, and phases by episode and axis."""
    return {
        "force": log_uniform(rng, 3.0, 15.0),
        "frequency": rng.uniform(0.05, 1.0, GUST_WAVES).tolist(),
        "phase": rng.uniform(-np.pi, np.pi, (len(scene.pushes), 2, GUST_WAVES)).tolist(),
    }


def gust_force(context: Context, values: Values, t: float, at: Kinematics) -> Wrench:
    """Return the wind at a time: a sum of sines."""
    size = values["force"] * math.sqrt(2.0 / GUST_WAVES)
    x, y = (
        size
        * sum(math.sin(2 * math.pi * f * t + p) for f, p in zip(values["frequency"], phases, strict=True))
        for phases in values["phase"][context.episode]
    )
    return x, y, 0.0


def draw_waves(rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
    """Return the largest force of a wavy floor, the wave vectors, and phases."""
    lengths, turns = rng.uniform(0.25, 0.7, 3), rng.uniform(-np.pi, np.pi, 3)
    vectors = 2 * np.pi / lengths[:, None] * np.column_stack([np.cos(turns), np.sin(turns)])
    force = log_uniform(rng, 4.0, 25.0)
    return {"force": force, "vectors": vectors.tolist(), "phases": rng.uniform(-np.pi, np.pi, 3).tolist()}


def wave_force(context: Context, values: Values, t: float, at: Kinematics) -> Wrench:
    """Return minus the slope of the surface at the object's origin times a weight."""
    fx = fy = 0.0
    for (kx, ky), phase in zip(values["vectors"], values["phases"], strict=True):
        size = values["force"] * math.cos(kx * at.x + ky * at.y + phase) / math.hypot(kx, ky) / 1.7
        fx, fy = fx - size * kx, fy - size * ky
    return fx, fy, 0.0


def remaining_mass(context: Context, values: Values, t: float) -> float:
    """Return the share of the mass that has not leaked. It is refilled before each episode."""
    seconds = float(values["pace"]) * (float(context.scene.seconds[context.episode]) - CONTACT_TIME_S)
    return 1.0 - float(values["share"]) * (1.0 - math.exp(-max(t - CONTACT_TIME_S, 0.0) / seconds))


def hook_leaking_load(model: Any, context: Context, values: Values) -> Hook:
    """Scale mass and inertia. The lost mass keeps its velocity."""
    body = model.body("table").id
    mass, inertia = float(model.body_mass[body]), model.body_inertia[body].copy()

    def leak(data: mujoco.MjData) -> None:
        left = remaining_mass(context, values, float(data.time))
        model.body_mass[body], model.body_inertia[body] = mass * left, inertia * left

    return leak


DRAW_DRAWER_MASS: Draw = lambda rng, scene, paths: float(rng.uniform(0.25, 0.6) * scene.mass)  # noqa: E731


def unknown(name: str, draw: Draw, scale: str, **more: Any) -> Family:
    """Return a family outside the catalogue, with the value that scales it."""
    return Family(name, draw, (scale,), out_of_catalogue=True, **more)


FORCES = by_name(
    unknown("magnet", draws(place=DRAW_PLACE, strength=log(8.0, 40.0)), "strength", force=magnet_force),
    unknown(
        "warming_wheel",
        draws(excess=uniform(2.0, 10.0), seconds=uniform(1.0, 3.0)),
        "excess",
        hook=hook_warming_wheel,
    ),
    unknown(
        "shaking",
        draws(force=log(4.0, 25.0), frequency=uniform(0.5, 2.0), direction=ANGLE, phase=ANGLE),
        "force",
        force=shaking_force,
    ),
    unknown(
        "rattling_load",
        draws(mass=DRAW_DRAWER_MASS, direction=ANGLE, range=uniform(0.05, 0.2)),
        "mass",
        build=build_rattling_load,
        engines=("mujoco",),
    ),
    unknown(
        "hysteretic_spring",
        draws(stiffness=log(40.0, 250.0), yields=uniform(0.08, 0.25)),
        "stiffness",
        hook=hook_hysteretic_spring,
    ),
    unknown("sticky_ground", draw_sticky_ground, "slope", force=sticky_force(STICKY_GROUND_MOST)),
    unknown("magnetic_line", draw_magnetic_line, "strength", force=line_force),
    unknown(
        "rate_and_state",
        draws(force=log(6.0, 25.0), slip=uniform(0.02, 0.1), evolution=uniform(0.1, 0.25)),
        "force",
        hook=hook_sliding,
    ),
    unknown(
        "fading_friction",
        draws(force=log(10.0, 40.0), distance=uniform(0.1, 0.4)),
        "force",
        hook=hook_sliding,
    ),
    unknown(
        "sail",
        draws(force=log(5.0, 20.0), direction=ANGLE, lever=uniform(0.05, 0.2)),
        "force",
        force=sail_force,
    ),
    unknown("lateral_lift", draw_lift, "lift", force=lift_force),
    unknown("gusts", draw_gusts, "force", force=gust_force),
    unknown("floor_waves", draw_waves, "force", force=wave_force),
    unknown(
        "leaking_load",
        draws(share=uniform(0.4, 0.75), pace=uniform(0.3, 0.8)),
        "share",
        hook=hook_leaking_load,
    ),
)
