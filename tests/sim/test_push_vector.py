"""Batches: each environment is the single one with its seed, in every autoreset mode."""

from __future__ import annotations

import copy
import pickle
import warnings
from multiprocessing import get_context
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.error import InvalidAction, ResetNeeded
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from numpy.typing import NDArray

import trundle
from trundle.envs import Oracle, PushVec, VectorOracle
from trundle.envs.observation import COMMON_ENTRIES
from trundle.envs.tasks import PushDoor
from trundle.envs.vector import LockedWheelVec

KNOWN: dict[str, Any] = {"horizon": 9, "object": "household"}


def actions(steps: int, count: int) -> NDArray[np.float32]:
    return np.random.default_rng(1).uniform(-0.9, 0.9, (steps, count, 3)).astype(np.float32)


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
@pytest.mark.parametrize("name", ["PushDoor", "PushPath", "PushPoseGoal"])
def test_a_batch_steps_like_gymnasiums(name: str, mode: AutoresetMode) -> None:
    native = gymnasium.make_vec(f"trundle/{name}-v0", num_envs=3, autoreset_mode=mode, **KNOWN)
    plain = gymnasium.make_vec(
        f"trundle/{name}-v0",
        num_envs=3,
        vectorization_mode="sync",
        vector_kwargs={"autoreset_mode": mode},
        **KNOWN,
    )
    assert isinstance(native, PushVec) and isinstance(plain, SyncVectorEnv)
    assert native.observation_space == plain.observation_space
    assert native.action_space == plain.action_space
    same(native.reset(seed=5)[0], plain.reset(seed=5)[0])
    for action in actions(30, 3):
        ours, theirs = native.step(action), plain.step(action)
        for mine, other in zip(ours[:4], theirs[:4], strict=True):
            same(mine, other)
        same_infos(ours[4], theirs[4])


def same(ours: Any, theirs: Any) -> None:
    if isinstance(theirs, dict):
        assert set(ours) == set(theirs)
        for key in theirs:
            np.testing.assert_array_equal(ours[key], theirs[key])
    else:
        np.testing.assert_array_equal(ours, theirs)


def same_infos(ours: dict[str, Any], theirs: dict[str, Any]) -> None:
    """Assert that infos agree with those of Gymnasium's batch where the masks are True."""
    for key, value in theirs.items():
        if key.startswith("_"):
            np.testing.assert_array_equal(ours[key], value, err_msg=key)
        elif key == "final_info":
            same_infos(ours[key], value)
        elif key == "final_obs":
            for index in np.flatnonzero(theirs["_final_obs"]):
                final = ours[key]
                one = {k: v[index] for k, v in final.items()} if isinstance(final, dict) else final[index]
                same(one, value[index])
        else:
            mask = theirs[f"_{key}"]
            np.testing.assert_array_equal(ours[key][mask], value[mask], err_msg=key)


def test_disabled_autoreset_requires_a_reset() -> None:
    envs = gymnasium.make_vec("trundle/PushPose-v0", num_envs=3, autoreset_mode="Disabled", horizon=2)
    envs.reset(seed=0)
    still = np.zeros((3, 3), dtype=np.float32)
    envs.step(still)
    truncated = envs.step(still)[3]
    assert truncated.all()
    with pytest.raises(ResetNeeded):
        envs.step(still)
    before, _ = envs.reset(options={"reset_mask": np.array([True, True, False])})
    with pytest.raises(ResetNeeded):
        envs.step(still)
    after, _ = envs.reset(options={"reset_mask": np.array([False, False, True])})
    np.testing.assert_array_equal(before[:2], after[:2])
    assert not envs.step(still)[3].any()


def test_buffers_are_shared_only_on_request() -> None:
    still = np.zeros((2, 3), dtype=np.float32)
    for copied in (True, False):
        envs = gymnasium.make_vec("trundle/PushPose-v0", num_envs=2, copy=copied)
        first, _ = envs.reset(seed=0)
        assert np.shares_memory(first, envs.step(still)[0]) is not copied


def test_a_snapshot_moves_between_batch_and_single_environment() -> None:
    envs, single = gymnasium.make_vec("trundle/PushDoor-v0", num_envs=2).unwrapped, PushDoor()
    assert isinstance(envs, PushVec)
    envs.reset(seed=3)
    given = actions(6, 2)
    for action in given[:3]:
        envs.step(action)
    single.restore(pickle.loads(pickle.dumps(envs.snapshot(1))))
    for action in given[3:]:
        np.testing.assert_array_equal(envs.step(action)[0][1], single.step(action[1])[0])
    envs.restore(0, single.snapshot())
    assert np.array_equal(*(envs.step(np.zeros((2, 3)))[0]))


