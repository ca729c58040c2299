"""An agent that learns how an object moves while it pushes it to a goal."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeAlias, runtime_checkable

import gymnasium as gym
import numpy as np
import tomli_w
from numpy.typing import NDArray

from trundle._native import Model, Planner, Recording, TrundleError
from trundle.diagnosis import fit

__all__ = ["AdaptiveAgent", "Belief", "Pushable"]

Array: TypeAlias = NDArray[np.float64]

OBSERVATION = 16
"""Entries that every observation begins with, as `trundle.envs.Push` describes them."""


@runtime_checkable
class Pushable(Protocol):
    """What the agent asks of an environment, beside its spaces."""

    ACTION_SCALE: Array

    def recording_metadata(self, name: str) -> dict[str, Any]:
        """Return what a recording says of the object and the instruments."""


class Belief:
    """What the agent has seen of one episode, and what it makes of it.

    Attributes
    ----------
    model : Model
        The model that plans are made on.
    fits : int
        How often it has been fitted.
    """

    def __init__(self, model: Model, planner: Planner, first: Array) -> None:
        self.model = model
        self.fits = 0
        self.planner = planner
        self.plan: list[Array] = []
        self.seen: list[Array] = [first]

    @property
    def goal(self) -> Array:
        """The goal's entries of an observation."""
        return self.seen[-1][7:11]

    def columns(self, period: float, rise: float) -> dict[str, Array]:
        """Return the episode's table: what was observed, one reading more where the wrench stops rising."""
        seen = np.array(self.seen)
        theta = np.arctan2(seen[:, 3], seen[:, 2])
        cos, sin = seen[:, 2], seen[:, 3]
        grasp_x, grasp_y = seen[:, 14], seen[:, 15]
        table = {
            "t": period * np.arange(len(seen)),
            "object_x": seen[:, 0],
            "object_y": seen[:, 1],
            "object_theta": theta,
            "gripper_x": seen[:, 0] + cos * grasp_x - sin * grasp_y,
            "gripper_y": seen[:, 1] + sin * grasp_x + cos * grasp_y,
            "gripper_theta": theta,
            "force_x": seen[:, 11],
            "force_y": seen[:, 12],
            "torque_z": seen[:, 13],
        }
        # An action is held once the arm has reached it: what is read at its end was there all the time.
        held = {key: np.full(len(seen) - 1, np.nan) for key in table}
        for key in ("force_x", "force_y", "torque_z"):
            held[key] = table[key][1:]
        held["t"] = table["t"][:-1] + rise
        order = np.argsort(np.concatenate([table["t"], held["t"]]))
        return {key: np.concatenate([table[key], held[key]])[order] for key in table}


