"""Versions and levels of the environments."""

from __future__ import annotations

import hashlib
import json
import warnings
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from trundle._registration import LEVEL_TASKS, LEVELS
from trundle.envs import Observation

EPISODES = json.loads((Path(__file__).parent / "v0_episodes.json").read_text(encoding="utf-8"))
"""SHA-256 of observations and rewards of v0, by task, action and object, before there was a v1."""
NEW = [
    f"trundle/{task}{level}-v1" for task in LEVEL_TASKS for level in ("", *(one.title() for one in LEVELS))
]


@pytest.mark.parametrize("case", EPISODES)
def test_version_0_stays_byte_for_byte(case: str) -> None:
    name, mode, one = case.split()
    hidden: dict[str, Any] = (
        {} if name == "LockedWheel" else {"hidden": "catalogue" if one == "random" else "wheels"}
    )
    env: Any = gymnasium.make(
        f"trundle/{name}-v0", action=mode, object=one, disable_env_checker=True, **hidden
    )
    draw, digest, width = np.random.default_rng(0), hashlib.sha256(), env.action_space.shape[0]
    for seed in (1, 2):
        env.reset(seed=seed)
        drift = draw.uniform(-0.5, 0.5, width)
        for _ in range(25 if mode == "push" else 60):
            action = np.clip(drift + draw.uniform(-0.4, 0.4, width), -1, 1).astype(np.float32)
            seen, reward, terminated, truncated, _ = env.step(action)
            flat = np.concatenate(list(seen.values())) if isinstance(seen, dict) else seen
            digest.update(flat.tobytes() + np.float64(reward).tobytes())
            if terminated or truncated:
                break
    assert digest.hexdigest()[:16] == EPISODES[case]


@pytest.mark.parametrize("dtype", ["float64", "float32"])
@pytest.mark.parametrize("name", [*NEW, "trundle/PushAroundGoal-v1"])
def test_the_checker_of_gymnasium_passes(name: str, dtype: str) -> None:
    env = gymnasium.make(name, dtype=dtype, outline="Around" in name)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped, skip_render_check=True)
    assert env.spec is not None and env.spec.max_episode_steps == 300


def test_a_batch_in_float32_is_like_gymnasiums() -> None:
    options: dict[str, Any] = {"dtype": "float32", "max_episode_steps": 7}
    native = gymnasium.make_vec("trundle/PushDoorHard-v1", num_envs=2, **options)
    plain = gymnasium.make_vec("trundle/PushDoorHard-v1", num_envs=2, vectorization_mode="sync", **options)
    assert native.single_observation_space == plain.single_observation_space
    np.testing.assert_array_equal(native.reset(seed=1)[0], plain.reset(seed=1)[0])
    for action in np.random.default_rng(0).uniform(-1.5, 1.5, (9, 2, 3)).astype(np.float32):
        ours, theirs = native.step(action), plain.step(action)
        for mine, other in zip(ours[:4], theirs[:4], strict=True):
            np.testing.assert_array_equal(mine, other)
        if "action_clipped" in theirs[4]:
            np.testing.assert_array_equal(ours[4]["action_clipped"], theirs[4]["action_clipped"])


def test_observations_hold_the_bounding_box_and_the_outline() -> None:
    env: Any = gymnasium.make("trundle/PushPoseHard-v1", outline=True, split="test").unwrapped
    for seed in range(20):
        seen = Observation(env.reset(seed=seed)[0])
        polygon = env.hidden_model()["body"]["footprint"]
        low, high = np.min(polygon, axis=0), np.max(polygon, axis=0)
        np.testing.assert_allclose(seen.half_size, (high - low) / 2, atol=1e-12)
        np.testing.assert_allclose(seen.middle, (high + low) / 2, atol=1e-12)
        angles = 2 * np.pi * np.arange(24) / 24
        points = seen.middle + seen.outline_radii[:, None] * np.stack(
            [np.cos(angles), np.sin(angles)], axis=1
        )
        assert np.all(points > low - 1e-9) and np.all(points < high + 1e-9)
        assert points.max(axis=0) == pytest.approx(high, abs=0.15)


def test_contact_is_priced_by_its_duration() -> None:
    rewards = []
    for cost in (0.0, 10.0):
        env: Any = gymnasium.make("trundle/PushDoor-v1", hidden="locked", touch_cost=cost)
        env.reset(seed=3)
        gained, info = 0.0, {}
        for _ in range(100):
            _, reward, terminated, _, info = env.step(np.array([0.3, 0.0, 0.0], dtype=np.float32))
            gained += reward
            if terminated:
                break
        rewards.append(gained)
    assert info["contact_time"] > 0.1 and info["contact_impulse"] > 1.0
    assert rewards[0] - rewards[1] == pytest.approx(10.0 * info["contact_time"])


@pytest.mark.parametrize("version", [0, 1])
def test_a_touch_is_a_force_in_version_1_and_a_short_distance_in_version_0(version: int) -> None:
    env: Any = gymnasium.make(f"trundle/PushDoor-v{version}", hidden="locked")
    touches, impulses = [], []
    for seed in range(8):
        env.reset(seed=seed)
        action, before = np.random.default_rng(seed).uniform(-0.3, 0.3, 3).astype(np.float32), 0.0
        for _ in range(100):
            *_, terminated, truncated, info = env.step(action)
            touches.append(info["touched"])
            impulses.append(info["contact_impulse"] > before)
            before = info["contact_impulse"]
            if terminated or truncated:
                break
    assert any(impulses)
    assert (touches == impulses) == (version == 1)
    assert all(touch for touch, impulse in zip(touches, impulses, strict=True) if impulse)


def test_success_without_touching_excludes_an_earlier_touch() -> None:
    env: Any = gymnasium.make("trundle/PushDoor-v1", hidden="locked", reach=2.5, facing=4.0)
    env.reset(seed=3)
    over = False
    while not over:
        _, _, terminated, truncated, info = env.step(np.array([0.3, 0.0, 0.0], dtype=np.float32))
        over = terminated or truncated
        assert info["success_without_touching"] == (info["is_success"] and info["contact_time"] == 0.0)


def test_actions_are_clipped_and_flagged() -> None:
    after = []
    for action in ([1.0, -1.0, 0.0], [3.0, -1.5, 0.0]):
        env: Any = gymnasium.make("trundle/PushPose-v1", disable_env_checker=True)
        env.reset(seed=0)
        observation, *_, info = env.step(np.array(action, dtype=np.float32))
        after.append(observation)
        assert info["action_clipped"] is (action[0] > 1.0)
    np.testing.assert_array_equal(*after)
