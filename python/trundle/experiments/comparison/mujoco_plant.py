"""MuJoCo as the simulator of a pushing environment: an object on balls, with MuJoCo's contacts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import gymnasium as gym
import mujoco
import numpy as np
import tomli_w
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

import trundle
from trundle._native import Laws
from trundle.envs import Observation, Push
from trundle.experiments.blind import mujoco_world as world
from trundle.experiments.blind.push import Grasp
from trundle.experiments.blind.scene import Wheel
from trundle.experiments.sampling import Floats
from trundle.picture import outlines
from trundle.recording import TrundleError

__all__ = ["MujocoPlant", "make_spec"]

Effect = Mapping[str, Any]

BALL_RADIUS_M, BALL_MASS_KG = 0.05, 0.1
"""The balls under the object's feet."""
FLOOR_FRICTION_COEFFICIENT, RIM_FRICTION_COEFFICIENT = 1.0, 0.3
"""Friction of balls on the floor, and of the object's rim on obstacles."""
RIM_RADIUS_M = 0.005
"""Radius of the capsules along the object's outline; by so much the object is larger."""
STEPS_PER_TICK = 4
"""Steps of MuJoCo per simulation step of the environment: 0.5 ms."""
RISE_S = 0.02
"""Time in which the wrench reaches a new action."""
SETTLING_S = 0.1
"""Time in which the object settles on the floor."""
GRAVITY_M_PER_S2 = 9.81
SLIDING = "support_friction"
WHEEL_KEYS = ("x", "y", "angle", "mu_x", "mu_y")
FLOOR_BIT, RIM_BIT = 1, 2
"""Collision bits: balls touch the floor, the rim touches obstacles."""


class MujocoPlant(gym.Wrapper[Floats, NDArray[np.float32], Floats, NDArray[np.float32]]):
    """Replace the simulation of a pushing environment by MuJoCo.

    Object, hidden effects, goal, obstacles, instruments and costs are those of the environment; MuJoCo
    computes the motion. The object rests on balls, one at each foot, which roll on the floor with friction
    and may slip. With `support_friction` they do not roll: the feet slide on the floor with that friction.
    Wheels with equal friction in all directions are the bearings of rolling balls. Other viscous wheels
    resist at their place. A caster is a swivelling arm whose tyre slips sideways.

    Parameters
    ----------
    env : gymnasium.Env
        An environment of `trundle.envs` with the action "wrench" and an ideal arm.

    Raises
    ------
    TrundleError
        If `env` is another environment. `reset` raises it for an effect that the plant does not contain, and
        for an object that does not stand on three feet.

    Examples
    --------
    >>> import gymnasium, trundle
    >>> from trundle.experiments.comparison.mujoco_plant import MujocoPlant
    >>> env = MujocoPlant(gymnasium.make("trundle/PushAroundMedium-v1"))
    >>> observation, info = env.reset(seed=0)
    >>> observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
    """

    def __init__(self, env: gym.Env[Floats, NDArray[np.float32]]) -> None:
        super().__init__(env)
        push = env.unwrapped
        if not isinstance(push, Push) or push.mode != "wrench":
            raise TrundleError(f'{env}: choose a pushing environment of trundle with action = "wrench"')
        self._push = push
        self._simulation: Simulation | None = None
        self._steps = 0
        limits = (push.horizon, (env.spec and env.spec.max_episode_steps) or 0)
        self._limit = min((limit for limit in limits if limit), default=0)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Floats, dict[str, Any]]:
        """Begin an episode of the environment, and build its object in MuJoCo."""
        observation, info = self.env.reset(seed=seed, options=options)
        first = float(self.np_random.uniform(-np.pi, np.pi))
        grasp = Observation(observation).grasp
        spec = make_spec(self._push.hidden_model(), self._push.scene(), grasp, first)
        tick = self._push.control / self._push.substeps
        self._simulation = Simulation(spec, self._push.scene()["object"], tick)
        self._steps = 0
        return observation, info

    def step(self, action: NDArray[np.float32]) -> tuple[Floats, float, bool, bool, dict[str, Any]]:
        """Apply an action; see `trundle.envs.Push`."""
        if self._simulation is None:
            raise ResetNeeded("call reset() before step()")
        wanted = np.clip(action, -1.0, 1.0) * self._push.ACTION_SCALE
        motion = self._simulation.push(wanted, self._push.substeps)
        observation, reward, terminated, truncated, info = self._push.follow(*motion)
        self._steps += 1
        # The time limit is a wrapper within this one, whose steps do not count.
        is_over = 0 < self._limit <= self._steps and not terminated
        return observation, reward, terminated, truncated or is_over, info


