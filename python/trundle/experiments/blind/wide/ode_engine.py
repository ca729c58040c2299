"""The ODE engine: planar Newton-Euler equations, integrated by the Runge-Kutta method of fourth order.

It uses neither trundle's laws nor MuJoCo. Dry friction is a bristle model (Dahl). Contact is a spring with
losses (Hunt and Crossley) and smoothed Coulomb friction. A caster's tyre has a relaxation time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np

from trundle.experiments.blind.family import HiddenEffect
from trundle.experiments.blind.outline import OutlineDistance
from trundle.experiments.blind.push import CONTACT_TIME_S, Finger, Kinematics, Push, Wrench, servo_wrench
from trundle.experiments.blind.readings import Readings, step_averages
from trundle.experiments.blind.scene import Scene
from trundle.experiments.blind.wide.measurement import grasp_readings, grid_readings
from trundle.experiments.blind.wide.ode_terms import InertialProperties, make_terms, wheel_term
from trundle.experiments.sampling import Floats

__all__ = ["TIME_STEP_S", "Plant", "simulate"]

Driver: TypeAlias = Callable[[float, Kinematics], Wrench]

TIME_STEP_S = 1e-3
"""Integration step."""
CONTACT_LOSS_S_PER_M = 2.0
"""Loss of the Hunt-Crossley contact: force k d (1 + loss · approach speed)."""
RUNGE_KUTTA_WEIGHTS = np.array([1.0, 2.0, 2.0, 1.0]) / 6.0
FRICTION_SPEED_M_PER_S = 3e-3
"""Speed scale of the smoothed friction of the fingertip."""


def simulate(scene: Scene, hidden: Sequence[HiddenEffect], episode: int) -> Readings:
    """Return the readings of perfect instruments in an episode."""
    plant = Plant(scene, hidden, episode)
    return plant.pushed() if scene.strokes else plant.grasped()


class Plant:
    """An object with all forces on it, in one episode."""

    def __init__(self, scene: Scene, hidden: Sequence[HiddenEffect], episode: int) -> None:
        self.scene, self.episode = scene, episode
        x, y = scene.shape.centroid.tolist()
        self.trait = InertialProperties(scene.mass, scene.mass * scene.shape.spin, x, y)
        self.terms = [wheel_term(scene.wheel, self.trait)]
        for one in hidden:
            self.terms += make_terms(one, scene, episode, self.trait)
        self.n = round((scene.seconds[episode] - CONTACT_TIME_S) / TIME_STEP_S) + 1
        self.t: Floats = CONTACT_TIME_S + TIME_STEP_S * np.arange(self.n, dtype=np.float64)

    def initial(self) -> list[float]:
        """Return the state at contact: pose and twist of the object's origin, then the terms' states."""
        start = self.scene.pushes[self.episode].start
        state = [*map(float, start), 0.0, 0.0, 0.0]
        return state + [value for term in self.terms for value in term.initial(start)]

    def rate(self, t: float, state: list[float], driver: Driver) -> list[float]:
        """Return the derivative of the state."""
        at = Kinematics.of(state)
        fx, fy, torque = driver(t, at)
        inner: list[float] = []
        first = 6
        for term in self.terms:
            last = first + term.states
            gx, gy, more, rates = term.act(t, at, state[first:last])
            fx, fy, torque, first = fx + gx, fy + gy, torque + more, last
            inner += rates
        trait = self.trait
        factor = trait.factor(t)
        mass, inertia = factor * trait.mass, factor * trait.inertia
        rx, ry = at.c * trait.x - at.s * trait.y, at.s * trait.x + at.c * trait.y
        alpha = (torque - (rx * fy - ry * fx)) / inertia
        ax = fx / mass + alpha * ry + at.omega * at.omega * rx
        ay = fy / mass - alpha * rx + at.omega * at.omega * ry
        return [at.vx, at.vy, at.omega, ax, ay, alpha, *inner]

    def step(self, t: float, state: list[float], driver: Driver) -> list[float]:
        """Return the state one step later."""
        h = TIME_STEP_S
        a = self.rate(t, state, driver)
        b = self.rate(t + h / 2, [u + h / 2 * v for u, v in zip(state, a, strict=True)], driver)
        c = self.rate(t + h / 2, [u + h / 2 * v for u, v in zip(state, b, strict=True)], driver)
        d = self.rate(t + h, [u + h * v for u, v in zip(state, c, strict=True)], driver)
        return [u + h / 6 * (p + 2 * q + 2 * r + w) for u, p, q, r, w in zip(state, a, b, c, d, strict=True)]

    def grasped(self) -> Readings:
        """Simulate a grasp. Its force is proportional to the velocity error."""
        servo = Servo(self.scene, self.episode, self.n)
        poses, wrenches, state = np.empty((self.n, 3)), np.empty((self.n, 3)), self.initial()
        for k, t in enumerate(self.t.tolist()):
            poses[k] = state[:3]
            wrenches[k] = servo.exerted(t, Kinematics.of(state))
            state = self.step(t, state, servo.driver)
        return grasp_readings(self.scene, self.episode, self.t, poses, wrenches)

    def pushed(self) -> Readings:
        """Simulate free pushing."""
        scene, episode = self.scene, self.episode
        finger, tip = Finger(scene.strokes[episode], scene.shape, TIME_STEP_S), FingerTip(scene, episode)
        poses, tips, wrenches = (np.zeros((self.n, 3)) for _ in range(3))
        state, angle = self.initial(), scene.pushes[episode].grasp.angle
        for k, t in enumerate(self.t.tolist()):
            tip.began, tip.course = t, finger.at(t, state[:3])
            _, _, x, y = tip.touch(t, Kinematics.of(state))
            poses[k], tips[k] = state[:3], (x, y, angle)
            tip.forces = []
            state = self.step(t, state, tip.driver)
            # The mean force over the step, weighted like its Runge-Kutta stages.
            wrenches[k, :2] = RUNGE_KUTTA_WEIGHTS @ np.array(tip.forces)
        return grid_readings(scene, episode, self.t, poses, tips, step_averages(wrenches))


class Servo:
    """A grasp with a force proportional to the velocity error, up to a limit."""

    def __init__(self, scene: Scene, episode: int, steps: int) -> None:
        push = scene.pushes[episode]
        assert isinstance(push, Push)
        halves: Floats = CONTACT_TIME_S + TIME_STEP_S / 2 * np.arange(2 * steps + 1, dtype=np.float64)
        self.grasp, self.desired = push.grasp, push.desired_twist(halves).tolist()
        self.gain, self.limit = scene.gain, scene.limit

    def exerted(self, t: float, at: Kinematics) -> Wrench:
        """Return the wrench in the axes and about the origin of the grasp."""
        desired = self.desired[round((t - CONTACT_TIME_S) / TIME_STEP_S * 2)]
        return servo_wrench(at, self.grasp, desired, self.gain, self.limit)

    def driver(self, t: float, at: Kinematics) -> Wrench:
        """Return the wrench in world axes about the object's origin."""
        along, across, moment = self.exerted(t, at)
        g = self.grasp
        c, s = math.cos(at.theta + g.angle), math.sin(at.theta + g.angle)
        fx, fy = c * along - s * across, s * along + c * across
        ax, ay = at.c * g.x - at.s * g.y, at.s * g.x + at.c * g.y
        return fx, fy, moment + ax * fy - ay * fx