class AdaptiveAgent:
    """Push, fit, replan: an agent for `trundle/LockedWheel-v0` and environments with its spaces.

    It begins with a belief about the object (by default that it is uniform and rolls freely), plans pushes
    on it by MPPI, fits the paper's model to the episode so far after each push, and goes on planning on
    what was found. All that it uses is in the observations.

    An agent has the `predict` of stable-baselines3's algorithms, so that
    `stable_baselines3.common.evaluation.evaluate_policy` runs it, on vectorised environments too.

    Parameters
    ----------
    env : gymnasium.Env
        Asked once for the action space and scale, and for what is known of the object.
    model : Model, optional
        Belief at the start of an episode, with all values given.
    mass : float
        Mass of the default belief, kg, where the environment does not tell it.
    adapt : bool
        False: keep to the first belief.
    push : float
        Time from one fit to the next, s.
    starts : int
        Random starts of each fit.
    period : float
        Time between two actions, s.
    rise : float
        Time in which the arm reaches an action, s.
    seed : int
        Of plans and fits: the same observations give the same actions.
    **planner
        Settings of `trundle.Planner`.

    Raises
    ------
    TrundleError
        If the environment is of another kind, or a setting makes no sense.

    Examples
    --------
    >>> import gymnasium, trundle
    >>> env = gymnasium.make("trundle/LockedWheel-v0")
    >>> agent = trundle.AdaptiveAgent(env)
    >>> observation, info = env.reset(seed=0)
    >>> action, state = agent.predict(observation, episode_start=True)
    """

    def __init__(
        self,
        env: gym.Env[Any, Any],
        *,
        model: Model | None = None,
        mass: float = 22.0,
        adapt: bool = True,
        push: float = 0.5,
        starts: int = 2,
        period: float = 0.05,
        rise: float = 0.02,
        seed: int = 0,
        **planner: Any,
    ) -> None:
        space, source = env.action_space, env.unwrapped
        if not isinstance(space, gym.spaces.Box) or not isinstance(source, Pushable):
            raise TrundleError(f"{source} has no object to push: give trundle/LockedWheel-v0 or its like")
        if not 0 < rise < period <= push:
            raise TrundleError(
                f"rise = {rise}, period = {period}, push = {push}: give rise < period <= push (s)"
            )
        if starts < 1:
            raise TrundleError(f"starts = {starts}: at least one start is needed")
        mode = getattr(source, "mode", "wrench")
        if mode != "wrench":
            raise TrundleError(
                f"action = {mode!r}: the agent plans wrenches; make the environment with 'wrench'"
            )
        self._scale = np.asarray(source.ACTION_SCALE, dtype=np.float64)
        self._space = space
        self._entries = gym.spaces.flatdim(env.observation_space)
        if self._entries < OBSERVATION:
            raise TrundleError(f"an observation of {self._entries} numbers is not that of a pushing task")
        self._obstacles: Callable[[Array], Any] = getattr(source, "seen_obstacles", lambda _: ())
        self._metadata = described(source.recording_metadata("episode"))
        self._first = rolling(self._metadata["object"], mass) if model is None else model
        self._adapt = adapt
        self._starts = starts
        self._period, self._rise, self._seed = period, rise, seed
        self._settings = planner
        self._hold = max(1, round(self._planner().hold / period))
        self._push = max(1, round(push / period))
        self._beliefs: tuple[Belief, ...] = ()

    @property
    def beliefs(self) -> tuple[Belief, ...]:
        """What is believed now of each environment's object."""
        return self._beliefs

    def predict(
        self,
        observation: Any,
        state: tuple[Belief, ...] | None = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.float32], tuple[Belief, ...]]:
        """Choose the next action of each environment.

        Parameters
        ----------
        observation : ndarray, shape (entries,) or (n, entries)
            Of one environment, or of n.
        state : tuple of Belief, optional
            As returned by the call before; the agent remembers it if it is left out.
        episode_start : bool or ndarray of bool, shape (n,), optional
            Where it is True the belief starts anew, as it does where the goal has changed.
        deterministic : bool
            Of no effect: the agent does not explore at random.

        Returns
        -------
        actions : ndarray, shape (3,) or (n, 3)
            In the action space.
        state : tuple of Belief
            One for each environment; it is brought up to date by the next call, not copied.
        """
        rows = np.asarray(observation, dtype=np.float64)
        many = np.atleast_2d(rows)
        if rows.ndim not in (1, 2) or many.shape[1] != self._entries:
            wanted = f"({self._entries},) or (n, {self._entries})"
            raise TrundleError(f"an observation has shape {wanted}, not {rows.shape}")
        known: Sequence[Belief | None] = self._beliefs if state is None else state
        if len(known) != len(many):
            known = [None] * len(many)
        starts = np.broadcast_to(np.asarray(False if episode_start is None else episode_start), len(many))
        pairs = zip(known, many, starts, strict=True)
        self._beliefs = tuple(self._followed(belief, row, bool(start)) for belief, row, start in pairs)
        actions = np.array([self._act(belief) for belief in self._beliefs], dtype=np.float32)
        return actions.reshape((*rows.shape[:-1], 3)), self._beliefs

    def _followed(self, belief: Belief | None, row: Array, start: bool) -> Belief:
        """Return the belief after one more observation."""
        if belief is None or start or not np.array_equal(belief.goal, row[7:11]):
            return Belief(self._first, self._planner(), row)
        belief.seen.append(row)
        if self._adapt and (len(belief.seen) - 1) % self._push == 0:
            self._learn(belief)
        return belief

    def _learn(self, belief: Belief) -> None:
        episode = belief.columns(self._period, self._rise)
        recording = Recording(self._metadata, {"episode_00": episode})
        try:
            # It keeps off obstacles: what moves the object is the push alone.
            belief.model = fit(recording, starts=self._starts, seed=self._seed, obstacles=False).model
        except TrundleError:
            # Too little has been moved yet to tell anything.
            return
        belief.fits += 1

    def _act(self, belief: Belief) -> Array:
        if not belief.plan:
            now = belief.seen[-1]
            angle, aim = np.arctan2(now[3], now[2]), np.arctan2(now[10], now[9])
            plan = belief.planner.plan(
                belief.model,
                (now[0], now[1], angle),
                now[4:7],
                (now[7], now[8], aim),
                now[14:16],
                self._obstacles(now),
            )
            belief.planner.advance(self._hold * self._period)
            belief.plan = [plan[0] / self._scale] * self._hold
        return np.clip(belief.plan.pop(), self._space.low, self._space.high)

    def _planner(self) -> Planner:
        low, high = self._space.low * self._scale, self._space.high * self._scale
        return Planner(low, high, seed=self._seed, **self._settings)


def described(metadata: dict[str, Any]) -> dict[str, Any]:
    """Return the metadata of a recording of observations: readings are tared already."""
    wrench = {"frame": "sensor", "sign": "on_object", "raw": False, "contact": "grasp"}
    return {**metadata, "wrench": wrench}


def rolling(thing: dict[str, Any], mass: float) -> Model:
    """Return the model of a described object that is uniform and rolls freely."""
    body = {key: thing[key] for key in ("footprint", "fixture", "support") if thing.get(key)}
    body["mass"] = thing.get("mass", mass)
    return Model.from_toml(tomli_w.dumps({"format": "trundle-model/1", "body": body}))
