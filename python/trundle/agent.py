"""An agent that estimates how an object moves while it pushes it to a goal."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Protocol, TypeAlias, runtime_checkable

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from trundle._native import Model, Planner, Pushing, TrundleError
from trundle.belief import Belief, Update, described, modelled, rolling
from trundle.braking import braking, runs_away
from trundle.envs.observation import COMMON_ENTRIES, Observation
from trundle.learners import learner as learner_of
from trundle.picture import outlines

__all__ = ["AdaptiveAgent", "Belief", "Pushable", "Update"]

Array: TypeAlias = NDArray[np.float64]

WRENCH = 3
"""Entries of an action that are a wrench."""
MODES = ("wrench", "regrasp")
"""Meanings of actions that the agent knows."""
PERIOD = 0.05
"""Time between two actions of an environment that does not tell it, s."""
MOST_STARTS = 1000
"""Random starts of a fit beyond which nobody waits for it."""
LOCKED = 150.0
"""Drag of a wheel that is suspected to be locked, N s/m."""
DRAWS = 4
"""Models drawn from the posterior, beside the most probable one."""
MATTERS = 0.02
"""What knowing which model is true must be worth for plans to be made on several, m s."""
CURIOSITY = 1.0
"""What a probing plan is credited for each metre by which the models' ends differ, s."""
AT_REST = 0.15
"""Speed (m/s, rad/s) below which the object may be let go: a faster one would run on by itself."""
BETTER = 0.85
"""What a plan from elsewhere may cost, as a share of the best one from here, for going there."""


@runtime_checkable
class Pushable(Protocol):
    """What the agent asks of an environment, beside its spaces."""

    ACTION_SCALE: Array

    def recording_metadata(self, name: str) -> dict[str, Any]:
        """Return what a recording says of the object and the instruments."""