class FingerTip:
    """The tip of a finger on a compliant arm. Its contact has no moment about itself."""

    def __init__(self, scene: Scene, episode: int) -> None:
        strokes = scene.strokes[episode]
        self.outline = OutlineDistance(scene.shape)
        self.stiffness, self.friction = strokes.stiffness, strokes.friction
        self.forces: list[tuple[float, float]] = []
        self.began, self.course = 0.0, (0.0, 0.0, 0.0, 0.0, True)

    def touch(self, t: float, at: Kinematics) -> tuple[float, float, float, float]:
        """Return the force on the object, world axes, and the tip's position on the surface."""
        x, y, vx, vy, down = self.course
        x, y = x + (t - self.began) * vx, y + (t - self.began) * vy
        if not down:
            return 0.0, 0.0, x, y
        dx, dy = x - at.x, y - at.y
        depth, nx, ny = self.outline.depth(at.c * dx + at.s * dy, at.c * dy - at.s * dx)
        if depth <= 0.0:
            return 0.0, 0.0, x, y
        nx, ny = at.c * nx - at.s * ny, at.s * nx + at.c * ny  # outward, world axes
        x, y = x + depth * nx, y + depth * ny
        ux = vx - at.vx + at.omega * (y - at.y)
        uy = vy - at.vy - at.omega * (x - at.x)
        normal = self.stiffness * depth * (1.0 - CONTACT_LOSS_S_PER_M * (ux * nx + uy * ny))
        if normal <= 0.0:
            return 0.0, 0.0, x, y
        slip = uy * nx - ux * ny
        side = self.friction * normal * slip / math.hypot(slip, FRICTION_SPEED_M_PER_S)
        return -normal * nx - side * ny, -normal * ny + side * nx, x, y

    def driver(self, t: float, at: Kinematics) -> Wrench:
        """Return the wrench in world axes about the object's origin."""
        fx, fy, x, y = self.touch(t, at)
        self.forces.append((fx, fy))
        return fx, fy, (x - at.x) * fy - (y - at.y) * fx