class Simulation:
    """An object in MuJoCo, from rest.

    Parameters
    ----------
    spec : mujoco.MjSpec
        From `make_spec`.
    start : sequence of float
        Pose of the object: x, y (m), heading (rad).
    tick : float
        Time between samples of the motion, s.
    """

    def __init__(self, spec: Any, start: Sequence[float], tick: float) -> None:
        spec.option.timestep = tick / STEPS_PER_TICK
        self.tick = tick
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.command = np.zeros(3)
        x, y, heading = start
        self.data.qpos[:7] = [x, y, BALL_RADIUS_M, *world.turned(heading)]
        mujoco.mj_step(self.model, self.data, round(SETTLING_S / spec.option.timestep))
        self.data.qvel[:] = 0.0
        self.obstacles = {
            self.model.geom(k).id for k in range(self.model.ngeom) if is_obstacle(self.model, k)
        }
        self.gripper = self.model.actuator("gripper x").id
        self.grasp = self.model.site("grasp").pos[:2].copy()
        self.heading = heading

    def push(self, wrench: Floats, ticks: int) -> tuple[Floats, Floats, Floats, Floats]:
        """Push with a wrench at the grasp, which rises to it from the previous one.

        Parameters
        ----------
        wrench : ndarray, shape (3,)
            Force (N) and torque (N m), object axes.
        ticks : int
            Duration in samples.

        Returns
        -------
        poses, twists, wrenches, impulses : ndarray
            As `trundle.envs.Push.follow` requires.
        """
        poses, twists, wrenches = (np.zeros((ticks, 3)) for _ in range(3))
        impulses = np.zeros(ticks)
        short, before = self.model.opt.timestep, self.command
        for k in range(ticks * STEPS_PER_TICK):
            tick = k // STEPS_PER_TICK
            held = before + min(1.0, (k + 0.5) * short / RISE_S) * (wrench - before)
            self.data.ctrl[self.gripper : self.gripper + 3] = held
            mujoco.mj_step(self.model, self.data)
            impulses[tick] += short * self.contact_force()
            wrenches[tick] += self.about_origin(held) / STEPS_PER_TICK
            poses[tick], twists[tick] = self.pose(), self.data.qvel[[0, 1, 5]]
        self.command = wrench
        return poses, twists, wrenches, impulses

    def pose(self) -> Floats:
        """Return the pose of the object; its heading is continuous."""
        x, y, _, *rotation = self.data.qpos[:7].tolist()
        turn = heading_of(rotation) - self.heading
        self.heading += float(np.arctan2(np.sin(turn), np.cos(turn)))
        return np.array([x, y, self.heading])

    def about_origin(self, wrench: Floats) -> Floats:
        """Return a wrench at the grasp about the object's origin."""
        (x, y), (fx, fy, torque) = self.grasp, wrench
        return np.array([fx, fy, torque + x * fy - y * fx])

    def contact_force(self) -> float:
        """Return the sum of the magnitudes of the contact forces of obstacles, N."""
        if self.data.ncon == 0:
            return 0.0
        total, force = 0.0, np.empty(6)
        for k in range(self.data.ncon):
            contact = self.data.contact[k]
            if contact.geom1 in self.obstacles or contact.geom2 in self.obstacles:
                mujoco.mj_contactForce(self.model, self.data, k, force)
                total += float(np.linalg.norm(force[:3]))
        return total


def heading_of(rotation: Sequence[float]) -> float:
    """Return the heading of a rotation, a quaternion, rad."""
    w, x, y, z = rotation
    return float(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))


def is_obstacle(model: Any, geom: int) -> bool:
    """Return whether a geometry is an obstacle."""
    return str(model.geom(geom).name).startswith("obstacle")


def make_spec(
    hidden: Mapping[str, Any],
    scene: Mapping[str, Any],
    grasp: Sequence[float] | Floats,
    first: float = 0.0,
) -> Any:
    """Return an object on balls among obstacles as a `mujoco.MjSpec`.

    Parameters
    ----------
    hidden : mapping
        The object with its effects, as tables of a `model.toml`.
    scene : mapping
        From `trundle.envs.Push.scene`.
    grasp : sequence of float
        Position of the gripper, object frame, m.
    first : float
        First direction of casters from tyre to pivot, object frame, rad.

    Raises
    ------
    TrundleError
        If the plant does not contain an effect, or the object has fewer than three feet.
    """
    spec = new_spec(scene["obstacles"])
    body, feet = hidden["body"], hidden["body"].get("support", [])
    if len(feet) < 3:
        raise TrundleError(f"the object has {len(feet)} feet: choose one that stands on three or more")
    table = spec.worldbody.add_body(name="object")
    table.add_freejoint()
    laws = Laws(trundle.Model.from_toml(tomli_w.dumps(hidden)))
    add_mass(table, laws, BALL_MASS_KG * len(feet))
    add_rim(table, body)
    effects = list(hidden.get("effect", ()))
    sliding = sum(effect["force"] for effect in effects if effect["kind"] == SLIDING)
    add_feet(table, feet, sliding / (laws.mass * GRAVITY_M_PER_S2))
    for number, effect in enumerate(effects):
        add_effect(spec, table, f"effect {number}", effect, [] if sliding else feet, first)
    world.add_gripper(spec, table, Grasp(float(grasp[0]), float(grasp[1]), 0.0))
    return spec


