"""`trundle.AdaptiveAgent`: goals, benefit of adaptation, and protocol."""

from __future__ import annotations

import itertools
import subprocess
import sys
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from numpy.typing import NDArray

import trundle
from tests.control.episodes import Episode, play, truth

ROOT = Path(__file__).resolve().parents[2]
SEEDS = range(8)
Observations = list[NDArray[np.float64]]


@pytest.fixture(scope="module")
def env() -> gymnasium.Env[Any, Any]:
    return gymnasium.make("trundle/LockedWheel-v0")


@pytest.fixture(scope="module")
def learnt() -> list[Episode]:
    return [play(seed, adapt=True) for seed in SEEDS]


@pytest.fixture(scope="module")
def pushed() -> tuple[Observations, trundle.Model, trundle.agent.Belief]:
    """Return the observations of the first second, the true model, and the estimated model."""
    env = gymnasium.make("trundle/LockedWheel-v0")
    agent = trundle.AdaptiveAgent(env)
    observation, _ = env.reset(seed=1, options={"start": (-1, 0, 0), "goal": (1, 0.5, 0.8)})
    seen = [observation]
    for _ in range(20):
        action, _ = agent.predict(seen[-1])
        seen.append(env.step(action)[0])
    agent.predict(seen[-1])
    return seen, truth(env), agent.beliefs[0]


def test_the_agent_reaches_the_goal_with_any_locked_wheel(learnt: list[Episode]) -> None:
    assert [episode.success for episode in learnt] == [True] * len(SEEDS)


def test_adaptation_improves_the_return(learnt: list[Episode]) -> None:
    stubborn = [play(seed, adapt=False) for seed in SEEDS]
    gains = np.array([a.reward - b.reward for a, b in zip(learnt, stubborn, strict=True)])
    # Over 20 seeds the mean gain is 1.5, its standard deviation 0.9.
    assert gains.mean() > 0.5
    assert np.mean([e.seconds for e in learnt]) < 0.6 * np.mean([e.seconds for e in stubborn])


def test_after_a_second_the_model_predicts_the_motion(
    pushed: tuple[Observations, trundle.Model, trundle.agent.Belief],
) -> None:
    _, hidden, belief = pushed
    assert belief.updates[-1].time == 1.0
    t = np.linspace(0.0, 1.0, 101)
    # A push that the agent has not made: a rotation to the right.
    wrench = np.tile([40.0, -30.0, -10.0], (101, 1))
    believed, true = (m.rollout([0.0] * 3, [0.0] * 3, t, wrench)[0][-1] for m in (belief.model, hidden))
    assert np.linalg.norm(believed - true) < 0.1 * np.linalg.norm(true)


def test_it_updates_before_each_action(
    pushed: tuple[Observations, trundle.Model, trundle.agent.Belief],
) -> None:
    times = [update.time for update in pushed[2].updates]
    assert np.diff(times) == pytest.approx(0.05)


def test_with_one_wheel_it_updates_before_each_action_while_models_differ(
    env: gymnasium.Env[Any, Any], pushed: tuple[Observations, trundle.Model, trundle.agent.Belief]
) -> None:
    agent = trundle.AdaptiveAgent(env, trundle.AgentSettings(learner="filter"))
    for row in pushed[0]:
        agent.predict(row)
    unsure = True
    for before, update in itertools.pairwise(agent.beliefs[0].updates):
        unsure = before.value_of_information > 0.02
        assert update.time - before.time == pytest.approx(0.05 if unsure else 0.5 - before.time % 0.5)
    assert not unsure


def test_the_same_seed_and_observations_give_the_same_actions(
    env: gymnasium.Env[Any, Any], pushed: tuple[Observations, trundle.Model, trundle.agent.Belief]
) -> None:
    def actions(seed: int) -> list[Any]:
        agent = trundle.AdaptiveAgent(env, trundle.AgentSettings(seed=seed))
        return [agent.predict(row)[0].tolist() for row in pushed[0]]

    assert actions(5) == actions(5)
    assert actions(5) != actions(6)


def test_rows_of_a_batch_are_independent_agents(
    env: gymnasium.Env[Any, Any], pushed: tuple[Observations, trundle.Model, trundle.agent.Belief]
) -> None:
    seen = pushed[0]
    alone, together = trundle.AdaptiveAgent(env), trundle.AdaptiveAgent(env)
    other, _ = gymnasium.make("trundle/LockedWheel-v0").reset(seed=9)
    state, start = None, np.array([True, True])
    for row in seen:
        action, _ = alone.predict(row)
        actions, state = together.predict(np.stack([other, row]), state=state, episode_start=start)
        start = np.array([False, False])
        assert action.dtype == np.float32
        assert env.action_space.contains(action)
        assert actions.shape == (2, 3)
        assert np.array_equal(actions[1], action)
    assert together.beliefs[1].fits == alone.beliefs[0].fits > 1


