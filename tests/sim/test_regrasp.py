"""`action="regrasp"`: the gripper releases the object and grasps it elsewhere a second later."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.error import InvalidAction
from numpy.typing import NDArray

import trundle
from trundle.cli import main
from trundle.envs import Observation, Oracle, Push

AWAY = 20
"""Number of actions of a regrasp."""
POSE = "trundle/PushPose-v0"
MIDDLE = {"start": (0.0, 0.0, 0.0), "goal": (2.0, 2.0, 0.0)}
Env = gymnasium.Env[Any, NDArray[np.float32]]
Action = NDArray[np.float32]


def act(*wrench: float, to: tuple[float, float] | None = None) -> Action:
    x, y = (0.0, 0.0) if to is None else to
    return np.array([*wrench, x, y, -1.0 if to is None else 1.0], dtype=np.float32)


def wandering(count: int, seed: int = 0) -> list[Action]:
    """Return wrenches with a regrasp in every thirtieth action."""
    drawn = np.random.default_rng(seed).uniform(-0.3, 0.3, (count, 6)).astype(np.float32)
    drawn[:, 3:5] *= 3.0
    drawn[:, 5] = np.where(np.arange(count) % 30 == 3, 0.5, -0.5)
    return list(drawn)


def rollout(env: Env, given: list[Action]) -> list[tuple[list[float], float, bool]]:
    steps = []
    for action in given:
        observation, reward, terminated, truncated, _ = env.step(action)
        steps.append((observation.tolist(), float(reward), terminated))
        if terminated or truncated:
            break
    return steps


def test_the_action_space_has_three_more_entries() -> None:
    env = Push(action="regrasp")
    assert env.action_space == gymnasium.spaces.Box(-1.0, 1.0, (6,), np.float32)
    assert env.ACTION_SCALE.tolist() == [100.0, 100.0, 40.0, 1.0, 1.0, 1.0]
    assert env.control == 0.05


def test_a_regrasp_takes_a_second_without_a_wrench() -> None:
    env = Push(action="regrasp", hidden="none", noise=0.0)
    env.reset(seed=0, options=MIDDLE)
    rollout(env, [act(0.3, 0.0, 0.0)] * 5)
    steps = rollout(env, [act(1.0, 1.0, 1.0, to=(1.0, 0.5))] * AWAY)
    seen = Observation(np.array([row for row, _, _ in steps]))
    # The gripper releases the object within the step, so that the first sample already has the speed of the
    # last.
    np.testing.assert_allclose(seen.twist, np.tile(seen.twist[0], (AWAY, 1)), atol=1e-12)
    assert seen.velocity[0, 0] > 0.2
    assert not seen.wrench.any()
    share = np.arange(1, AWAY + 1)[:, None] / AWAY
    np.testing.assert_allclose(seen.grasp, (-0.6, 0.0) + share * (1.2, 0.2), atol=1e-12)
    assert seen.grasp[-1] == pytest.approx((0.6, 0.2), abs=1e-12)
    after = Observation(env.step(act(0.0, 0.25, 0.0))[0])
    assert after.force.tolist() == [0.0, 25.0]
    # 25 N to the left at 0.6 m ahead of the mass centre turn the table left; they rise within 20 ms.
    inertia = 22.0 * (1.2**2 + 0.8**2) / 12
    assert after.spin == pytest.approx(25.0 * 0.6 / inertia * 0.04, rel=1e-3)


def test_a_regrasped_object_moves_like_one_held_there() -> None:
    options: dict[str, Any] = {"hidden": "locked", "noise": 0.0}
    went, held = Push(action="regrasp", **options), Push(action="wrench", **options)
    went.reset(seed=5, options=MIDDLE)
    rollout(went, [act(0.0, 0.0, 0.0, to=(0.5, -0.5))] * AWAY)
    held.reset(seed=5, options={**MIDDLE, "grasp": (0.3, -0.2)})
    given = [act(*row[:3]) for row in wandering(30)]
    ours, theirs = rollout(went, given), rollout(held, [action[:3] for action in given])
    assert ours == theirs


@pytest.mark.parametrize("effects", [(), ({"kind": "gripper_inertia", "mass": 3.0},)])
def test_a_regrasp_causes_no_impulse_in_the_reading(
    effects: tuple[dict[str, Any], ...], tmp_path: Path
) -> None:
    env: Env = trundle.Record(
        Push(action="regrasp", hidden="none", noise=0.0, effects=effects), tmp_path / "r"
    )
    env.reset(seed=0, options=MIDDLE)
    rollout(env, [act(0.2, 0.0, 0.0)] * 5)
    rollout(env, [act(0.0, 0.0, 0.0, to=(1.0, 1.0))] * AWAY + [act(0.0, 0.0, 0.0)] * 5)
    env.close()
    columns = trundle.read(tmp_path / "r").episodes["episode_00"]
    t, force, torque = (columns[key] for key in ("t", "force_x", "torque_z"))
    # The gripper releases the object 0.25 s after contact, which begins 0.4 s after the start of the
    # recording.
    away = np.isfinite(force) & (t > 0.65 + 1e-6)
    assert away.sum() > 240
    np.testing.assert_allclose(force[away], force[0], atol=1e-6)
    np.testing.assert_allclose(torque[away], torque[0], atol=1e-6)


@pytest.mark.parametrize(
    "duplicate", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env)), lambda env: restored(env)]
)
def test_a_copy_during_a_regrasp_continues_identically(duplicate: Callable[[Env], Env]) -> None:
    env: Env = gymnasium.make("trundle/PushDoor-v0", action="regrasp", hidden="catalogue")
    env.reset(seed=1)
    rollout(env, wandering(12))
    other = duplicate(env)
    given = wandering(40, seed=1)
    assert rollout(other, given) == rollout(env, given)


def restored(env: Env) -> Env:
    source: Any = env.unwrapped
    other: Any = gymnasium.make("trundle/PushDoor-v0", action="regrasp", hidden="catalogue")
    other.reset(seed=9)
    other.unwrapped.restore(pickle.loads(pickle.dumps(source.snapshot())))
    return other  # type: ignore[no-any-return]


@pytest.mark.parametrize("count", [3, 20])
def test_a_batch_with_regrasps_steps_like_single_environments(count: int) -> None:
    options: dict[str, Any] = {"action": "regrasp", "object": "household", "horizon": 0}
    batch = gymnasium.make_vec(POSE, num_envs=count, autoreset_mode="Disabled", **options)
    singles = [Push(**options) for _ in range(count)]
    batch.reset(seed=3)
    for index, env in enumerate(singles):
        env.reset(seed=3 + index)
    drawn = np.stack([wandering(40, seed) for seed in range(count)], axis=1) * np.float32(0.1)
    for actions in drawn:
        seen = batch.step(actions)[0]
        np.testing.assert_array_equal(seen, [env.step(a)[0] for env, a in zip(singles, actions, strict=True)])


def test_wrappers_and_goal_environments_support_regrasps() -> None:
    informed = Oracle(gymnasium.make(POSE, action="regrasp", noise=0.0))
    goals: Env = gymnasium.make("trundle/PushPoseGoal-v0", action="regrasp", noise=0.0)
    first, _ = informed.reset(seed=0)
    goals.reset(seed=0)
    for _ in range(AWAY):
        flat, *_ = informed.step(act(0.0, 0.0, 0.0, to=(1.0, 1.0)))
        parted, *_ = goals.step(act(0.0, 0.0, 0.0, to=(1.0, 1.0)))
    np.testing.assert_allclose(Observation(flat).grasp, (0.6, 0.4))
    np.testing.assert_allclose(parted["observation"][-2:], (0.6, 0.4))
    assert first.size == flat.size == 26


@pytest.mark.parametrize(
    ("action", "words"),
    [
        (np.zeros(3), r"\(6,\), not \(3,\)"),
        (np.zeros((1, 6)), r"\(6,\), not \(1, 6\)"),
        (np.array([0, 0, 0, 0, 0, np.nan]), "NaN"),
        (np.array([0, 0, 0, 1.5, 0, 0]), "ClipAction"),
    ],
)
def test_an_invalid_action_is_refused(action: Any, words: str) -> None:
    env, batch = Push(action="regrasp"), gymnasium.make_vec(POSE, num_envs=2, action="regrasp")
    env.reset(seed=0)
    batch.reset(seed=0)
    with pytest.raises(InvalidAction, match=words):
        env.step(action.astype(np.float32))
    with pytest.raises(InvalidAction, match=r"\(2, 6\), not \(2, 3\)"):
        batch.step(np.zeros((2, 3)))


def test_the_image_shows_an_open_gripper_during_a_regrasp() -> None:
    env: Any = Push(action="regrasp", noise=0.0, render_mode="rgb_array")
    env.reset(seed=0, options=MIDDLE)
    held = env.render()
    env.step(act(0.0, 0.0, 0.0, to=(-1.0, 0.0)))
    away = env.render()
    rollout(env, [act(0.0, 0.0, 0.0)] * (AWAY - 1))
    np.testing.assert_array_equal(env.render(), held)
    assert not np.array_equal(away, held), "it goes nowhere, but does not hold"


def test_a_recording_with_a_regrasp_is_valid_and_can_be_fitted(tmp_path: Path) -> None:
    env = trundle.Record(gymnasium.make("trundle/LockedWheel-v0", action="regrasp"), tmp_path / "r")
    env.reset(seed=4, options=MIDDLE)
    random = np.random.default_rng(1)
    for k in range(120):
        if k % 8 == 0:
            wrench = random.uniform(-0.4, 0.4, 3)
        env.step(act(*wrench, to=(0.6, 0.5) if k == 50 else None))
    hidden: Any = env.unwrapped
    (wheel,) = hidden.hidden_model()["effect"]
    env.close()
    recording = trundle.read(tmp_path / "r")
    assert list(trundle.check(recording)) == []
    fit = trundle.fit(recording, starts=4, seed=0)
    found = {value["name"]: value["mean"] for value in fit.summary["parameters"]}
    assert found["body.mass"] == pytest.approx(22.0, rel=0.01)
    for axis in "xy":
        assert found[f"viscous_wheel.{axis}"] == pytest.approx(wheel[axis], abs=0.005)
    # A wheel rotated by 90° with exchanged coefficients is the same wheel.
    drags = sorted(found[f"viscous_wheel.mu_{axis}"] for axis in "xy")
    assert drags == pytest.approx(sorted(wheel[f"mu_{axis}"] for axis in "xy"), rel=0.02)


def test_a_slipping_gripper_is_diagnosed(tmp_path: Path) -> None:
    env = trundle.Record(gymnasium.make("trundle/LockedWheel-v0", action="regrasp"), tmp_path / "r")
    env.reset(seed=4, options=MIDDLE)
    for k in range(60):
        env.step(act(0.2, 0.1 * (-1) ** (k // 8), 0.0, to=(0.6, 0.5) if k == 20 else None))
    env.close()
    recording = trundle.read(tmp_path / "r")
    assert [found.kind for found in trundle.check(recording) if found.kind == "grasp"] == []
    columns = dict(recording.episodes["episode_00"])
    columns["gripper_x"] = columns["gripper_x"] + 0.2 * (columns["t"] - 2.4).clip(0.0)
    slips = trundle.Recording(recording.metadata, {"episode_00": columns})
    assert "grasp" in [found.kind for found in trundle.check(slips)]


def test_play_supports_regrasps(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = f"play PushPose --set action=regrasp --set horizon=40 --out {tmp_path / 'r'}"
    assert main(line.split()) == 0
    assert "episode 0" in capsys.readouterr().out
    assert len(trundle.read(tmp_path / "r").episodes) == 1
