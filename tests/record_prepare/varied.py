"""Clean recordings whose object, contact, instruments and conventions are drawn at random.

A rigid body in the plane, with viscous wheels and dry feet, is pushed by a firm grasp, a compliant grasp or a
point contact. It is integrated by NumPy, all episodes at once, independently of trundle's laws and of MuJoCo.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import trundle

__all__ = ["Drawn", "draw", "recording"]

Floats = NDArray[np.float64]
Tables = dict[str, dict[str, Any]]

STEP = 1e-3
"""s."""
RAMP = 0.3
"""Rise time of a push, s."""


@dataclass(frozen=True)
class Drawn:
    """A recording as plain values, which can be corrupted before validation, and its truth."""

    metadata: dict[str, Any]
    tables: Tables
    contact: str
    """ "grasp", "compliant" or "point"."""
    frame: str
    mass: float
    size: float
    rates: tuple[float, float]
    """Of tracker and sensor, Hz."""
    slow: bool


@dataclass(frozen=True)
class Body:
    """Half-sides m, mass kg, mass centre m, inertia about it kg·m², wheels and feet of the object."""

    half: Floats
    mass: float
    center: Floats
    inertia: float
    wheels: Floats
    """Rows x, y, angle, mu_along, mu_across (m, m, rad, N·s/m)."""
    feet: Floats
    """Rows x, y, most force (m, m, N)."""
    size: float


def recording(drawn: Drawn) -> trundle.Recording:
    """Validate what was drawn."""
    return trundle.Recording(drawn.metadata, drawn.tables)


def draw(seed: int, **chosen: Any) -> Drawn:
    """Draw a clean recording; `chosen` fixes choices: the names below, "episodes" or "seconds"."""
    rng = np.random.default_rng([seed, 18])
    options: dict[str, Any] = {
        "contact": str(rng.choice(["grasp", "compliant", "point"], p=[0.5, 0.25, 0.25])),
        "frame": str(rng.choice(["sensor", "object", "world"], p=[0.6, 0.2, 0.2])),
        "slow": bool(rng.random() < 0.15),
        "mass_given": bool(rng.random() < 0.5),
        "sign": str(rng.choice(["on_object", "on_sensor"])),
        "raw": bool(rng.random() < 0.6),
        "rates": (log_uniform(rng, 10.0, 250.0), log_uniform(rng, 50.0, 1000.0)),
    }
    unknown = set(chosen) - set(options) - {"episodes", "seconds"}
    if unknown:
        raise TypeError(f"draw() cannot fix {sorted(unknown)}")
    options |= chosen
    body = draw_body(rng, dry=options["slow"] or bool(rng.random() < 0.4))
    episodes, seconds = int(rng.integers(3, 9)), float(np.round(rng.uniform(3.0, 8.0), 2))
    episodes, seconds = options.get("episodes", episodes), options.get("seconds", seconds)
    quiet = float(np.round(rng.uniform(0.4, 0.8), 2))
    pushed = push(rng, body, options["contact"], options["slow"], episodes, seconds - quiet)
    return measured(rng, body, pushed, options, quiet)


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """Draw a number whose logarithm is uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def draw_body(rng: np.random.Generator, *, dry: bool) -> Body:
    """Draw an object between a shoe box and a bed."""
    long = log_uniform(rng, 0.1, 1.0)
    half = np.array([long, long * rng.uniform(0.4, 1.0)])
    mass = 4.0 * half[0] * half[1] * log_uniform(rng, 10.0, 60.0)
    inertia = mass * float(half @ half) / 3.0 * rng.uniform(0.8, 1.2)
    count = int(rng.integers(1, 3))
    along = [mass / log_uniform(rng, 0.5, 5.0) for _ in range(count)]
    across = [mass / log_uniform(rng, 0.05, 2.0) for _ in range(count)]
    places = rng.uniform(-0.9, 0.9, (count, 2)) * half
    wheels = np.column_stack([places, rng.uniform(-np.pi, np.pi, count), along, across])
    corners = np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]]) * 0.85 * half
    load = rng.uniform(0.05, 0.3) * mass * 9.81 * (1.0 if dry else 0.0) * rng.dirichlet([4.0] * 4)
    center = rng.uniform(-0.15, 0.15, 2) * half
    return Body(
        half, mass, center, inertia, wheels, np.column_stack([corners, load]), 2 * float(np.hypot(*half))
    )