def new_spec(obstacles: Sequence[Sequence[Sequence[float]]]) -> Any:
    """Return a world with a floor and obstacles, which are convex polygons."""
    spec = mujoco.MjSpec()
    spec.option.gravity = [0.0, 0.0, -GRAVITY_M_PER_S2]
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0
    floor = {"contype": FLOOR_BIT, "conaffinity": FLOOR_BIT, "friction": [FLOOR_FRICTION_COEFFICIENT, 0, 0]}
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[5, 5, 1], **floor)
    for number, polygon in enumerate(obstacles):
        corners = [[*corner, z] for z in (0.0, 0.2) for corner in polygon]
        spec.add_mesh(name=f"obstacle {number}", uservert=np.ravel(corners).tolist())
        spec.worldbody.add_geom(
            name=f"obstacle {number}",
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=f"obstacle {number}",
            contype=RIM_BIT,
            conaffinity=RIM_BIT,
            friction=[RIM_FRICTION_COEFFICIENT, 0, 0],
        )
    return spec


def add_mass(table: Any, laws: Laws, balls: float) -> None:
    """Give a body the mass properties of a flat object without its balls."""
    table.explicitinertial = True
    table.mass, table.ipos = laws.mass - balls, [*laws.com, 0.0]
    table.inertia = [laws.inertia / 2, laws.inertia / 2, laws.inertia]


def add_rim(table: Any, body: Mapping[str, Any]) -> None:
    """Add capsules along the outline of an object, which touch obstacles."""
    for outline in outlines(body):
        for a, b in pairwise(outline):
            table.add_geom(
                type=mujoco.mjtGeom.mjGEOM_CAPSULE,
                fromto=[*a, 0.05, *b, 0.05],
                size=[RIM_RADIUS_M, 0, 0],
                mass=0.0,
                contype=RIM_BIT,
                conaffinity=0,
                friction=[RIM_FRICTION_COEFFICIENT, 0, 0],
            )


def add_feet(table: Any, feet: Sequence[Sequence[float]], friction: float) -> None:
    """Add balls at the feet: they roll without resistance, or slide with a coefficient of friction."""
    for number, foot in enumerate(feet):
        ball = table.add_body(name=f"ball {number}", pos=[*foot, 0.0])
        if friction == 0.0:
            ball.add_joint(name=f"ball {number}", type=mujoco.mjtJoint.mjJNT_BALL)
        ball.add_geom(
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=[BALL_RADIUS_M, 0, 0],
            mass=BALL_MASS_KG,
            contype=FLOOR_BIT,
            conaffinity=0,
            # The feet's friction applies, not the larger one of floor and feet.
            priority=1,
            friction=[friction or FLOOR_FRICTION_COEFFICIENT, 0, 0],
            solref=[0.004, 1.0],
        )


def add_effect(
    spec: Any, table: Any, name: str, effect: Effect, feet: Sequence[Sequence[float]], first: float
) -> None:
    """Add a viscous wheel or a caster. `feet`: those on balls that roll."""
    kind = effect["kind"]
    if kind == SLIDING:
        return
    if kind not in ("viscous_wheel", "caster_swivel"):
        raise TrundleError(
            f"effect {kind}: the plant in MuJoCo contains viscous_wheel, caster_swivel, {SLIDING}"
        )
    place = [effect["x"], effect["y"]]
    at_feet = [number for number, foot in enumerate(feet) if list(foot) == place]
    if kind == "caster_swivel":
        world.add_caster(spec, table, name, place, first, effect["trail"], effect["mu_side"])
    elif at_feet and effect["mu_x"] == effect["mu_y"]:
        # A ball at speed v rotates at v / r. The bearing torque is r times the force at the floor.
        spec.joint(f"ball {at_feet[0]}").damping = [effect["mu_x"] * BALL_RADIUS_M**2, 0.0, 0.0]
    else:
        world.add_wheel(spec, table, name, Wheel(**{key: effect[key] for key in WHEEL_KEYS}))
