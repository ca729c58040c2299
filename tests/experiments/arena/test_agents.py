"""Simulator, planner and estimator of the arena on gym-pusht itself."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("gym_pusht", reason="the arena needs gym-pusht: pip install trundle[arena]")

from trundle._native import TrundleError
from trundle.experiments.arena import estimator, planner
from trundle.experiments.arena.agents import PlanningAgent, make_agent
from trundle.experiments.arena.estimator import Estimator
from trundle.experiments.arena.planner import GOAL, OUTLINE, Planner, corners, costs
from trundle.experiments.arena.simulator import Simulator
from trundle.experiments.arena.world import NOMINAL, PHYSICS, PushTHidden, make
from trundle.experiments.sampling import Floats

HIDDEN = {"mass": 2.0, "friction": 400.0, "offset_x": 22.0, "offset_y": -18.0}
START = [180.0, 240.0, 256.0, 256.0, 0.3]


def started(physics: str) -> tuple[PushTHidden, Floats]:
    env = make(physics)
    return env, env.reset(seed=0, options={"reset_to_state": START, "hidden": HIDDEN})[0]


def pushes() -> Floats:
    """Return actions that push the block from three sides."""
    sides = [(260.0, 250.0), (330.0, 330.0), (250.0, 420.0), (300.0, 300.0), (420.0, 250.0), (300.0, 260.0)]
    return np.repeat(np.array(sides), 5, axis=0)


@pytest.mark.parametrize("physics", PHYSICS)
def test_only_the_true_parameters_predict_the_motion(physics: str) -> None:
    env, observation = started(physics)
    true = Simulator(env.hidden, physics, Simulator.start(observation))
    nominal = Simulator(NOMINAL, physics, Simulator.start(observation))
    errors = []
    for action in pushes():
        seen = env.step(action)[0]
        errors.append([np.abs(one.track(action, seen)).max() for one in (true, nominal)])
        np.testing.assert_allclose(true.state[2:4], seen[2:4], rtol=0, atol=1e-9)
    assert np.max(errors, axis=0)[0] < 0.5
    assert np.max(errors, axis=0)[1] > 3.0


def test_angles_that_pass_a_full_turn_are_no_error() -> None:
    env = make()
    start = [180.0, 240.0, 256.0, 256.0, 0.02]
    observation = env.reset(seed=0, options={"reset_to_state": start, "hidden": HIDDEN})[0]
    simulator = Simulator(env.hidden, "original", Simulator.start(observation))
    angles = [observation[4]]
    for _ in range(8):
        seen = env.step(np.array([260.0, 250.0]))[0]
        angles.append(seen[4])
        assert np.abs(simulator.track(np.array([260.0, 250.0]), seen)).max() < 0.5
    assert min(angles) < 1.0 < 6.0 < max(angles)


def test_a_rollout_starts_from_the_given_state_and_leaves_the_tracked_one() -> None:
    _, observation = started("sliding")
    simulator = Simulator(NOMINAL, "sliding", Simulator.start(observation))
    once, again = (simulator.rollout(simulator.state, pushes()) for _ in range(2))
    np.testing.assert_allclose(once, again, rtol=0, atol=1e-3)
    np.testing.assert_array_equal(simulator.state[:5], observation)
    assert np.linalg.norm(once[-1, 2:4] - observation[2:4]) > 30.0


def test_the_outline_is_that_of_the_benchmark() -> None:
    env, observation = started("original")
    block = env.unwrapped.block  # type: ignore[attr-defined]
    vertices = [block.local_to_world(v) for shape in block.shapes for v in shape.get_vertices()]
    found = corners(observation[2:])
    assert found.shape == OUTLINE.shape
    gaps = np.linalg.norm(found[:, None] - np.array(vertices)[None], axis=-1)
    assert gaps.min(1).max() < 1e-6
    np.testing.assert_allclose(env.unwrapped.goal_pose, GOAL)  # type: ignore[attr-defined]


def test_the_cost_falls_towards_the_goal() -> None:
    near = np.array([[[200.0, 200.0, *GOAL, 0, 0, 0, 0, 0]]])
    shifted, turned = near.copy(), near.copy()
    shifted[..., 2] += 10.0
    turned[..., 4] += 0.2
    at_goal, by_shift, by_turn = (costs(one)[0] for one in (near, shifted, turned))
    assert by_shift - at_goal == pytest.approx(15.0, abs=0.5)
    assert by_turn - at_goal > 5.0


def test_the_oracle_raises_the_coverage() -> None:
    env = make("sliding")
    behind = [333.0, 179.0, 291.0, 221.0, np.pi / 4]
    options = {"reset_to_state": behind, "hidden": HIDDEN}
    observation = env.reset(seed=0, options=options)[0]
    agent = make_agent("oracle", env.hidden, "sliding", observation, 1)
    covered = []
    for _ in range(12):
        action = agent.act(observation)
        observation, _, _, _, info = env.step(action)
        agent.see(action, observation)
        covered.append(info["coverage"])
    assert max(covered) > covered[0] + 0.2


def test_a_plan_is_held_and_kept() -> None:
    _, observation = started("original")
    agent = make_agent("nominal", NOMINAL, "original", observation, 1)
    actions = []
    for _ in range(planner.ACTIONS_PER_KNOT + 1):
        actions.append(agent.act(observation))
    assert all(np.array_equal(actions[0], one) for one in actions[:-1])
    assert not np.array_equal(actions[0], actions[-1])
    assert Planner(1).plan is None


@pytest.mark.parametrize("physics", PHYSICS)
def test_the_estimate_approaches_what_the_physics_shows(
    physics: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(estimator, "PARTICLES", 60)
    env, observation = started(physics)
    found = Estimator(physics, Simulator.start(observation), 3)
    for action in pushes():
        found.track(action, env.step(action)[0])
    estimate = found.estimate
    assert found.weights.sum() == pytest.approx(1.0)
    offset = np.hypot(estimate.offset_x - 22.0, estimate.offset_y + 18.0)
    assert offset < 0.4 * np.hypot(22.0, 18.0)
    if physics == "sliding":
        assert abs(np.log(estimate.mass / 2.0)) < 0.5 * np.log(2.0)
        assert abs(np.log(estimate.friction / 400.0)) < 0.8 * np.log(NOMINAL.friction / 400.0)


def test_each_agent_simulates_its_own_parameters() -> None:
    env, observation = started("sliding")
    masses, estimators = {}, {}
    for name in ("oracle", "nominal", "adaptive"):
        agent = make_agent(name, env.hidden, "sliding", observation, 0)
        assert isinstance(agent, PlanningAgent)
        action = agent.act(observation)
        masses[name] = agent.simulator.env.block.mass
        before = agent.simulator.state.copy()
        agent.see(action, env.step(action)[0])
        assert not np.array_equal(agent.simulator.state, before)
        estimators[name] = agent.estimator
    assert (masses["oracle"], masses["nominal"]) == (2.0, 1.0)
    assert estimators["oracle"] is None and estimators["nominal"] is None
    assert estimators["adaptive"] is not None and masses["adaptive"] not in (1.0, 2.0)
    assert np.ptp(estimators["adaptive"].log_weights) > 0.0


def test_wrong_agents_are_named() -> None:
    with pytest.raises(TrundleError, match="'human': choose oracle, nominal, adaptive, ppo"):
        make_agent("human", NOMINAL, "original", np.zeros(5), 0)
    with pytest.raises(TrundleError, match="no policy given: train one"):
        make_agent("ppo", NOMINAL, "original", np.zeros(5), 0)
