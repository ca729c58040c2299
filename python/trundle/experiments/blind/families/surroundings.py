"""Effects of friction and surroundings: dry friction, drag, floors, an obstacle, and a cable."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from trundle.experiments.blind import mujoco_world as world
from trundle.experiments.blind.family import (
    Context,
    Family,
    Hook,
    Values,
    by_name,
    draws,
    log,
    uniform,
)
from trundle.experiments.blind.outline import distance_to_outline, inside, to_object, to_world
from trundle.experiments.blind.push import Kinematics, Wrench
from trundle.experiments.blind.readings import world_friction_points
from trundle.experiments.blind.scene import Scene, Wheel, draw_point
from trundle.experiments.sampling import Floats, log_uniform

__all__ = ["SURROUNDINGS"]

TOTAL_FOOT_LOAD_N = 100.0
"""Load of all feet together; the friction coefficient scales the force."""
FOOT_RADIUS_M = 0.02
"""Radius of a foot."""
FOOT_CONTACT = {"contype": 2, "conaffinity": 2, "condim": 3}
"""Feet collide with the floor only."""
RING_RADIUS_M = 0.4
"""Radius of the ring on which the thinning drag acts."""
REFERENCE_SPEED_M_PER_S = 0.1
"""Speed at which the catalogue states the force of a thinning drag."""
MIN_START_CLEARANCE_M = 0.03
"""Distance from the obstacle at the start of every episode."""
MIN_HIT_DEPTH_M = 0.02
"""Penetration of the undisturbed path in episodes that count as hits."""
JOINT_LOADS = ("force_x", "force_y", "torque")


def draw_coulomb(rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
    """Return a force, and a point; without a point (one case in three) all feet share the force."""
    force = log_uniform(rng, 3.0, 30.0)
    whole = bool(rng.random() < 1 / 3)
    return {"force": force, "point": None if whole else list(draw_point(rng, scene.shape))}


def build_coulomb(context: Context, values: Values) -> None:
    """Add the floor, and light feet that slide vertically and are pressed on the floor."""
    points = context.scene.shape.feet.tolist() if values["point"] is None else [values["point"]]
    friction = [values["force"] / TOTAL_FOOT_LOAD_N, 0.0, 0.0]
    plane, sphere = mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_SPHERE
    context.spec.worldbody.add_geom(type=plane, size=[50.0, 50.0, 1.0], friction=friction, **FOOT_CONTACT)
    for k, (x, y) in enumerate(points):
        name, size = f"foot {k}", [FOOT_RADIUS_M, 0.0, 0.0]
        foot = context.table.add_body(name=name, pos=[x, y, FOOT_RADIUS_M])
        joint = mujoco.mjtJoint.mjJNT_SLIDE
        foot.add_joint(name=f"{name} lift", type=joint, axis=[0, 0, 1], damping=1.0)
        foot.add_geom(type=sphere, size=size, mass=0.01, friction=friction, **FOOT_CONTACT)
        where = {"trntype": mujoco.mjtTrn.mjTRN_JOINT, "target": f"{name} lift"}
        world.add_bias(context.spec, f"{name} load", [-TOTAL_FOOT_LOAD_N / len(points)], **where)


def coulomb_laws(scene: Scene, values: Values) -> list[Values]:
    """Return friction at the point, or under the supports."""
    if values["point"] is None:
        return [{"kind": "support_friction", "force": values["force"], "spread": 1.0}]
    x, y = values["point"]
    return [{"kind": "coulomb_friction", "x": x, "y": y, "force": values["force"]}]


def draw_axis_friction(rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
    """Return forces along x and y that differ by a factor of at least 1.5, and a torque."""
    small = log_uniform(rng, 2.0, 10.0)
    forces = [small, small * float(rng.uniform(1.5, 4.0))]
    rng.shuffle(forces)
    return dict(zip(JOINT_LOADS, (*forces, log_uniform(rng, 0.3, 3.0)), strict=True))


def build_axis_friction(context: Context, values: Values) -> None:
    """Set MuJoCo's `frictionloss` of the slides and the hinge of the object."""
    for joint, name in zip(context.table.joints, JOINT_LOADS, strict=True):
        joint.frictionloss = values[name]