@dataclass(frozen=True)
class Pushed:
    """True motion: times (n,); pose, gripper and wrench (n, episodes, 3)."""

    t: Floats
    pose: Floats
    gripper: Floats
    wrench: Floats
    """Force in world axes, torque about the gripper's origin."""


def push(
    rng: np.random.Generator, body: Body, contact: str, slow: bool, episodes: int, seconds: float
) -> Pushed:
    """Integrate all pushes, one step for all episodes at a time."""
    n = round(seconds / STEP)
    t: Floats = STEP * np.arange(n + 1, dtype=np.float64)
    start = np.column_stack(
        [rng.uniform(-1, 1, (episodes, 2)) * body.size, rng.uniform(-np.pi, np.pi, episodes)]
    )
    drive = (Pusher if contact == "point" else Hand)(rng, body, start, t, slow, stiff=contact == "grasp")
    pose, twist = start.copy(), np.zeros_like(start)
    rows: list[list[Floats]] = [[], [], []]
    for k in range(n + 1):
        force, torque, place = drive(k, pose, twist)
        for row, value in zip(rows, (pose, place, np.column_stack([force, torque])), strict=True):
            row.append(value.copy())
        twist = twist + STEP * accelerations(body, pose, twist, force, torque, place)
        pose = pose + STEP * twist
    return Pushed(t, *(np.array(row) for row in rows))


def accelerations(
    body: Body, pose: Floats, twist: Floats, force: Floats, torque: Floats, place: Floats
) -> Floats:
    """Return the acceleration of the object's origin, world axes, and of its angle."""
    c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    center = turned(c, s, *body.center)
    total, moment = force.copy(), torque + cross(place[:, :2] - pose[:, :2] - center, force)
    for x, y, angle, along, across in body.wheels:
        arm = turned(c, s, x, y)
        velocity = twist[:, :2] + twist[:, 2:] * perpendicular(arm)
        ahead = turned(c, s, np.cos(angle), np.sin(angle))
        aside = perpendicular(ahead)
        drag = -along * dot(velocity, ahead)[:, None] * ahead - across * dot(velocity, aside)[:, None] * aside
        total, moment = total + drag, moment + cross(arm - center, drag)
    for x, y, most in body.feet[body.feet[:, 2] > 0]:
        arm = turned(c, s, x, y)
        velocity = twist[:, :2] + twist[:, 2:] * perpendicular(arm)
        slip = np.hypot(*velocity.T)[:, None]
        drag = -most * velocity / np.maximum(slip, 0.004)
        total, moment = total + drag, moment + cross(arm - center, drag)
    spin = moment / body.inertia
    of_center = total / body.mass
    rate = twist[:, 2:]
    linear = of_center - spin[:, None] * perpendicular(center) + rate * rate * center
    return np.column_stack([linear, spin])


def turned(c: Floats, s: Floats, x: float, y: float) -> Floats:
    """Return a vector of the object's frame in world axes, for every episode."""
    return np.column_stack([c * x - s * y, s * x + c * y])


def perpendicular(v: Floats) -> Floats:
    """Return vectors turned by a right angle, counter-clockwise."""
    return np.column_stack([-v[:, 1], v[:, 0]])


def cross(a: Floats, b: Floats) -> Floats:
    """Return the cross product of plane vectors, row by row."""
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def dot(a: Floats, b: Floats) -> Floats:
    """Return the scalar product, row by row."""
    return np.asarray(np.sum(a * b, axis=1))


