"""The adaptive agent with a learned dynamics model instead of an estimated physical one."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np

from trundle._native import TrundleError
from trundle.agent import AdaptiveAgent
from trundle.agent_settings import AgentSettings
from trundle.belief import Belief, Update, about_origin
from trundle.experiments.sampling import Floats
from trundle.experiments.training.dynamics.model import DynamicsModel
from trundle.experiments.training.dynamics.motion import Motion, motion_of, shape_of

__all__ = ["DynamicsLearner", "dynamics_agent"]


class Prediction:
    """Motions of an episode's object under planned wrenches, given its motion so far.

    `trundle.Planner.plan` calls it with all plans of an iteration.
    """

    def __init__(self, model: DynamicsModel, belief: Belief) -> None:
        self._model, self._belief = model, belief
        self._context, self._seen = model.start(1), 0
        self._shape = shape_of(belief.latest.vector[None])
        self._substeps = round(belief.planner.hold / model.about.period)
        if abs(belief.planner.hold - self._substeps * model.about.period) > 1e-9 or self._substeps == 0:
            raise TrundleError(
                f"planner: hold = {belief.planner.hold}: must be a multiple of the dynamics model's step, "
                f"{model.about.period} s"
            )

    def remember(self) -> None:
        """Update the memory by the steps since the last call."""
        observations = self._belief.observations
        for k in range(self._seen, len(observations) - 1):
            steps = motion_of(np.stack([observations[k].vector, observations[k + 1].vector])[:, None])
            motion = Motion(steps.inputs[0], steps.targets[0])
            self._context = self._model.remember(self._context, motion, self._shape)
        self._seen = len(observations) - 1

    def __call__(self, plans: Floats) -> Floats:
        """Return the motions, shape (networks, n, steps, 6), under plans of shape (n, horizon, 3)."""
        latest = self._belief.latest
        held = np.repeat(plans, self._substeps, axis=1)
        now = np.broadcast_to(latest.wrench, (len(held), 1, 3))
        wrenches = np.concatenate([now, held], axis=1)
        about = np.moveaxis(about_origin(np.moveaxis(wrenches, -1, 0), latest.grasp), 0, -1)
        start = latest.pose[None], latest.twist[None]
        return self._model.rollout(self._context, self._shape, start, about)


class DynamicsLearner:
    """Learner that predicts with a dynamics model and the memory of its networks.

    Parameters
    ----------
    model : DynamicsModel
    """

    def __init__(self, model: DynamicsModel) -> None:
        self._model = model

    def begin(self, belief: Belief) -> None:
        """Let the planner use the dynamics model from the first action on."""
        belief.regression = Prediction(self._model, belief)

    def is_due(self, belief: Belief, time: float) -> bool:
        """Return False: the memory is updated before each action anyway."""
        return False

    def is_fast(self, belief: Belief) -> bool:
        """Return True: an update is one step of the memory."""
        return True

    def learn(self, belief: Belief, period: float, rise: float) -> Update | None:
        """Update the memory by the latest step."""
        if isinstance(belief.regression, Prediction):
            belief.regression.remember()
        return Update(period * (len(belief.observations) - 1), belief.model, [])


def dynamics_agent(
    env: gym.Env[Any, Any], model: DynamicsModel, settings: AgentSettings | None = None
) -> AdaptiveAgent:
    """Return an adaptive agent that plans on a dynamics model.

    The planner, its cost and the rule for braking are those of the agent. The response of the arm is not
    estimated: the model predicts the motion under measured wrenches.

    Raises
    ------
    TrundleError
        If observations lack the size of the object, or actions last longer or shorter than the model's steps.
    """
    source: Any = env.unwrapped
    if not (getattr(source, "varied", False) and getattr(source, "version", 0) > 0):
        raise TrundleError("a dynamics model needs an environment of version 1 with any of several objects")
    if abs(source.control - model.about.period) > 1e-9:
        raise TrundleError(
            f"an action lasts {source.control} s, a step of the dynamics model {model.about.period} s"
        )
    chosen = AgentSettings(arm=False) if settings is None else settings
    return AdaptiveAgent(env, chosen, learner=DynamicsLearner(model))