class AdaptiveAgent:
    """Adaptive agent for `trundle.envs.Push`'s tasks and environments with the same spaces.

    The agent starts from a model of the object (by default uniform and rolling freely), plans pushes on it
    with MPPI, keeps an online estimate of the paper's model, and replans. While it matters which of the
    models that the posterior allows is true, it plans for several of them and updates the estimate before
    each action. It brakes an object that is about to leave the workspace, whatever the model predicts. Its
    only input are the observations, unless `outline` is set.

    `predict` has the signature of stable-baselines3's algorithms, so that
    `stable_baselines3.common.evaluation.evaluate_policy` runs the agent, on vectorised environments too.

    Parameters
    ----------
    env : gymnasium.Env
        Provides the action space and scale, and what is known of the object. Its action is "wrench", or
        "regrasp": then the agent also chooses the grasp.
    model : Model, optional
        Model at the start of an episode, with all values given.
    mass : float
        Mass of the default model, kg, if the environment does not provide it.
    adapt : bool
        False: keep the first model.
    learner : {"filter", "shooting", "linear", "local"}
        The paper's model under the default likelihood (online) or under eq. 8 of the paper; linear or locally
        weighted regression instead of a model.
    diagnose : bool
        If the model predicts worse than the noise explains, diagnose which effects are missing, and continue
        with the named ones; if none is named, with the best fitted candidate, if that predicts better.
    probe : bool
        Start with several models (the object rolls freely, or a wheel near any one corner is locked), and
        while the value of information is large, prefer pushes that distinguish them (dual control).
    outline : bool
        If objects vary, start with the true outline, as a camera would see it, instead of the box in the
        observations. For one environment at a time.
    push : float
        Time between two updates, s, once little depends on them.
    pushes : int, optional
        Number of such intervals after which learning stops; None: it never stops.
    starts : int
        Random starts of each search.
    period : float, optional
        Time between two actions, s; None: the environment's `control`, or 0.05.
    rise : float
        Time in which the arm reaches an action, s.
    seed : int
        Seed of plans and searches: the same observations give the same actions.
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
        learner: str = "filter",
        diagnose: bool = False,
        probe: bool = False,
        outline: bool = False,
        push: float = 0.5,
        pushes: int | None = None,
        starts: int = 2,
        period: float | None = None,
        rise: float = 0.02,
        seed: int = 0,
        **planner: Any,
    ) -> None:
        space, entries, source = suited(env)
        period = float(getattr(source, "control", PERIOD)) if period is None else period
        if not 0 < rise < period <= push:
            raise TrundleError(
                f"rise = {rise}, period = {period}, push = {push}: give rise < period <= push (s); "
                "the period is the environment's own unless it is given"
            )
        if not 1 <= starts <= MOST_STARTS:
            raise TrundleError(f"starts = {starts}: give 1 to {MOST_STARTS}")
        if not 0 <= seed < 2**63:
            raise TrundleError(f"seed = {seed}: give a whole number from 0 to 2**63 - 1")
        if pushes is not None and pushes < 1:
            raise TrundleError(f"pushes = {pushes}: give 1 or more, or adapt = False")
        if not adapt and (diagnose or probe):
            raise TrundleError(
                "adapt = False: an agent that keeps to its belief neither diagnoses nor probes"
            )
        self._scale = np.asarray(source.ACTION_SCALE, dtype=np.float64)[:WRENCH]
        self._space, self._entries, self._source = space, entries, source
        self._obstacles: Callable[[Array], Any] = getattr(source, "seen_obstacles", lambda _: ())
        self._sees = outline
        self._varied = bool(getattr(source, "varied", False))
        self._regrasps = getattr(source, "mode", "wrench") == "regrasp"
        self._model, self._mass = model, mass
        self._adapt, self._probe = adapt, probe
        self._learner = learner_of(learner, diagnose=diagnose, starts=starts, seed=seed)
        self._period, self._rise, self._seed = period, rise, seed
        self._settings = planner
        self._hold = max(1, round(self._planner().hold / period))
        self._push = max(1, round(push / period))
        self._last_fit = np.inf if pushes is None else pushes * self._push
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
            Where it is True the belief starts anew; left out, it does so where the goal has changed: give it
            where the goal moves, as on trundle/PushPath-v0.
        deterministic : bool
            Of no effect: the agent does not explore at random.

        Returns
        -------
        actions : ndarray, shape (width,) or (n, width)
            In the action space: of width 3, or 6 where the agent may regrasp.
        state : tuple of Belief
            One for each environment; it is brought up to date by the next call, not copied.
        """
        given = np.asarray(observation, dtype=np.float64)
        vectors = np.atleast_2d(given)
        if given.ndim not in (1, 2) or vectors.shape[1] != self._entries:
            expected = f"({self._entries},) or (n, {self._entries})"
            raise TrundleError(f"an observation has shape {expected}, not {given.shape}")
        rows = [Observation(vector) for vector in vectors]
        if self._sees and len(rows) > 1:
            raise TrundleError("outline = True: the agent sees the object of one environment, not of several")
        known: Sequence[Belief | None] = self._beliefs if state is None else state
        if len(known) != len(rows):
            known = [None] * len(rows)
        if episode_start is None:
            starts = [belief is None or changed(belief, row) for belief, row in zip(known, rows, strict=True)]
        else:
            starts = np.broadcast_to(np.asarray(episode_start), len(rows)).tolist()
        pairs = zip(known, rows, starts, strict=True)
        self._beliefs = tuple(self._followed(belief, row, start) for belief, row, start in pairs)
        actions = np.array([self._act(belief) for belief in self._beliefs], dtype=np.float32)
        return actions.reshape((*given.shape[:-1], -1)), self._beliefs

    def _followed(self, belief: Belief | None, row: Observation, start: bool) -> Belief:
        """Return the belief after one more observation."""
        if belief is None or start:
            return self._begun(row)
        belief.seen.append(row)
        if self._adapt and self._due(belief):
            update = self._learner.learn(belief, self._period, self._rise)
            if update is not None:
                belief.updates.append(self._weighed(belief, update))
        return belief

    def _due(self, belief: Belief) -> bool:
        """Tell whether to fit now: after each push, or before each action while unsure."""
        steps = len(belief.seen) - 1
        return steps % (1 if unsure(belief) else self._push) == 0 and steps <= self._last_fit

    def _begun(self, row: Observation) -> Belief:
        metadata = described(self._source.recording_metadata("episode"))
        if self._varied and self._sees:
            # An outline alone: not where the object stands on the floor.
            thing = {key: value for key, value in metadata["object"].items() if key != "support"}
            metadata = {**metadata, "object": thing}
        elif self._varied:
            # Of several objects an observation tells how large this one is, and no more.
            a, b = row.half_size
            thing = {"footprint": [[-a, -b], [a, -b], [a, b], [-a, b]]}
            metadata = {**metadata, "object": thing}
        model = rolling(metadata["object"], self._mass) if self._model is None else self._model
        belief = Belief(model, self._planner(), metadata, row)
        if self._probe:
            belief.models += suspicions(metadata["object"], self._mass)
            belief.planner.be_curious(CURIOSITY)
        return belief

    def _weighed(self, belief: Belief, update: Update) -> Update:
        """Plan on several models where it matters which is true; hold elsewhere where that is better."""
        belief.plan = []
        if belief.learnt is not None:
            return update
        belief.models = (update.model,)
        inner = belief.inner(self._period)
        last = belief.updates[-1].worth if belief.updates and not update.named + update.supposed else np.inf
        # What is known is not forgotten: once the truth is worth little, it stays so.
        worth = self._worth(belief, inner) if last > MATTERS else last
        belief.planner.be_curious(CURIOSITY if self._probe and worth > MATTERS else 0.0)
        slow = np.hypot(*belief.now.velocity) < AT_REST and abs(belief.now.spin) < AT_REST
        free = self._regrasps and slow and belief.bound_for is None
        place = self._better_place(belief, inner) if free else None
        return replace(update, worth=worth, regrasp=place)

    def _worth(self, belief: Belief, inner: list[float]) -> float:
        """Return what knowing the true model is worth; where that matters, plan on several from now on."""
        draws = tuple(belief.model.drawn(self._seed + number) for number in range(DRAWS))
        models = (belief.model, *draws)
        task = (*belief.situation, belief.now.grasp, self._obstacles(belief.now.vector))
        worth = belief.planner.regret(models, *task, inner=inner)
        if worth > MATTERS:
            belief.models = models
        return worth

    def _better_place(self, belief: Belief, inner: list[float]) -> tuple[float, float] | None:
        """Send the gripper where the best plan costs clearly less, the time to go there included."""
        pose, twist, goal = belief.situation
        places = [belief.now.grasp, *holds(belief.metadata["object"])]
        costs = belief.planner.compare(
            belief.models, pose, twist, goal, places, self._obstacles(belief.now.vector), inner=inner
        )
        best = int(np.argmin(costs))
        away = np.hypot(goal[0] - pose[0], goal[1] - pose[1])
        if best == 0 or costs[best] + Pushing.REGRASP * away > BETTER * costs[0]:
            return None
        belief.bound_for = np.asarray(places[best])
        belief.planner.restart()
        return float(places[best][0]), float(places[best][1])

    def _act(self, belief: Belief) -> Array:
        if belief.bound_for is not None:
            # It has arrived when it moves no longer; where the object has no such place, beside it.
            if not belief.let_go or np.any(belief.seen[-2].grasp != belief.now.grasp):
                belief.let_go = True
                return self._going(belief, belief.bound_for)
            belief.bound_for, belief.let_go = None, False
        action = np.zeros(self._space.shape)
        if self._regrasps:
            action[-1] = -1.0
        if runs_away(belief.seen):
            belief.plan = []
            action[:WRENCH] = braking(belief.now)
        else:
            action[:WRENCH] = self._planned(belief)
        return np.clip(action, self._space.low, self._space.high)

    def _planned(self, belief: Belief) -> Array:
        """Return the next action of the plan, made anew when it is carried out; while unsure, each time."""
        if not belief.plan:
            pose, twist, goal = belief.situation
            plan = belief.planner.plan(
                belief.models,
                pose,
                twist,
                goal,
                belief.now.grasp,
                self._obstacles(belief.now.vector),
                inner=belief.inner(self._period),
                learnt=belief.learnt,
            )
            held = 1 if self._adapt and unsure(belief) else self._hold
            belief.planner.advance(held * self._period)
            belief.plan = [plan[0] / self._scale] * held
        return belief.plan.pop()

    def _going(self, belief: Belief, place: Array) -> Array:
        """Return the action that sends the gripper elsewhere; it is ignored while it goes."""
        middle, half = box(belief.metadata["object"])
        action = np.zeros(self._space.shape)
        action[3:5] = np.clip((place - middle) / half, -1.0, 1.0)
        action[5] = 1.0
        return action

    def _planner(self) -> Planner:
        low, high = self._space.low[:WRENCH] * self._scale, self._space.high[:WRENCH] * self._scale
        return Planner(low, high, seed=self._seed, **self._settings)