class Hand:
    """A grasp: a force proportional to the error of the twist, or a spring between hand and object."""

    def __init__(
        self, rng: np.random.Generator, body: Body, start: Floats, t: Floats, slow: bool, *, stiff: bool
    ) -> None:
        episodes = len(start)
        speed = log_uniform(rng, 0.2, 0.8) * np.sqrt(body.size) * (0.12 if slow else 1.0)
        size = np.array([speed, speed, 1.2 * speed / np.sqrt(body.size)])
        share = rng.dirichlet(np.ones(3), size=(episodes, 3)) ** 0.5
        frequency = rng.uniform(0.1, 0.35 if slow else 1.0, (episodes, 3, 3))
        phase = rng.uniform(-np.pi, np.pi, (episodes, 3, 3))
        waves = np.sin(2 * np.pi * frequency * t[:, None, None, None] + phase)
        self.wanted = np.clip(t / RAMP, 0, 1)[:, None, None] * size * np.sum(share * waves, axis=3)
        grasps = body.half * rng.uniform(-1.1, 1.1, (3, 2))
        self.grasp = np.column_stack([grasps, rng.uniform(-np.pi, np.pi, 3)])[rng.integers(0, 3, episodes)]
        self.gain = body.mass * log_uniform(rng, 4.0, 12.0)
        self.turn = 0.1 * self.gain * body.size**2
        self.stiff, self.hand, self.stiffness = stiff, np.zeros((0, 3)), 10.0 * self.gain

    def __call__(self, k: int, pose: Floats, twist: Floats) -> tuple[Floats, Floats, Floats]:
        """Return force (world), torque about the gripper, and the gripper's pose."""
        c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
        gx, gy, angle = self.grasp.T
        arm = np.column_stack([c * gx - s * gy, s * gx + c * gy])
        held = np.column_stack([pose[:, :2] + arm, pose[:, 2] + angle])
        velocity = np.column_stack([twist[:, :2] + twist[:, 2:] * perpendicular(arm), twist[:, 2]])
        ca, sa = np.cos(held[:, 2]), np.sin(held[:, 2])
        wx, wy, wt = self.wanted[k].T
        wanted = np.column_stack([ca * wx - sa * wy, sa * wx + ca * wy, wt])
        if self.stiff:
            force = self.gain * (wanted - velocity)[:, :2]
            return force, self.turn * (wt - twist[:, 2]), held
        if not len(self.hand):
            self.hand = held.copy()
        stretch, speed = self.hand - held, wanted - velocity
        force = self.stiffness * stretch[:, :2] + 0.3 * self.gain * speed[:, :2]
        torque = 10.0 * self.turn * stretch[:, 2] + 0.3 * self.turn * speed[:, 2]
        place = self.hand.copy()
        self.hand = self.hand + STEP * (wanted + 0.5 * (held - self.hand))
        torque = torque + cross(held[:, :2] - place[:, :2], force)
        return force, torque, place


