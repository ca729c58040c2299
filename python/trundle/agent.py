"""Adaptive control: an agent that estimates the physics of an object while pushing it to a goal."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Protocol, TypeAlias, runtime_checkable

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from trundle._native import Model, Planner, Pushing, TrundleError, _ArmEstimate
from trundle.agent_settings import AgentSettings
from trundle.belief import Belief, Update, observation_metadata
from trundle.braking import braking_action, exceeds_limits_soon
from trundle.display import Card, Displayed
from trundle.envs.observation import COMMON_ENTRIES, Observation
from trundle.envs.seen_outline import observed_shape
from trundle.first_models import bounding_box, freely_rolling_model, locked_corner_models
from trundle.learners import DiagnosisSettings, Learner, make_learner

__all__ = ["AdaptiveAgent", "Belief", "Pushable", "Update"]

Array: TypeAlias = NDArray[np.float64]

WRENCH_ENTRIES = 3
"""Number of entries of an action that are a wrench."""
ACTION_MODES = ("wrench", "regrasp")
"""Meanings of an action that the agent supports."""
POSTERIOR_DRAWS = 4
"""Number of models drawn from the posterior in addition to the most probable one."""
MIN_VALUE_OF_INFORMATION = 0.02
"""Value of information above which the agent plans for several models, m s."""
PROBING_WEIGHT_S = 1.0
"""Credit of a probing plan per metre between the final positions that the models predict, s."""
MAX_RELEASE_SPEED = 0.15
"""Maximum speed (m/s) and spin (rad/s) of an object that the gripper may release. A faster one rolls on."""
MAX_REGRASP_COST_RATIO = 0.85
"""The gripper regrasps if the best plan costs at most this share of the best one from the present grasp."""
GRASP_MARGIN = 0.9
"""Positions of grasps, as a share of half the sides of the bounding box."""


@runtime_checkable
class Pushable(Protocol):
    """What the agent requires of an environment in addition to its spaces."""

    ACTION_SCALE: Array
    """Wrench of a full action, N and N m; shape (3,) or more."""

    def recording_metadata(self, name: str) -> dict[str, Any]:
        """Return the content of `recording.toml`: the visible object, and the noise of the instruments."""


class AdaptiveAgent(Displayed):
    """Adaptive agent for `trundle.envs.Push`'s tasks and environments with the same spaces.

    The agent starts from a model of the object. Before each action it estimates a rigid body on viscous
    wheels by linear regression and plans on it with MPPI. It also estimates delay, lag and compliance of the
    arm, and plans from the time at which the next command takes effect.
    If the object is about to exceed a speed limit, it brakes, independently of the model. Its only input are
    the observations, unless the setting `outline` is True.

    `predict` has the signature of stable-baselines3's algorithms, so that
    `stable_baselines3.common.evaluation.evaluate_policy` runs the agent, on vectorised environments too.

    Parameters
    ----------
    env : gymnasium.Env
        Environment with the action "wrench", or "regrasp": then the agent also chooses the grasp. It
        provides the spaces, the action scale and a description of the object.
    settings : AgentSettings, optional
        By default `AgentSettings()`.
    model : Model, optional
        Model at the start of an episode. Must contain a value for every parameter. By default the object is
        uniform and rolls freely.
    learner : Learner, optional
        An object with the methods of `trundle.learners.Learner`, instead of the learner of the settings.

    Raises
    ------
    TrundleError
        If the agent does not support the environment, or a setting is invalid.

    Examples
    --------
    >>> import gymnasium, trundle
    >>> env = gymnasium.make("trundle/LockedWheel-v0")
    >>> agent = trundle.AdaptiveAgent(env, trundle.AgentSettings(starts=3))
    >>> observation, info = env.reset(seed=0)
    >>> action, state = agent.predict(observation, episode_start=True)
    """

    def __init__(
        self,
        env: gym.Env[Any, Any],
        settings: AgentSettings | None = None,
        *,
        model: Model | None = None,
        learner: Learner | None = None,
    ) -> None:
        chosen = AgentSettings() if settings is None else settings
        self._space, self._entries, self._source = require_supported(env)
        self._settings, self._model = chosen, model
        self._scale = np.asarray(self._source.ACTION_SCALE, dtype=np.float64)[:WRENCH_ENTRIES]
        self._obstacles: Callable[[Array], Any] = getattr(self._source, "seen_obstacles", lambda _: ())
        self._has_varied_objects = bool(getattr(self._source, "varied", False))
        self._can_regrasp = getattr(self._source, "mode", "wrench") == "regrasp"
        diagnosis = DiagnosisSettings(chosen.diagnosis_delay, chosen.realtime) if chosen.diagnose else None
        own = make_learner(chosen.learner, diagnosis, starts=chosen.starts, seed=chosen.seed)
        self._learner = own if learner is None else learner
        self._period = chosen.control_period(self._source)
        self._steps_per_plan = max(1, round(self._make_planner().hold / self._period))
        self._steps_per_update = max(1, round(chosen.push / self._period))
        self._last_learning_step = np.inf if chosen.pushes is None else chosen.pushes * self._steps_per_update
        self._beliefs: tuple[Belief, ...] = ()

    def _card(self) -> Card:
        adapts = "estimates while pushing" if self._settings.adapt else "keeps its first model"
        facts = [
            ("model", f"{adapts}{', starts with several models' if self._settings.probe else ''}"),
            (
                "episodes",
                f"{len(self._beliefs)} in progress, {sum(len(b.updates) for b in self._beliefs)} updates",
            ),
            ("actions", f"every {self._period:.3g} s, one plan per {self._steps_per_plan} actions"),
        ]
        return Card("trundle.AdaptiveAgent", facts)

    @property
    def beliefs(self) -> tuple[Belief, ...]:
        """Present belief about the object of each environment."""
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
            Observations of one environment or of n.
        state : tuple of Belief, optional
            The state that the previous call returned; by default the agent's own copy of it.
        episode_start : bool or ndarray of bool, shape (n,), optional
            Where it is True, a new episode begins. By default a new goal begins an episode, so this argument
            is required where the goal moves, as on trundle/PushPath-v0.
        deterministic : bool
            Ignored: the agent does not explore at random.

        Returns
        -------
        actions : ndarray, shape (width,) or (n, width)
            Actions in the action space, of width 3, or 6 for "regrasp".
        state : tuple of Belief
            One belief for each environment. The next call updates it in place.

        Raises
        ------
        TrundleError
            If the observations have another shape or are not finite.
        """
        given = np.asarray(observation, dtype=np.float64)
        vectors = np.atleast_2d(given)
        if given.ndim not in (1, 2) or vectors.shape[1] != self._entries:
            expected = f"({self._entries},) or (n, {self._entries})"
            raise TrundleError(f"observations must have shape {expected}, not {given.shape}")
        seen = [Observation(vector) for vector in vectors]
        if self._settings.outline and len(seen) > 1:
            raise TrundleError(f"outline = True, {len(seen)} observations: it is for one environment only")
        known: Sequence[Belief | None] = self._beliefs if state is None else state
        if len(known) != len(seen):
            known = [None] * len(seen)
        if episode_start is None:
            starts = [
                belief is None or has_new_goal(belief, one) for belief, one in zip(known, seen, strict=True)
            ]
        else:
            starts = np.broadcast_to(np.asarray(episode_start), len(seen)).tolist()
        rows = zip(known, seen, starts, strict=True)
        self._beliefs = tuple(self._update(belief, one, start) for belief, one, start in rows)
        actions = np.array([self._act(belief) for belief in self._beliefs], dtype=np.float32)
        for belief, action in zip(self._beliefs, actions, strict=True):
            belief.command = action[:WRENCH_ENTRIES] * self._scale
        return actions.reshape((*given.shape[:-1], -1)), self._beliefs

    def _update(self, belief: Belief | None, observation: Observation, starts_episode: bool) -> Belief:
        """Return the belief after one more observation."""
        if belief is not None and starts_episode:
            belief.end()
        if belief is None or starts_episode:
            return self._first_belief(observation)
        belief.observe(observation)
        if self._settings.adapt and self._is_update_due(belief):
            update = self._learner.learn(belief, self._period, self._settings.rise)
            if update is not None:
                belief.updates.append(self._apply(belief, update))
        return belief

    def _is_update_due(self, belief: Belief) -> bool:
        """Return whether to fit now: before each action, or after each push."""
        steps = len(belief.observations) - 1
        interval = 1 if self._decides_each_action(belief) else self._steps_per_update
        is_due = steps % interval == 0 or self._learner.is_due(belief, self._period * steps)
        return is_due and steps <= self._last_learning_step

    def _decides_each_action(self, belief: Belief) -> bool:
        """Return whether to fit and plan before each action: that is fast, or the models still differ."""
        return self._learner.is_fast(belief) or (self._settings.adapt and is_uncertain(belief))

    def _first_belief(self, observation: Observation) -> Belief:
        """Return the belief at the start of an episode."""
        metadata = observation_metadata(self._source.recording_metadata("episode"))
        if self._has_varied_objects and self._settings.outline:
            # The outline only, not the positions of the feet.
            description = {key: value for key, value in metadata["object"].items() if key != "support"}
            metadata = {**metadata, "object": description}
        elif self._has_varied_objects:
            # The agent may use the shape in the observation only.
            shape = observed_shape(observation, self._source)
            metadata = {**metadata, "object": {"footprint": shape.tolist()}}
        description = metadata["object"]
        model = freely_rolling_model(description, self._settings.mass) if self._model is None else self._model
        arm = _ArmEstimate(self._period, self._settings.rise, self._scale) if self._settings.arm else None
        belief = Belief(model, self._make_planner(), metadata, observation, arm)
        if self._settings.probe:
            belief.models += locked_corner_models(description, self._settings.mass)
            belief.planner.be_curious(PROBING_WEIGHT_S)
        self._learner.begin(belief)
        return belief

    def _apply(self, belief: Belief, update: Update) -> Update:
        """Choose the models to plan for, and the grasp; return the update with these decisions."""
        belief.plan = []
        if belief.regression is not None:
            return update
        belief.models = (update.model,)
        inner = belief.inner_states(self._period)
        has_new_effects = bool(update.named + update.supposed)
        last = belief.updates[-1].value_of_information if belief.updates and not has_new_effects else np.inf
        # Once the value of information is small, it stays small until the model gains effects.
        is_fast = self._learner.is_fast(belief)
        value = 0.0 if is_fast else last
        if value > MIN_VALUE_OF_INFORMATION:
            value = self._value_of_information(belief, inner)
        is_probing = self._settings.probe and value > MIN_VALUE_OF_INFORMATION
        belief.planner.be_curious(PROBING_WEIGHT_S if is_probing else 0.0)
        now = belief.latest
        is_slow = np.hypot(*now.velocity) < MAX_RELEASE_SPEED and abs(now.spin) < MAX_RELEASE_SPEED
        is_time = not is_fast or (len(belief.observations) - 1) % self._steps_per_update == 0
        may_regrasp = self._can_regrasp and is_slow and is_time and belief.next_grasp is None
        grasp = self._choose_regrasp(belief, inner) if may_regrasp else None
        return replace(update, value_of_information=value, regrasp=grasp)

    def _value_of_information(self, belief: Belief, inner: list[float]) -> float:
        """Return the value of information, m s; if it is large, plan for posterior draws from now on."""
        draws = tuple(belief.model.drawn(self._settings.seed + number) for number in range(POSTERIOR_DRAWS))
        models = (belief.model, *draws)
        task = (*belief.situation, belief.latest.grasp, self._obstacles(belief.latest.vector))
        value = belief.planner.regret(models, *task, inner=inner, arm=belief.arm)
        if value > MIN_VALUE_OF_INFORMATION:
            belief.models = models
        return value

    def _choose_regrasp(self, belief: Belief, inner: list[float]) -> tuple[float, float] | None:
        """Return a grasp point with a clearly cheaper plan, and start moving there; None: keep the grasp.

        The cost of a regrasp includes its duration times the present distance to the goal.
        """
        pose, twist, goal = belief.situation
        grasps = [belief.latest.grasp, *grasp_candidates(belief.metadata["object"])]
        obstacles = self._obstacles(belief.latest.vector)
        costs = belief.planner.compare(
            belief.models, pose, twist, goal, grasps, obstacles, inner=inner, arm=belief.arm
        )
        best = int(np.argmin(costs))
        distance = np.hypot(goal[0] - pose[0], goal[1] - pose[1])
        if best == 0 or costs[best] + Pushing.REGRASP * distance > MAX_REGRASP_COST_RATIO * costs[0]:
            return None
        belief.next_grasp = np.asarray(grasps[best])
        belief.planner.restart()
        return float(grasps[best][0]), float(grasps[best][1])

    def _act(self, belief: Belief) -> Array:
        """Return the next action, shape (3,) or (6,), in the action space."""
        if belief.next_grasp is not None:
            # The gripper has arrived when it no longer moves. It may stop at the nearest point on the object.
            previous = belief.observations[-2:][0]
            if not belief.has_released or np.any(previous.grasp != belief.latest.grasp):
                belief.has_released = True
                return self._regrasp_action(belief, belief.next_grasp)
            belief.next_grasp, belief.has_released = None, False
        action = np.zeros(self._space.shape)
        if self._can_regrasp:
            action[-1] = -1.0
        delay = 0.0 if belief.arm is None else belief.arm.delay
        if exceeds_limits_soon(belief.observations, delay / self._period):
            belief.plan = []
            action[:WRENCH_ENTRIES] = braking_action(belief.latest)
        else:
            action[:WRENCH_ENTRIES] = self._planned_action(belief)
        return np.clip(action, self._space.low, self._space.high)

    def _planned_action(self, belief: Belief) -> Array:
        """Return the next action of the plan, shape (3,); replan when it is empty."""
        if not belief.plan:
            pose, twist, goal = belief.situation
            plan = belief.planner.plan(
                belief.models,
                pose,
                twist,
                goal,
                belief.latest.grasp,
                self._obstacles(belief.latest.vector),
                inner=belief.inner_states(self._period),
                learnt=belief.regression,
                arm=belief.arm,
            )
            steps = 1 if self._decides_each_action(belief) else self._steps_per_plan
            belief.planner.advance(steps * self._period)
            belief.plan = [plan[0] / self._scale] * steps
        return belief.plan.pop()

    def _regrasp_action(self, belief: Belief, grasp: Array) -> Array:
        """Return the action that sends the gripper to a grasp point; it is ignored while it moves."""
        middle, half = bounding_box(belief.metadata["object"])
        action = np.zeros(self._space.shape)
        action[3:5] = np.clip((grasp - middle) / half, -1.0, 1.0)
        action[5] = 1.0
        return action

    def _make_planner(self) -> Planner:
        low = self._space.low[:WRENCH_ENTRIES] * self._scale
        high = self._space.high[:WRENCH_ENTRIES] * self._scale
        limit = {"rollouts": self._settings.rollouts}
        return Planner(low, high, seed=self._settings.seed, **limit | self._settings.planner)


