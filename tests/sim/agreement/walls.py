"""The same table among fixed boxes: scenes, MuJoCo's contacts, and what a wall gives.

MuJoCo's own friction is right where nothing slips. Where something does, its contacts are convex, which
drives the surfaces apart by a share of the slip: a table that glides along a wall leaves it, by 4 cm in
"slide". So what MuJoCo finds to touch may also get forces of ours: a damper that stops what comes and does
not throw it back, a spring that holds it, and Coulomb's friction that stops a slip, or as much as it can.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from tests.sim.agreement.scene import (
    CONTACT,
    INERTIA,
    MASS,
    STEP,
    Box,
    Effect,
    Floats,
    Push,
    middles,
    poses,
    simulated,
    turn,
)

FRICTION = 0.3
"""Of the rim, as in env/sim/src/colliders.rs."""
RATE = 1000.0
"""Samples per second of both tracks."""
SPRING, DAMPER = 4e5, 4e4
"""Of a contact, N/m and N·s/m: an impact takes a third of a millisecond, and of a push 0.1 mm are left."""
FINE, COARSE = 2e-5, 2e-4
"""Steps in an impact and without one, s."""


@dataclass(frozen=True)
class Scene:
    """A push among boxes, and the table's wheel."""

    push: Push
    boxes: Sequence[Box]
    wheel: Effect


@dataclass(frozen=True)
class Track:
    """Poses (n, 3) at `RATE` from contact on, and what the boxes have given until then (n, 3).

    That is the impulse in the world's axes and its moment about the table's origin, N·s, N·s, N·m·s.
    """

    pose: Floats
    given: Floats


def at_rest(force: float, until: float, seconds: float) -> list[tuple[float, float, float, float]]:
    """Return the knots of a push straight ahead that ends before the episode does."""
    return [
        (0, 0, 0, 0),
        (0.2, force, 0, 0),
        (until, force, 0, 0),
        (until + 0.2, 0, 0, 0),
        (seconds, 0, 0, 0),
    ]


def wheel(
    x: float = 0.0, y: float = 0.0, angle: float = 0.0, along: float = 40.0, across: float = 40.0
) -> Effect:
    """Return a viscous wheel."""
    return {"kind": "viscous_wheel", "x": x, "y": y, "angle": angle, "mu_x": along, "mu_y": across}


BEHIND = (-0.6, 0.0, 0.0)
"""The grasp in the middle of the rear side."""
BACK = [(0, 0, 0, 0), (0.2, 40, 0, 0), (1.6, 40, 0, 0), (1.8, -30, 0, 0), (2.3, -30, 0, 0), (2.5, 0, 0, 0)]
BOX = (1.0, 0.2, 1.5, 0.9)
SCENES: Mapping[str, Scene] = {
    # The flat of the table on a wall, and off it again.
    "head on": Scene(Push((0.0, 0.0, 0.0), BEHIND, BACK), [(0.9, -2.0, 1.4, 2.0)], wheel()),
    # The long side meets a wall at an angle and slides along it.
    "slide": Scene(
        Push((0.0, 0.0, 0.0), (0.0, 0.0, 0.6), at_rest(45, 2.0, 2.6)), [(-2.0, 0.55, 5.0, 1.0)], wheel()
    ),
    # A corner meets it first, slips, and the table turns until it is along the wall.
    "glance": Scene(Push((0.0, 0.0, 0.25), BEHIND, at_rest(45, 2.0, 2.6)), [(-1.0, 0.6, 4.0, 1.0)], wheel()),
    # The corner of a box in the way of the front turns the table.
    "box": Scene(Push((0.35, 0.0, 0.06), BEHIND, at_rest(40, 2.0, 2.6)), [BOX], wheel()),
    "box, fast": Scene(Push((0.0, 0.0, 0.06), BEHIND, at_rest(40, 2.0, 2.6)), [BOX], wheel()),
}


def world(folder: Path, scene: Scene, *, step: float | None = None) -> Track:
    """Return the track of `trundle simulate`, what the boxes have given by the balance of momentum."""
    dt = step or STEP
    columns = simulated(folder, [scene.wheel], scene.push, boxes=scene.boxes, step=step, rate=1.0 / dt)
    pose = poses(columns)[round(CONTACT / dt) :]
    every = slice(None, None, round(1.0 / (RATE * dt)))
    return Track(pose[every], balance(pose, dt, scene)[every])


def balance(pose: Floats, dt: float, scene: Scene) -> Floats:
    """Return momentum less what push and wheel have given, from poses at every step."""
    twist, heading = np.diff(pose, axis=0) / dt, (pose[1:, 2] + pose[:-1, 2]) / 2.0
    cos, sin = np.cos(heading), np.sin(heading)
    spin, at = twist[:, 2], scene.wheel
    over_floor = np.column_stack(
        [
            cos * twist[:, 0] + sin * twist[:, 1] - spin * at["y"],
            cos * twist[:, 1] - sin * twist[:, 0] + spin * at["x"],
        ]
    )
    rolling = turn(at["angle"])
    drag = -(over_floor @ rolling) * [at["mu_x"], at["mu_y"]] @ rolling.T
    wrench = scene.push.on_origin(middles(len(twist), dt))
    fx, fy = (wrench[:, k] + drag[:, k] for k in (0, 1))
    torque = wrench[:, 2] + at["x"] * drag[:, 1] - at["y"] * drag[:, 0]
    known = np.column_stack([cos * fx - sin * fy, sin * fx + cos * fy, torque]) * dt
    # Up to the middle of each step.
    given = twist * [MASS, MASS, INERTIA] - np.cumsum(known, axis=0) + known / 2.0
    return np.vstack([np.zeros(3), given])