def suited(env: gym.Env[Any, Any]) -> tuple[gym.spaces.Box, int, Pushable]:
    """Return action space, entries of an observation and what there is to push; refuse other environments."""
    space, seen, source = env.action_space, env.observation_space, env.unwrapped
    if not isinstance(space, gym.spaces.Box) or not isinstance(source, Pushable):
        raise TrundleError(f"{source} has no object to push: give trundle/LockedWheel-v0 or its like")
    if not isinstance(seen, gym.spaces.Box):
        raise TrundleError(
            f"observations are {type(seen).__name__}, not arrays: trundle/PushPose-v0 gives some"
        )
    entries = gym.spaces.flatdim(seen)
    if entries < COMMON_ENTRIES:
        raise TrundleError(f"an observation of {entries} numbers is not that of a pushing task")
    mode = getattr(source, "mode", "wrench")
    if mode not in MODES:
        raise TrundleError(
            f"action = {mode!r}: the agent plans wrenches; make the environment with one of {MODES}"
        )
    return space, entries, source


def changed(belief: Belief, row: Observation) -> bool:
    """Return whether an observation is of another goal."""
    return not np.array_equal(belief.now.goal_vector, row.goal_vector)


def unsure(belief: Belief) -> bool:
    """Return whether it matters which model is true."""
    return not belief.updates or belief.updates[-1].worth > MATTERS


def box(thing: dict[str, Any]) -> tuple[Array, Array]:
    """Return middle and half sides of the box about a described object, object frame, m."""
    points = np.concatenate(outlines(thing))
    low, high = points.min(axis=0), points.max(axis=0)
    return (low + high) / 2, (high - low) / 2


def holds(thing: dict[str, Any]) -> Array:
    """Return where an object may be held: near corners and middles of the sides of the box about it."""
    middle, half = box(thing)
    ways = [(x, y) for x in (-1, 0, 1) for y in (-1, 0, 1) if (x, y) != (0, 0)]
    return np.asarray(middle + 0.9 * half * np.array(ways))


def suspicions(thing: dict[str, Any], mass: float) -> tuple[Model, ...]:
    """Return models of a described object with a locked wheel near one of its corners each."""
    middle, half = box(thing)
    wheel = {"kind": "viscous_wheel", "angle": 0.0, "mu_x": LOCKED, "mu_y": LOCKED}
    places = [middle + 0.85 * half * np.array(way) for way in ((-1, -1), (-1, 1), (1, -1), (1, 1))]
    return tuple(modelled(thing, mass, [{**wheel, "x": float(x), "y": float(y)}]) for x, y in places)