def require_supported(env: gym.Env[Any, Any]) -> tuple[gym.spaces.Box, int, Pushable]:
    """Return action space, number of entries of an observation, and the unwrapped environment.

    Raises
    ------
    TrundleError
        If the agent does not support the environment.
    """
    space, seen, source = env.action_space, env.observation_space, env.unwrapped
    if not isinstance(space, gym.spaces.Box) or not isinstance(source, Pushable):
        raise TrundleError(
            f"{source} has no object to push: use a pushing environment such as trundle/LockedWheel-v0"
        )
    if not isinstance(seen, gym.spaces.Box):
        raise TrundleError(
            f"observations are {type(seen).__name__}, not arrays: use one such as trundle/PushPose-v0"
        )
    entries = gym.spaces.flatdim(seen)
    if entries < COMMON_ENTRIES:
        raise TrundleError(
            f"observations have {entries} entries, those of a pushing environment at least {COMMON_ENTRIES}"
        )
    mode = getattr(source, "mode", "wrench")
    if mode not in ACTION_MODES:
        raise TrundleError(
            f"action = {mode!r}: the agent plans wrenches; make the environment with one of {ACTION_MODES}"
        )
    return space, entries, source


def has_new_goal(belief: Belief, observation: Observation) -> bool:
    """Return whether an observation has another goal than the previous one."""
    return not np.array_equal(belief.latest.goal_vector, observation.goal_vector)


def is_uncertain(belief: Belief) -> bool:
    """Return whether the value of information is large or unknown."""
    return not belief.updates or belief.updates[-1].value_of_information > MIN_VALUE_OF_INFORMATION


def grasp_candidates(description: dict[str, Any]) -> Array:
    """Return grasp points near corners and middles of the bounding box, shape (8, 2), object frame, m."""
    middle, half = bounding_box(description)
    ways = [(x, y) for x in (-1, 0, 1) for y in (-1, 0, 1) if (x, y) != (0, 0)]
    return np.asarray(middle + GRASP_MARGIN * half * np.array(ways))