class Pusher:
    """A point that pushes a face of the object through a stiff pad and never pulls."""

    def __init__(
        self, rng: np.random.Generator, body: Body, start: Floats, t: Floats, slow: bool, *, stiff: bool
    ) -> None:
        del stiff
        episodes = len(start)
        self.body, self.friction = body, rng.uniform(0.2, 0.6)
        face = rng.integers(0, 4, episodes)
        self.normal = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])[face]
        """Inward, object axes."""
        tangent = perpendicular(self.normal)
        depth = np.abs(self.normal @ body.half)
        width = np.abs(tangent @ body.half)
        offset = rng.uniform(-0.5, 0.5, episodes) * width
        speed = log_uniform(rng, 0.15, 0.5) * np.sqrt(body.size) * (0.12 if slow else 1.0)
        waves = 0.6 * np.sin(
            2 * np.pi * rng.uniform(0.3, 0.8, episodes) * t[:, None] + rng.uniform(0, 6, episodes)
        )
        self.speed = np.clip(t / RAMP, 0, 1)[:, None] * speed * (1.0 + waves)
        place = -self.normal * depth[:, None] + tangent * offset[:, None]
        c, s = np.cos(start[:, 2]), np.sin(start[:, 2])
        self.depth = depth
        self.tip = start[:, :2] + np.column_stack(
            [c * place[:, 0] - s * place[:, 1], s * place[:, 0] + c * place[:, 1]]
        )
        self.heading = start[:, 2] + np.arctan2(self.normal[:, 1], self.normal[:, 0])
        self.turned = rng.uniform(-np.pi, np.pi)
        self.stiffness = body.mass * 40.0**2

    def __call__(self, k: int, pose: Floats, twist: Floats) -> tuple[Floats, Floats, Floats]:
        """Return force (world), no torque, and the tip's pose."""
        c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
        inward = np.column_stack(
            [c * self.normal[:, 0] - s * self.normal[:, 1], s * self.normal[:, 0] + c * self.normal[:, 1]]
        )
        arm = self.tip - pose[:, :2]
        speed = self.speed[k]
        course = speed[:, None] * np.column_stack([np.cos(self.heading), np.sin(self.heading)])
        gap = course - twist[:, :2] - twist[:, 2:] * perpendicular(arm)
        pressed = np.maximum(dot(arm, inward) + self.depth, 0.0)
        load = np.maximum(
            self.stiffness * pressed + 40.0 * self.body.mass * dot(gap, inward) * (pressed > 0), 0.0
        )
        aside = perpendicular(inward)
        slip = dot(gap, aside)
        force = load[:, None] * inward + (self.friction * load * np.clip(slip / 0.01, -1, 1))[:, None] * aside
        place = np.column_stack([self.tip, np.full(len(pose), self.turned) + 0.0 * speed])
        self.tip = self.tip + STEP * course
        return force, np.zeros(len(pose)), place


def measured(
    rng: np.random.Generator, body: Body, pushed: Pushed, options: dict[str, Any], quiet: float
) -> Drawn:
    """Return the measurements of the pushes."""
    pose_rate, force_rate = options["rates"]
    peak = float(np.quantile(np.hypot(*pushed.wrench[..., :2].T), 0.95))
    travel = np.hypot(*np.ptp(pushed.pose[..., :2], axis=0).T).max()
    spread = min(log_uniform(rng, 1e-4, 3e-3), 0.004 * body.size, 0.01 * float(travel))
    pose_noise = np.array([spread, spread, spread / (0.5 * body.size)])
    force_noise = peak * log_uniform(rng, 0.003, 0.03)
    torque_noise = 0.1 * body.size * force_noise
    raw = options["raw"] and options["frame"] == "sensor"
    offset = rng.normal(size=3) * peak * np.array([0.1, 0.1, 0.03 * body.size]) * raw
    lost, jitter = float(rng.choice([0.0, 0.0, 0.2, 0.5])), float(rng.choice([0.0, 0.2]))
    sign = 1.0 if options["sign"] == "on_object" else -1.0
    reference = "sensor" if options["frame"] == "sensor" else str(rng.choice(["sensor", "object"]))
    names = [f"episode_{k:02}" for k in range(pushed.pose.shape[1])]
    tables: Tables = {}
    for k, name in enumerate(names):
        t = np.concatenate([[0.0], quiet + pushed.t])
        pose, gripper, wrench = (
            np.vstack([first, values[:, k]])
            for values, first in (
                (pushed.pose, pushed.pose[0, k]),
                (pushed.gripper, pushed.gripper[0, k]),
                (pushed.wrench, np.zeros(3)),
            )
        )
        wrench[(t >= 0) & (t < quiet)] = 0.0
        pose_t = times(rng, pose_rate, t[-1], lost, jitter)
        force_t = times(rng, force_rate, t[-1], 0.0, 0.0)
        seen_pose = at(t, pose, pose_t)
        seen_gripper = at(t, gripper, pose_t)
        true_pose, true_gripper = at(t, pose, force_t), at(t, gripper, force_t)
        load = at(t, wrench, force_t)
        load[force_t < quiet] = 0.0
        reading = in_frame(load, true_pose, true_gripper, options["frame"], reference)
        reading = (
            sign * reading
            + offset
            + rng.normal(size=reading.shape) * [force_noise, force_noise, torque_noise]
        )
        seen_pose = seen_pose + rng.normal(size=seen_pose.shape) * pose_noise
        seen_gripper = seen_gripper + rng.normal(size=seen_gripper.shape) * pose_noise * [1, 1, 0.3]
        tables[name] = joined(pose_t, seen_pose, seen_gripper, force_t, reading)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * body.half
    metadata: dict[str, Any] = {
        "format": "trundle-recording/1",
        "name": "drawn",
        "object": {"footprint": corners.tolist()} | ({"mass": body.mass} if options["mass_given"] else {}),
        "wrench": {
            "frame": options["frame"],
            "reference": reference,
            "sign": options["sign"],
            "contact": "point" if options["contact"] == "point" else "grasp",
        },
    }
    if raw:
        metadata["wrench"] |= {"raw": True, "precontact": [0.0, quiet - 0.05]}
    if rng.random() < 0.5:
        metadata["noise"] = {"pose": pose_noise.tolist(), "force": force_noise, "torque": torque_noise}
    return Drawn(
        metadata,
        tables,
        options["contact"],
        options["frame"],
        body.mass,
        body.size,
        options["rates"],
        options["slow"],
    )