def struck(scene: Scene, *, own: bool = False, friction: float = FRICTION) -> Track:
    """Return the track of MuJoCo, with its `own` contacts or with ours."""
    engine = furnished(scene, own, friction)
    data = mujoco.MjData(engine)
    data.qpos[:] = scene.push.start
    n, every = round(scene.push.seconds / COARSE), round(1.0 / (RATE * COARSE))
    given, track, sums = np.zeros(3), [data.qpos.copy()], [np.zeros(3)]
    for k, command in enumerate(scene.push.wrench(middles(n, COARSE))):
        data.ctrl[:3] = command
        hits = not own and any(contact[-1] < -0.01 for contact in touching(data))
        engine.opt.timestep = step = FINE if hits else COARSE
        for _ in range(round(COARSE / step)):
            if own:
                mujoco.mj_step(engine, data)
                given = given + data.qfrc_constraint * step
            else:
                mujoco.mj_step1(engine, data)
                data.qfrc_applied[:] = force = pressed(data, step, friction)
                mujoco.mj_step2(engine, data)
                given = given + np.array(force) * step
        if (k + 1) % every == 0:
            track.append(data.qpos.copy())
            sums.append(given)
    return Track(np.array(track), np.array(sums))


def furnished(scene: Scene, own: bool, friction: float) -> Any:
    """Return MuJoCo's table with gripper and wheel, and its boxes."""
    boxes = "".join(
        f'<geom type="box" pos="{(a + c) / 2} {(b + d) / 2} 0" size="{(c - a) / 2} {(d - b) / 2} 0.3"/>'
        for a, b, c, d in scene.boxes
    )
    # A stiff contact that does not throw back, or one that is found but does next to nothing.
    stiff = f'condim="3" friction="{friction} 0 0" solref="{2 * COARSE} 10" solimp="0.99 0.999 0.001"'
    nothing = 'condim="1" margin="0.001" solref="-1e-9 -1e-9" solimp="0.0001 0.0001 1"'
    at, (x, y, angle) = scene.wheel, scene.push.grasp
    drag = 'gainprm="0" biastype="affine" biasprm="0 0'
    return mujoco.MjModel.from_xml_string(f"""
    <mujoco><compiler angle="radian"/>
      <option timestep="{COARSE}" gravity="0 0 0" cone="elliptic" impratio="100"/>
      <default><geom {stiff if own else nothing}/></default>
      <worldbody>{boxes}<body name="table">
        <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/><joint type="hinge" axis="0 0 1"/>
        <inertial pos="0 0 0" mass="{MASS}" diaginertia="{INERTIA} {INERTIA} {INERTIA}"/>
        <geom type="box" size="0.6 0.4 0.1"/>
        <site name="grasp" pos="{x} {y} 0" euler="0 0 {angle}"/>
        <site name="wheel" pos="{at["x"]} {at["y"]} 0" euler="0 0 {at["angle"]}"/>
      </body></worldbody>
      <actuator>
        <general site="grasp" gear="1 0 0 0 0 0"/><general site="grasp" gear="0 1 0 0 0 0"/>
        <general site="grasp" gear="0 0 0 0 0 1"/>
        <general site="wheel" gear="1 0 0 0 0 0" {drag} {-at["mu_x"]}"/>
        <general site="wheel" gear="0 1 0 0 0 0" {drag} {-at["mu_y"]}"/>
      </actuator></mujoco>""")


Contact = tuple[float, float, float, float, float, float]
"""Depth, m; arm from the table's origin, m; direction towards the table; speed in that direction, m/s."""


def touching(data: Any) -> list[Contact]:
    """Return MuJoCo's contacts, one for each upright edge."""
    if data.ncon == 0:
        return []
    (x, y, _), (vx, vy, spin) = data.qpos.tolist(), data.qvel.tolist()
    found = []
    for contact in data.contact:
        (px, py, height), (nx, ny, _) = contact.pos.tolist(), contact.frame[:3].tolist()
        if height < 0.0:
            rx, ry = px - x, py - y
            if nx * rx + ny * ry > 0.0:
                nx, ny = -nx, -ny
            found.append((-contact.dist, rx, ry, nx, ny, (vx - spin * ry) * nx + (vy + spin * rx) * ny))
    return found


def pressed(data: Any, step: float, friction: float) -> tuple[float, float, float]:
    """Return what the contacts do to the table: force, and torque about its origin."""
    fx = fy = torque = 0.0
    vx, vy, spin = data.qvel.tolist()
    for depth, rx, ry, nx, ny, away in touching(data):
        normal = SPRING * depth - DAMPER * away
        if depth <= 0.0 or normal <= 0.0:
            continue
        slip = (vy + spin * rx) * nx - (vx - spin * ry) * ny
        across, along = rx * nx + ry * ny, rx * ny - ry * nx
        # What would stop the slip within the step, were this the only contact.
        stop = -(slip / step + across * along / INERTIA * normal) / (1.0 / MASS + across * across / INERTIA)
        tangential = min(max(stop, -friction * normal), friction * normal)
        ax, ay = normal * nx - tangential * ny, normal * ny + tangential * nx
        fx, fy, torque = fx + ax, fy + ay, torque + rx * ay - ry * ax
    return fx, fy, torque