@pytest.mark.parametrize("start_is_given", [True, False])
def test_a_new_episode_resets_the_agent(
    start_is_given: bool,
    env: gymnasium.Env[Any, Any],
    pushed: tuple[Observations, trundle.Model, trundle.agent.Belief],
) -> None:
    agent = trundle.AdaptiveAgent(env)
    first = [agent.predict(row)[0].tolist() for row in pushed[0]]
    assert agent.beliefs[0].fits > 1
    if not start_is_given:
        other, _ = gymnasium.make("trundle/LockedWheel-v0").reset(seed=9)
        agent.predict(other)
        assert agent.beliefs[0].fits == 0
    again = [
        agent.predict(row, episode_start=k == 0 if start_is_given else None)[0].tolist()
        for k, row in enumerate(pushed[0])
    ]
    assert again == first


def test_unusable_environments_are_refused(env: gymnasium.Env[Any, Any]) -> None:
    with pytest.raises(trundle.TrundleError, match="has no object to push"):
        trundle.AdaptiveAgent(gymnasium.make("CartPole-v1"))
    with pytest.raises(trundle.TrundleError, match="observations are Dict"):
        trundle.AdaptiveAgent(gymnasium.make("trundle/PushPoseGoal-v0"))
    with pytest.raises(trundle.TrundleError, match=r"push = 0\.01: give rise < period <= push"):
        trundle.AdaptiveAgent(env, trundle.AgentSettings(push=0.01))
    with pytest.raises(trundle.TrundleError, match="unknown field `sample`"):
        trundle.AdaptiveAgent(env, trundle.AgentSettings(planner={"sample": 3}))
    with pytest.raises(trundle.TrundleError, match=r"shape \(16,\) or \(n, 16\), not \(3,\)"):
        trundle.AdaptiveAgent(env).predict(np.zeros(3))
    with pytest.raises(trundle.TrundleError, match="must be finite"):
        trundle.AdaptiveAgent(env).predict(np.full(16, np.nan))
    with pytest.raises(trundle.TrundleError, match="starts = 0"):
        trundle.AgentSettings(starts=0)


@pytest.mark.parametrize("substeps", [25, 50])
def test_the_control_period_is_that_of_the_environment(substeps: int) -> None:
    env = gymnasium.make("trundle/LockedWheel-v0", substeps=substeps)
    agent = trundle.AdaptiveAgent(env)
    observation, _ = env.reset(seed=0)
    for step in range(round(50 * 25 / substeps)):
        action, (belief,) = agent.predict(observation, episode_start=step == 0)
        observation, _, reached, *_ = env.step(action)
        if reached:
            break
    (mass,) = (one["value"] for one in belief.model.parameters if one["name"] == "body.mass")
    # With another period the mass would be wrong by a factor of two.
    assert mass == pytest.approx(22.0, abs=1.0) and belief.fits > 0


def test_the_outline_is_visible_only_on_request() -> None:
    env = gymnasium.make("trundle/PushAround-v0", object="random", hidden="locked")
    observation, _ = env.reset(seed=3001)
    source: Any = env.unwrapped
    true = source.recording_metadata("")["object"]
    for outline in (False, True):
        agent = trundle.AdaptiveAgent(env, trundle.AgentSettings(outline=outline))
        agent.predict(observation, episode_start=True)
        description = agent.beliefs[0].metadata["object"]
        assert "support" in true and "support" not in description
        assert description.get("fixture") == (true["fixture"] if outline else None)
        assert ("footprint" in description) != outline
    with pytest.raises(trundle.TrundleError, match="for one environment only"):
        agent.predict(np.stack([observation, observation]))


def test_the_example_runs() -> None:
    def printed(*command: str) -> str:
        script = [sys.executable, *command]
        return subprocess.run(script, cwd=ROOT, capture_output=True, text=True, check=True).stdout

    example = printed("examples/adaptive_agent.py")
    assert "N s/m" in example
    assert "\nreached after" in example


@pytest.mark.parametrize("task", ["PushAround", pytest.param("PushDoor", marks=pytest.mark.slow)])
def test_it_adapts_around_obstacles_and_in_doorways(task: str) -> None:
    env = gymnasium.make(f"trundle/{task}-v0", hidden="locked")
    agent = trundle.AdaptiveAgent(env)
    for seed in (0, 5):
        observation, _ = env.reset(seed=seed)
        over, touched, first = False, False, True
        info: dict[str, Any] = {}
        while not over:
            action, _ = agent.predict(observation, episode_start=first)
            observation, _, terminated, truncated, info = env.step(action)
            over, first = terminated or truncated, False
            touched |= info["touched"]
        assert info["is_success"] and not touched, (task, seed, info)


def test_observed_obstacles_are_at_their_true_positions() -> None:
    for task in ("PushAround", "PushDoor"):
        env = gymnasium.make(f"trundle/{task}-v0")
        observation, _ = env.reset(seed=3)
        source: Any = env.unwrapped
        seen = source.seen_obstacles(observation)
        true = source.recording_metadata("x")["scene"]["obstacle"]
        assert len(seen) == len(true)
        for polygon, wall in zip(seen, true, strict=True):
            near = np.array(wall["polygon"])[:, None] - np.array(polygon)
            # Ends outside the arena may differ.
            corners = np.abs(wall["polygon"]).max(axis=1) < 2.5
            assert np.hypot(*np.moveaxis(near, -1, 0)).min(axis=1)[corners].max() < 1e-9
