"""Braking of `trundle.AdaptiveAgent` for objects with unexpected motion."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest

import trundle
import trundle.agent
from trundle.braking import MAX_TWIST, braking_action, exceeds_limits_soon
from trundle.envs import Observation


def row(twist: list[float], heading: float = 0.0, grasp: tuple[float, float] = (-0.6, 0.0)) -> Observation:
    """Return an observation with given motion, heading and grasp."""
    seen = Observation(np.zeros(18))
    seen.direction[:], seen.twist[:], seen.grasp[:] = (np.cos(heading), np.sin(heading)), twist, grasp
    return seen


@pytest.mark.parametrize(
    ("before", "now", "expected"),
    [
        ([0.0, 0.0, 3.0], [0.0, 0.0, 3.0], False),
        ([0.0, 0.0, 2.0], [0.0, 0.0, 2.6], False),
        ([0.0, 0.0, 2.0], [0.0, 0.0, 3.1], True),
        ([0.0, 0.0, -2.0], [0.0, 0.0, -3.1], True),
        ([1.1, 0.0, 0.0], [1.2, 0.8, 0.0], True),
        ([1.9, 0.0, 0.0], [1.2, 0.0, 0.0], False),
    ],
)
def test_braking_starts_if_two_more_steps_exceed_the_limits(
    before: list[float], now: list[float], expected: bool
) -> None:
    assert exceeds_limits_soon([row(before), row(now)]) is expected


def test_no_braking_at_the_start_of_an_episode() -> None:
    assert not exceeds_limits_soon([row([1.9, 0.0, 3.9])])


def test_braking_removes_energy() -> None:
    random = np.random.default_rng(0)
    for _ in range(200):
        twist, heading, grasp = random.normal(size=3), random.uniform(-3, 3), random.normal(size=2)
        push = braking_action(row(list(twist), heading, tuple(grasp)))
        cos, sin = np.cos(heading), np.sin(heading)
        arm = np.array([cos * grasp[0] - sin * grasp[1], sin * grasp[0] + cos * grasp[1]])
        force = np.array([cos * push[0] - sin * push[1], sin * push[0] + cos * push[1]])
        speed = twist[:2] + twist[2] * np.array([-arm[1], arm[0]])
        # The axes are weighted like the limits, so the power is negative on each.
        assert force @ speed < 0 and push[2] * twist[2] < 0
    assert braking_action(row([0.0, 0.0, MAX_TWIST[2]], grasp=(0.0, 0.0)))[2] == -1.0


def lost_within(seconds: float) -> bool:
    """Return whether an agent whose plan is to push as hard as possible loses a freely rolling object."""
    env = gymnasium.make("trundle/PushPose-v1", hidden="none")
    observation, _ = env.reset(seed=0)
    agent = trundle.AdaptiveAgent(env)
    for step in range(round(seconds / 0.05)):
        action, _ = agent.predict(observation, episode_start=step == 0)
        observation, _, _, _, info = env.step(action)
        if info["lost"]:
            return True
    return False


def test_braking_prevents_the_loss_of_an_object(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trundle.AdaptiveAgent, "_planned_action", lambda agent, belief: np.full(3, 0.3))
    assert not lost_within(1.5)
    monkeypatch.setattr(trundle.agent, "exceeds_limits_soon", lambda seen, late: False)
    assert lost_within(1.5)
