"""What an adaptive agent has seen of an episode, and what it makes of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import tomli_w
from numpy.typing import NDArray

from trundle._native import Laws, Model, Planner, Recording, _Regression
from trundle.envs.observation import Observation
from trundle.online import Online

__all__ = ["Belief", "Update", "described", "rolling"]

Array: TypeAlias = NDArray[np.float64]

AT_ONCE = 1e-4
"""Time in which a wrench is gone when the gripper lets go, s."""


@dataclass(frozen=True)
class Update:
    """What was learnt at one time.

    Attributes
    ----------
    time : float
        Since the episode began, s.
    model : Model
        The most probable one, fitted to all that had been seen.
    estimate : list of dict
        ``name``, ``mean``, ``sd`` (None where the data do not hold it) and ``unit`` of its parameters.
    named : tuple of str
        Effects that the diagnoser named now; empty where it was not asked, or had nothing to name.
    supposed : tuple of str
        Effects that are believed from now on though the diagnoser does not vouch for them: the best of what
        it tried does not explain everything, but predicts better.
    worth : float
        What knowing the truth would be worth, m s: see `Planner.regret`; 0 where that was not asked.
    regrasp : tuple of float, optional
        Where the agent takes hold from now on, object frame, m.
    """

    time: float
    model: Model
    estimate: Sequence[Mapping[str, Any]]
    named: tuple[str, ...] = ()
    supposed: tuple[str, ...] = ()
    worth: float = 0.0
    regrasp: tuple[float, float] | None = None


class Belief:
    """What the agent has seen of one episode, and what it makes of it.

    Attributes
    ----------
    model : Model
        The most probable one.
    models : tuple of Model
        What plans are made on: that, or several as probable where the difference matters.
    updates : list of Update
        One for each fit.
    consulted : float
        When the diagnoser last answered, s since the episode began; 0: never.
    bound_for : ndarray or None
        Where the gripper is sent, object frame, m; None while it holds.
    let_go : bool
        Whether it has been told so.
    template : Model or None
        The laws that are fitted, values free; None: the paper's.
    online : Online, optional
        The estimate of these laws, kept up to date.
    learnt : regression, optional
        What plans are made on in the place of laws.
    """

    def __init__(self, model: Model, planner: Planner, metadata: dict[str, Any], first: Observation) -> None:
        self.models: tuple[Model, ...] = (model,)
        self.planner = planner
        self.metadata = metadata
        self.updates: list[Update] = []
        self.template: Model | None = None
        self.online: Online | None = None
        self.learnt: _Regression | None = None
        self.consulted = 0.0
        self.plan: list[Array] = []
        self.seen: list[Observation] = [first]
        self.bound_for: Array | None = None
        self.let_go = False

    @property
    def model(self) -> Model:
        """The most probable model."""
        return self.models[0]

    @property
    def fits(self) -> int:
        """How often it has been fitted."""
        return len(self.updates)

    @property
    def now(self) -> Observation:
        """The last observation."""
        return self.seen[-1]

    @property
    def situation(self) -> tuple[Array, Array, Array]:
        """Pose and twist of the object, and goal, as the planner takes them."""
        return self.now.pose, self.now.twist, self.now.goal_pose

    def inner(self, period: float) -> list[float]:
        """Return where the laws' own states are by now (the angle of a caster, …), from the motion seen."""
        laws = Laws(self.model)
        own = laws.starts
        if not own:
            return own
        for row, felt in zip(self.seen, self.seen[1:], strict=False):
            wrench = about_origin(felt.wrench, row.grasp)
            *_, own = laws.step(row.pose, row.twist, wrench, period, inner=own)
        return own

    def recording(self, period: float, rise: float) -> Recording:
        """Return all that was seen, as a recording of one episode."""
        return Recording(self.metadata, {"episode_00": self.columns(period, rise)})

    def columns(self, period: float, rise: float) -> dict[str, Array]:
        """Return the episode's table: what was observed, one reading more where the wrench stops rising."""
        seen = self._stacked()
        (x, y), (cos, sin) = seen.position.T, seen.direction.T
        (grasp_x, grasp_y), (force_x, force_y) = seen.grasp.T, seen.force.T
        table = {
            "t": period * np.arange(len(x)),
            "object_x": x,
            "object_y": y,
            "object_theta": seen.heading,
            "gripper_x": x + cos * grasp_x - sin * grasp_y,
            "gripper_y": y + sin * grasp_x + cos * grasp_y,
            "gripper_theta": seen.heading,
            "force_x": force_x,
            "force_y": force_y,
            "torque_z": seen.torque,
        }
        # An action is held once the arm has reached it: what is read at its end was there all the time.
        # When the gripper lets go, the wrench is gone at once.
        held = {key: np.full(len(x) - 1, np.nan) for key in table}
        for key in ("force_x", "force_y", "torque_z"):
            held[key] = table[key][1:]
        held["t"] = table["t"][:-1] + np.where(moved(seen), AT_ONCE, rise)
        order = np.argsort(np.concatenate([table["t"], held["t"]]))
        return {key: np.concatenate([table[key], held[key]])[order] for key in table}

    def transitions(self, period: float, rise: float) -> tuple[Array, Array, Array, Array]:
        """Return states before, mean wrenches about the object's origin, durations, and states after.

        Shapes (n, 6), (n, 3), (n,), (n, 6); units and frames as in `trundle.baselines`.
        """
        seen = self._stacked()
        states = np.column_stack([seen.position, np.unwrap(seen.heading), seen.twist])
        share = np.where(moved(seen), 0.0, rise / period / 2)[:, None]
        felt = share * seen.wrench[:-1] + (1 - share) * seen.wrench[1:]
        wrench = about_origin(felt.T, seen.grasp[:-1].T).T
        return states[:-1], np.ascontiguousarray(wrench), np.full(len(felt), period), states[1:]

    def _stacked(self) -> Observation:
        """Return all observations as one batch, shape (n, entries)."""
        return Observation(np.array([row.vector for row in self.seen]))


def moved(seen: Observation) -> NDArray[np.bool_]:
    """Return for each step between observations whether the gripper had let go and went elsewhere."""
    goes: NDArray[np.bool_] = np.any(seen.grasp[1:] != seen.grasp[:-1], axis=1)
    return goes


def about_origin(felt: Array, grasp: Array) -> Array:
    """Return a wrench at the grasp as one about the object's origin; components along the first axis."""
    return np.stack([felt[0], felt[1], felt[2] + grasp[0] * felt[1] - grasp[1] * felt[0]])


def described(metadata: dict[str, Any]) -> dict[str, Any]:
    """Return the metadata of a recording of observations.

    Readings are tared already, and obstacles are left out: the agent keeps off them.
    """
    wrench = {"frame": "sensor", "sign": "on_object", "raw": False, "contact": "grasp"}
    return {**{key: value for key, value in metadata.items() if key != "scene"}, "wrench": wrench}


def rolling(thing: dict[str, Any], mass: float) -> Model:
    """Return the model of a described object that is uniform and rolls freely."""
    return modelled(thing, mass, [])


def modelled(thing: dict[str, Any], mass: float, effects: list[dict[str, Any]]) -> Model:
    """Return the model of a described object, uniform, with effects."""
    body = {key: thing[key] for key in ("footprint", "fixture", "support") if thing.get(key)}
    body["mass"] = thing.get("mass", mass)
    return Model.from_toml(tomli_w.dumps({"format": "trundle-model/1", "body": body, "effect": effects}))