def thinning_force(context: Context, values: Values, t: float, at: Kinematics) -> Wrench:
    """Return a drag with the square root of the speed of the object's origin and of a ring about it."""
    ring, spin = values["ring"], values["ring"] * at.omega
    drag = values["drag"] / (at.vx * at.vx + at.vy * at.vy + spin * spin + 1e-4) ** 0.25
    return -drag * at.vx, -drag * at.vy, -drag * ring * spin


def thinning_parameters(scene: Scene, values: Values) -> Values:
    """Return the force at the catalogue's reference speed, and the exponent."""
    return {"force": values["drag"] * REFERENCE_SPEED_M_PER_S**0.5, "exponent": 0.5}


def thinning_laws(scene: Scene, values: Values) -> list[Values]:
    """Return drag under the whole body, which approximates the ring."""
    spread = values["ring"] / scene.shape.gyration
    return [{"kind": "thinning_drag", **thinning_parameters(scene, values), "spread": spread}]


def draw_slope(rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
    """Return gravity's component along a floor that slopes by 0.3° to 3° in a random direction."""
    size = 9.81 * np.radians(np.exp(rng.uniform(np.log(0.3), np.log(3.0))))
    turn = rng.uniform(-np.pi, np.pi)
    return {"accel_x": float(size * np.cos(turn)), "accel_y": float(size * np.sin(turn))}


def build_slope(context: Context, values: Values) -> None:
    """Tilt gravity."""
    context.spec.option.gravity = [values["accel_x"], values["accel_y"], 0.0]


def build_grain(context: Context, values: Values) -> None:
    """Couple the slide joints by a fixed tendon with damping along one direction."""
    grain = context.spec.add_tendon(name="grain", damping=[values["mu"], 0.0, 0.0])
    grain.wrap_joint("x", float(np.cos(values["angle"])))
    grain.wrap_joint("y", float(np.sin(values["angle"])))


def draw_patch(rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
    """Return a rectangle that contains the friction points for 10 % to 60 % of the time."""
    points = np.concatenate([world_friction_points(scene, path[::100]).reshape(-1, 2) for path in paths])
    half = rng.uniform(0.25, 0.6, 2)
    for _ in range(20):
        values = {
            "x": float(rng.choice(points[:, 0])),
            "y": float(rng.choice(points[:, 1])),
            "half_length": float(half.max()),
            "half_width": float(half.min()),
            "angle": float(rng.uniform(0.0, np.pi)),
            "mu": log_uniform(rng, 10.0, 120.0),
        }
        if 0.1 < np.mean(inside(points, patch_corners(values))) < 0.6:
            return values
    return {}


def build_patch(context: Context, values: Values) -> None:
    """Add a damper at each foot, or corner, off at first."""
    for k, (x, y) in enumerate(context.scene.friction_points):
        off = Wheel(float(x), float(y), 0.0, 0.0, 0.0)
        world.add_wheel(context.spec, context.table, f"patch {k}", off)


def hook_patch(model: Any, context: Context, values: Values) -> Hook:
    """Switch the dampers on while their points are on the rectangle."""
    points: list[list[float]] = context.scene.friction_points.tolist()
    was: dict[int, bool] = {}
    turn, across = (math.cos(values["angle"]), math.sin(values["angle"])), values["half_width"]

    def switch(data: mujoco.MjData) -> None:
        x, y, heading = data.qpos[:3].tolist()
        c, s = math.cos(heading), math.sin(heading)
        for k, (px, py) in enumerate(points):
            dx, dy = x + c * px - s * py - values["x"], y + s * px + c * py - values["y"]
            along, side = turn[0] * dx + turn[1] * dy, turn[0] * dy - turn[1] * dx
            on = abs(along) < values["half_length"] and abs(side) < across
            if was.get(k) != on:
                was[k] = on
                world.set_wheel(model, f"patch {k}", on * values["mu"], on * values["mu"])

    return switch


def patch_corners(values: Values) -> Floats:
    """Return the rectangle's corners."""
    c, s = np.cos(values["angle"]), np.sin(values["angle"])
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * [values["half_length"], values["half_width"]]
    return np.asarray(corners @ np.array([[c, s], [-s, c]]) + [values["x"], values["y"]])


def draw_obstacle(rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
    """Return a position away from all starts that a training and a held-out episode hit."""
    radius, training = float(rng.uniform(0.04, 0.15)), len(paths) - scene.held_out
    starts = np.concatenate([path[::100] for path in paths])
    for _ in range(400):
        place = rng.choice(starts)[:2] + rng.uniform(-1.0, 1.0, 2)
        depth = [distance_to_outline(to_object(place, path[::60]), scene.shape.outline) for path in paths]
        if any(found[0] < radius + MIN_START_CLEARANCE_M for found in depth):
            continue
        hits = [found.min() < radius - MIN_HIT_DEPTH_M for found in depth]
        if any(hits[:training]) and any(hits[training:]):
            friction = float(rng.choice([0.0, 0.3]))
            return {"place": place.tolist(), "radius": radius, "friction": friction, "there": 1.0}
    return {}


def build_obstacle(context: Context, values: Values) -> None:
    """Add a fixed cylinder."""
    if values["there"] == 0.0:
        return
    context.spec.worldbody.add_geom(
        name="obstacle",
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[values["radius"], 0.3, 0.0],
        pos=[*values["place"], world.BODY_HEIGHT_M],
        friction=[values["friction"], 0.0, 0.0],
        condim=3 if values["friction"] else 1,
        priority=1,  # otherwise MuJoCo uses the larger friction of the two bodies
        solref=[0.01, 1.0],
    )


def obstacle_laws(scene: Scene, values: Values) -> list[Values]:
    """Return the contact."""
    (x, y), radius, friction = (values[name] for name in ("place", "radius", "friction"))
    return [{"kind": "obstacle_contact", "x": x, "y": y, "radius": radius, "friction": friction}]


def draw_tether(rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
    """Return two ends, and a rest length that is exceeded for a third to two thirds of the time."""
    point = draw_point(rng, scene.shape)
    ways = np.concatenate([to_world(np.array(point), path[::100]) for path in paths])
    size, turn = rng.uniform(0.6, 1.5), rng.uniform(-np.pi, np.pi)
    anchor = ways.mean(axis=0) + size * np.array([np.cos(turn), np.sin(turn)])
    lengths = np.hypot(*(ways - anchor).T)
    return {
        "point": list(point),
        "anchor": anchor.tolist(),
        "stiffness": log_uniform(rng, 20.0, 250.0),
        "rest_length": float(np.quantile(lengths, rng.uniform(0.33, 0.67))),
    }


def build_tether(context: Context, values: Values) -> None:
    """Add a tendon between two sites, slack below its rest length."""
    context.spec.worldbody.add_site(name="anchor", pos=[*values["anchor"], 0.0])
    context.table.add_site(name="tied", pos=[*values["point"], 0.0])
    slack, stiffness = [0.0, values["rest_length"]], [values["stiffness"], 0.0, 0.0]
    cable = context.spec.add_tendon(name="cable", stiffness=stiffness, springlength=slack)
    cable.wrap_site("anchor")
    cable.wrap_site("tied")


SURROUNDINGS = by_name(
    Family(
        "coulomb_friction",
        draw_coulomb,
        ("force",),
        build=build_coulomb,
        laws=coulomb_laws,
    ),
    Family(
        "axis_friction",
        draw_axis_friction,
        JOINT_LOADS,
        build=build_axis_friction,
        parameters=lambda scene, v: {**v, "angle": 0.0},
    ),
    Family(
        "thinning_drag",
        draws(drag=log(10.0, 80.0), ring=lambda rng, scene, paths: RING_RADIUS_M),
        ("drag",),
        force=thinning_force,
        parameters=thinning_parameters,
        laws=thinning_laws,
    ),
    Family("floor_slope", draw_slope, ("accel_x", "accel_y"), build=build_slope),
    Family("floor_grain", draws(mu=log(10.0, 150.0), angle=uniform(0.0, np.pi)), ("mu",), build=build_grain),
    Family(
        "floor_patch",
        draw_patch,
        ("mu",),
        build=build_patch,
        hook=hook_patch,
        parameters=lambda scene, v: {"mu": v["mu"]},
        where=lambda scene, v: {"world_region": patch_corners(v).tolist()},
        laws=lambda scene, v: [{"kind": "floor_patch", **v}],
    ),
    Family(
        "obstacle_contact",
        draw_obstacle,
        resize=lambda v, size: {**v, "radius": size * v["radius"], "there": size},
        build=build_obstacle,
        parameters=lambda scene, v: {},
        where=lambda scene, v: {"world_point": v["place"], "radius": v["radius"]},
        laws=obstacle_laws,
    ),
    Family("tether", draw_tether, ("stiffness",), build=build_tether),
)