def in_frame(load: Floats, pose: Floats, gripper: Floats, frame: str, reference: str) -> Floats:
    """Return a load (force world, torque about the gripper) as the reading gives it."""
    angle = {"sensor": gripper[:, 2], "object": pose[:, 2], "world": np.zeros(len(pose))}[frame]
    c, s = np.cos(angle), np.sin(angle)
    fx, fy, torque = load.T
    if reference == "object":
        torque = torque + cross(gripper[:, :2] - pose[:, :2], load[:, :2])
    return np.column_stack([c * fx + s * fy, c * fy - s * fx, torque])


def times(rng: np.random.Generator, rate: float, end: float, lost: float, jitter: float) -> Floats:
    """Return sample times to the microsecond, some of them lost."""
    first = rng.uniform(0.0, 1.0 / rate)
    regular = first + np.arange(int((end - first) * rate)) / rate
    moved = regular + rng.uniform(-0.5, 0.5, len(regular)) * jitter / rate
    kept = rng.random(len(moved)) >= lost
    return np.unique(np.round(moved[kept].clip(0.0, end), 6))


def at(t: Floats, values: Floats, when: Floats) -> Floats:
    """Return columns of `values` at other times."""
    return np.column_stack([np.interp(when, t, column) for column in values.T])


def joined(pose_t: Floats, pose: Floats, gripper: Floats, force_t: Floats, reading: Floats) -> dict[str, Any]:
    """Return one table of all streams, empty where a stream has no sample."""
    t = np.unique(np.concatenate([pose_t, force_t]))
    columns: dict[str, Any] = {"t": t}
    axes = ("x", "y", "theta")
    streams = {f"object_{axis}": (pose_t, pose[:, k]) for k, axis in enumerate(axes)}
    streams |= {f"gripper_{axis}": (pose_t, gripper[:, k]) for k, axis in enumerate(axes)}
    streams |= {axis: (force_t, reading[:, k]) for k, axis in enumerate(("force_x", "force_y", "torque_z"))}
    for name, (when, values) in streams.items():
        columns[name] = np.full(len(t), np.nan)
        columns[name][np.searchsorted(t, when)] = values
    return columns
