"""Agents of the arena: a planner with true, nominal or estimated parameters, and a trained policy."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

from trundle._native import TrundleError
from trundle.experiments.arena.estimator import Estimator
from trundle.experiments.arena.planner import ACTIONS_PER_KNOT, Planner
from trundle.experiments.arena.simulator import Simulator
from trundle.experiments.arena.training import load
from trundle.experiments.arena.world import NOMINAL, Hidden
from trundle.experiments.sampling import Floats

__all__ = ["AGENTS", "Agent", "make_agent"]

AGENTS = ("oracle", "nominal", "adaptive", "ppo")
"""True parameters; the benchmark's own; estimated ones; a policy without a model."""


class Agent(Protocol):
    """Chooses actions."""

    def act(self, observation: Floats) -> Floats:
        """Return the position to command (2,), px, for an observation (5,)."""

    def see(self, action: Floats, observation: Floats) -> None:
        """Learn from the observation (5,) after an action."""


class PlanningAgent:
    """Plans every `ACTIONS_PER_KNOT` actions, on a simulator with known or estimated parameters."""

    def __init__(self, hidden: Hidden, physics: str, observation: Floats, seed: int, adaptive: bool) -> None:
        state = Simulator.start(observation)
        self.physics, self.simulator, self.planner = physics, Simulator(hidden, physics, state), Planner(seed)
        self.estimator = Estimator(physics, state, seed) if adaptive else None
        self.count, self.target = 0, observation[:2]

    def act(self, observation: Floats) -> Floats:
        """Return the position of the plan."""
        if self.count % ACTIONS_PER_KNOT == 0:
            if self.estimator is not None:
                self.simulator = Simulator(self.estimator.estimate, self.physics, self.simulator.state)
            self.target = self.planner.act(self.simulator)
        self.count += 1
        return self.target

    def see(self, action: Floats, observation: Floats) -> None:
        """Follow the episode."""
        self.simulator.track(action, observation)
        if self.estimator is not None:
            self.estimator.track(action, observation)


def make_agent(
    name: str, hidden: Hidden, physics: str, observation: Floats, seed: int, policy: Path | None = None
) -> Agent:
    """Return an agent for an episode that begins with an observation. Only the oracle uses `hidden`.

    Raises
    ------
    TrundleError
        If there is no such agent, or the policy is missing.
    """
    if name not in AGENTS:
        raise TrundleError(f"agent = {name!r}: choose {', '.join(AGENTS)}")
    if name == "ppo":
        if policy is None:
            raise TrundleError("agent = 'ppo': no policy given: train one with --train STEPS")
        return load(policy)
    known = hidden if name == "oracle" else NOMINAL
    return PlanningAgent(known, physics, observation, seed, adaptive=name == "adaptive")
