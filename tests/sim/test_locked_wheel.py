"""`trundle/LockedWheel-v0`: what Gymnasium asks of an environment, and what the task promises."""

from __future__ import annotations

import copy
import pickle
import warnings
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env
from numpy.typing import NDArray

import trundle
from trundle.envs import LockedWheel

ID = "trundle/LockedWheel-v0"
Env = gymnasium.Env[NDArray[np.float64], NDArray[np.float32]]


def actions(count: int, seed: int = 0) -> NDArray[np.float32]:
    return np.random.default_rng(seed).uniform(-0.6, 0.6, (count, 3)).astype(np.float32)


def rollout(env: Env, given: NDArray[np.float32]) -> list[tuple[list[float], float, bool]]:
    steps = []
    for action in given:
        observation, reward, terminated, _, _ = env.step(action)
        steps.append((observation.tolist(), float(reward), terminated))
        if terminated:
            break
    return steps


def test_gymnasiums_strict_checker_is_content() -> None:
    env = gymnasium.make(ID, render_mode="rgb_array")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped, skip_render_check=False)


def test_the_id_is_known_without_an_import() -> None:
    assert isinstance(gymnasium.make(f"trundle:{ID}").unwrapped, LockedWheel)


def test_a_seed_gives_the_same_episodes() -> None:
    def episodes(seed: int) -> list[Any]:
        env: Env = gymnasium.make(ID)
        first = env.reset(seed=seed)[0].tolist(), rollout(env, actions(50))
        return [first, env.reset()[0].tolist(), rollout(env, actions(50))]

    assert episodes(7) == episodes(7)
    assert episodes(7) != episodes(8)


@pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_a_copy_goes_on_alike(duplicate: Callable[[Env], Env]) -> None:
    env: Env = gymnasium.make(ID)
    env.reset(seed=1)
    rollout(env, actions(10))
    other = duplicate(env)
    assert rollout(other, actions(30, seed=1)) == rollout(env, actions(30, seed=1))
    assert other.reset()[0].tolist() == env.reset()[0].tolist()


def test_observations_stay_in_their_space_and_nothing_hidden_is_told() -> None:
    env: Env = gymnasium.make(ID, noise=10.0)
    for seed in range(20):
        observation, info = env.reset(seed=seed)
        assert info == {} and observation in env.observation_space
        for action in np.sign(actions(40, seed)):
            observation, _, terminated, _, info = env.step(action)
            assert observation in env.observation_space
            assert set(info) == {"is_success", "distance", "heading_error"}
            if terminated:
                break


def test_two_hidden_wheels_look_the_same_until_pushed() -> None:
    env: Env = gymnasium.make(ID, noise=0.0, render_mode="rgb_array")
    where = {"start": (0.1, 0.2, 0.3), "goal": (1.0, 0.0, 0.0)}
    (first, _), one = env.reset(seed=0, options=where), env.render()
    (second, _), two = env.reset(seed=1, options=where), env.render()
    np.testing.assert_array_equal(first, second)
    np.testing.assert_array_equal(np.asarray(one), np.asarray(two))
    push = np.array([1.0, 0.0, 0.0], dtype=np.float32)
    env.reset(seed=0, options=where)
    moved = rollout(env, np.tile(push, (10, 1)))[-1]
    env.reset(seed=1, options=where)
    assert rollout(env, np.tile(push, (10, 1)))[-1] != moved


def test_the_time_limit_truncates() -> None:
    env: Env = gymnasium.make(ID)
    env.reset(seed=0)
    still = np.zeros(3, dtype=np.float32)
    ends = [env.step(still)[2:4] for _ in range(300)]
    assert ends[-1] == (False, True) and set(ends[:-1]) == {(False, False)}


def test_the_goal_ends_the_episode() -> None:
    env: Env = gymnasium.make(ID)
    env.reset(seed=0, options={"start": (1.0, 1.0, 3.0), "goal": (1.0, 1.0, -3.2)})
    _, reward, terminated, _, info = env.step(np.zeros(3, dtype=np.float32))
    assert terminated and info["is_success"] and info["distance"] == 0.0
    assert info["heading_error"] == pytest.approx(6.2 - 2 * np.pi)
    assert reward == pytest.approx(-0.05 * 0.3 * abs(info["heading_error"]))


def test_the_wrist_reads_the_wrench_that_was_asked_for() -> None:
    env: Env = gymnasium.make(ID, noise=0.0)
    env.reset(seed=0)
    action = np.array([0.3, -0.2, 0.1], dtype=np.float32)
    observation = env.step(action)[0]
    np.testing.assert_allclose(observation[11:14], action * LockedWheel.ACTION_SCALE, rtol=1e-6)


@pytest.mark.parametrize(
    ("action", "words"),
    [
        (np.zeros(2), r"\(3,\).*\(2,\)"),
        (np.array([0.0, np.nan, 0.0]), "nan"),
        (np.array([0.0, np.inf, 0.0]), "inf"),
        (np.array([0.0, 1.5, 0.0]), "ClipAction"),
    ],
)
def test_an_impossible_action_is_refused(action: NDArray[np.float64], words: str) -> None:
    env = LockedWheel()
    env.reset(seed=0)
    with pytest.raises(trundle.TrundleError, match=words):
        env.step(action.astype(np.float32))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"wheel": 3}, "wheel.*same_object"),
        ({"goal": (9.0, 0.0, 0.0)}, "goal"),
        ({"start": (0.0, 0.0)}, "start.*3 numbers"),
        ({"start": "here"}, "start.*3 numbers"),
        ({"grasp": (0.0, 0.5)}, "grasp.*0.4 m"),
    ],
)
def test_an_impossible_option_is_refused(options: dict[str, Any], words: str) -> None:
    with pytest.raises(trundle.TrundleError, match=words):
        LockedWheel().reset(seed=0, options=options)


def test_the_order_of_calls_is_kept() -> None:
    env = LockedWheel(render_mode="rgb_array")
    still = np.zeros(3, dtype=np.float32)
    for call in (lambda: env.step(still), env.render):
        with pytest.raises(ResetNeeded):
            call()
    env.reset(options={"start": (0.0, 0.0, 0.0), "goal": (0.0, 0.0, 0.0)})
    env.step(still)
    with pytest.raises(ResetNeeded):
        env.step(still)


def test_arguments_out_of_range_are_refused() -> None:
    with pytest.raises(trundle.TrundleError, match="noise = -1"):
        LockedWheel(noise=-1.0)
    with pytest.raises(trundle.TrundleError, match="rgb_array"):
        LockedWheel(render_mode="ansi")


def test_the_picture_shows_the_table_where_it_is() -> None:
    env: Env = gymnasium.make(ID, render_mode="rgb_array")
    env.reset(seed=0, options={"start": (1.0, 0.5, 0.0), "goal": (-1.0, -0.5, 0.0)})
    picture = np.asarray(env.render()).astype(int)
    assert picture.shape == (480, 480, 3)

    def pixel(x: float, y: float) -> NDArray[np.int_]:
        middle: NDArray[np.int_] = picture[int((2.75 - y) / 5.5 * 480), int((x + 2.75) / 5.5 * 480)]
        return middle

    red, _, blue = pixel(1.3, 0.7)
    assert red > blue + 40, "the table is brown"
    red, green, _ = pixel(-1.3, -0.7)
    assert green > red, "the goal is green"
    assert pixel(0.25, 1.25).min() > 200, "the floor is bright"
