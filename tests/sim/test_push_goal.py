"""Goal-conditioned environments: rewards for achieved and substituted goals."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest

import trundle
from trundle.envs import Observation, Oracle, PushPose, PushPoseGoal
from trundle.envs.observation import COMMON_ENTRIES

GOALS = ("PushPoseGoal", "PushPathGoal", "PushAroundGoal", "PushDoorGoal")


@pytest.mark.parametrize("reward_type", ["sparse", "dense"])
@pytest.mark.parametrize("name", GOALS)
def test_the_reward_is_that_of_the_observation(name: str, reward_type: str) -> None:
    env = gymnasium.make(f"trundle/{name}-v0", reward_type=reward_type)
    env.reset(seed=0)
    action = np.array([0.2, 0.0, 0.05], dtype=np.float32)
    raw: Any = env.unwrapped
    for _ in range(5):
        seen, reward, terminated, truncated, info = env.step(action)
        assert reward == raw.compute_reward(seen["achieved_goal"], seen["desired_goal"], info)
        assert terminated == raw.compute_terminated(seen["achieved_goal"], seen["desired_goal"], info)
        assert truncated == raw.compute_truncated(seen["achieved_goal"], seen["desired_goal"], info)


def test_rewards_are_vectorised() -> None:
    env = PushPoseGoal(reach=0.1, facing=0.2)
    here = np.array([0.0, 0.0, 1.0, 0.0])
    goals = np.array([[0.09, 0.0, 1.0, 0.0], [0.11, 0.0, 1.0, 0.0], [0.0, 0.0, np.cos(0.3), np.sin(0.3)]])
    np.testing.assert_array_equal(env.compute_reward(np.tile(here, (3, 1)), goals, {}), [0.0, -1.0, -1.0])
    dense = PushPoseGoal(reward_type="dense")
    assert dense.compute_reward(here, goals[2], {}) == pytest.approx(-0.3 * 0.3)


def test_it_is_the_flat_environment_with_dictionary_observations() -> None:
    flat, parted = PushPose(), PushPoseGoal()
    there = {"start": (0.5, 0.0, 0.0), "goal": (0.5, 0.0, 0.0)}
    row, _ = flat.reset(seed=4, options=there)
    seen, _ = parted.reset(seed=4, options=there)
    fields = Observation(row)
    kept = np.concatenate([fields.pose_vector, fields.twist, fields.wrench, fields.grasp])
    np.testing.assert_array_equal(seen["observation"], kept)
    np.testing.assert_array_equal(seen["desired_goal"], fields.goal_vector)
    np.testing.assert_array_equal(seen["achieved_goal"], fields.pose_vector)
    _, reward, terminated, _, info = parted.step(np.zeros(3, dtype=np.float32))
    assert info["is_success"] and reward == 0.0 and not terminated


def test_a_lost_object_truncates_the_episode() -> None:
    env = PushPoseGoal(hidden="none")
    env.reset(seed=0)
    for _ in range(60):
        _, _, terminated, truncated, info = env.step(np.array([1.0, 0.0, 0.0], dtype=np.float32))
        assert not terminated
        if truncated:
            break
    assert truncated and info["lost"]


def test_the_oracle_contains_the_changed_mass() -> None:
    shifted = {"kind": "com_offset", "com_x": 0.2, "com_y": 0.1}
    seen, _ = Oracle(PushPose(effects=[shifted])).reset(seed=0)
    _, *com = seen[COMMON_ENTRIES : COMMON_ENTRIES + 3]
    np.testing.assert_allclose(com, [0.2, 0.1])


def test_the_oracle_contains_the_wheel() -> None:
    plain, informed = (PushPose(render_mode="rgb_array", hidden="wheels") for _ in range(2))
    oracle = Oracle(informed)
    plain.reset(seed=3)
    oracle.reset(seed=3)
    one, other = np.asarray(plain.render()), np.asarray(oracle.render())
    changed = np.any(one != other, axis=-1)
    assert 50 < changed.sum() < 0.1 * changed.size


def test_another_reward_is_refused() -> None:
    with pytest.raises(trundle.TrundleError, match="reward_type"):
        PushPoseGoal(reward_type="shaped")


def test_the_oracle_of_goal_environments_contains_the_wheel() -> None:
    env = Oracle(gymnasium.make("trundle/LockedWheel-v0"))
    seen, info = env.reset(seed=0)
    wheel = info["hidden"]["effect"][0]
    mass, _, _, _, xx, _, yy, *_ = seen[COMMON_ENTRIES:]
    assert seen in env.observation_space and seen.shape == (26,)
    assert mass == 22.0 and xx + yy == pytest.approx(wheel["mu_x"] + wheel["mu_y"])
    assert env.step(np.zeros(3, dtype=np.float32))[0].shape == (26,)
    with pytest.raises(trundle.TrundleError, match="is not a pushing environment"):
        Oracle(gymnasium.make("Pendulum-v1"))
    with pytest.raises(trundle.TrundleError, match="flat"):
        Oracle(gymnasium.make("trundle/PushPoseGoal-v0"))