def test_environments_without_a_seed_are_random() -> None:
    def first(seeds: Any) -> NDArray[np.float64]:
        envs = gymnasium.make_vec("trundle/PushPose-v0", num_envs=3)
        return np.asarray(envs.reset(seed=seeds)[0])

    assert len(np.unique(first([None] * 3)[:, 0])) == 3
    assert not np.array_equal(first(None), first(None))
    one, other = first([None, 7, None]), first(np.array([1, 7, 2]))
    np.testing.assert_array_equal(one[1], other[1])


def test_a_copy_of_a_batch_continues_identically() -> None:
    envs = LockedWheelVec(3, horizon=5)
    envs.reset(seed=0)
    given = actions(12, 3)
    envs.step(given[0])
    others = [copy.deepcopy(envs), pickle.loads(pickle.dumps(envs))]
    for action in given[1:]:
        seen = envs.step(action)[0]
        for other in others:
            np.testing.assert_array_equal(other.step(action)[0], seen)


def fork_steps(envs: PushVec) -> None:
    envs.step(np.zeros((64, 3)))


def test_a_fork_has_its_own_threads() -> None:
    envs = LockedWheelVec(64)
    envs.reset(seed=0)
    envs.step(np.zeros((64, 3)))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        child = get_context("fork").Process(target=fork_steps, args=(envs,))
        child.start()
    child.join(20)
    ended = child.exitcode
    child.kill()
    assert ended == 0


def test_max_episode_steps_sets_the_horizon() -> None:
    envs = gymnasium.make_vec("trundle/PushPose-v0", num_envs=2, max_episode_steps=1)
    envs.reset(seed=0)
    assert envs.step(np.zeros((2, 3)))[3].all()


def test_the_snapshot_of_an_ended_episode_is_ended() -> None:
    envs = LockedWheelVec(2, horizon=1)
    envs.reset(seed=0)
    envs.step(np.zeros((2, 3)))
    ended = envs.snapshot(0)
    envs.step(np.zeros((2, 3)))
    envs.restore(0, ended)
    assert envs.step(np.zeros((2, 3)))[4]["_distance"].tolist() == [False, True]


def test_the_oracle_of_a_batch_contains_every_wheel() -> None:
    envs = VectorOracle(gymnasium.make_vec("trundle/LockedWheel-v0", num_envs=4))
    seen, _ = envs.reset(seed=0)
    assert seen.shape == (4, 26) and seen in envs.observation_space
    hidden = dict(zip(Oracle.NAMES, seen[:, COMMON_ENTRIES:].T, strict=True))
    assert len(np.unique(hidden["drag xx (N s/m)"])) == 4 and np.all(hidden["mass (kg)"] == 22.0)


def test_each_environment_has_an_image() -> None:
    envs = gymnasium.make_vec("trundle/PushAround-v0", num_envs=2, render_mode="rgb_array")
    envs.reset(seed=0)
    one, two = (np.asarray(picture) for picture in envs.render() or ())
    assert one.shape == (480, 480, 3) and not np.array_equal(one, two)


def test_invalid_arguments_are_refused() -> None:
    envs = LockedWheelVec(2)
    with pytest.raises(ResetNeeded):
        envs.step(np.zeros((2, 3)))
    envs.reset(seed=0)
    for wrong, words in [
        (np.zeros((3, 3)), r"\(2, 3\), not \(3, 3\)"),
        (np.zeros(6), r"\(2, 3\), not \(6,\)"),
        (np.array([[0, 0, 0], [0, np.nan, 0]]), "environment 1.*NaN"),
        (np.full((2, 3), 2.0), "ClipAction"),
    ]:
        with pytest.raises(InvalidAction, match=words):
            envs.step(wrong)
    with pytest.raises(trundle.TrundleError, match="3 seeds for 2"):
        envs.reset(seed=[1, 2, 3])
    with pytest.raises(trundle.TrundleError, match=r"environment 1.*grasp"):
        envs.reset(
            options={"grasp": (9.0, 0.0), "reset_mask": np.array([False, True])},
        )
    with pytest.raises(trundle.TrundleError, match="must not be negative"):
        envs.reset(seed=[1, -1])
    with pytest.raises(trundle.TrundleError, match="reset_mask"):
        envs.reset(options={"reset_mask": [True, False, True]})
    with pytest.raises(IndexError, match="environment 7"):
        envs.snapshot(7)
    with pytest.raises(trundle.TrundleError, match="num_envs"):
        LockedWheelVec(0)
    with pytest.raises(trundle.TrundleError, match="noise"):
        LockedWheelVec(2, noise=-1.0)
