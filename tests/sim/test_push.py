"""The pushing environments: requirements of Gymnasium, and documented properties."""

from __future__ import annotations

import copy
import pickle
import warnings
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.error import InvalidAction, ResetNeeded
from gymnasium.utils.env_checker import check_env
from numpy.typing import NDArray

import trundle
from trundle.envs import LockedWheel, Observation, Push, PushAround

LOCKED = "trundle/LockedWheel-v0"
FLAT = ("PushPose", "PushPath", "PushAround", "PushDoor", "LockedWheel")
GOALS = ("PushPoseGoal", "PushPathGoal", "PushAroundGoal", "PushDoorGoal")
MODES = ("wrench", "velocity", "push", "regrasp")
INFO = {
    *("is_success", "lost", "touched", "distance", "heading_error", "progress"),
    *("success_without_touching", "contact_time", "contact_impulse", "action_clipped", "duration"),
}
Env = gymnasium.Env[NDArray[np.float64], NDArray[np.float32]]


def actions(count: int, seed: int = 0, width: int = 3) -> NDArray[np.float32]:
    return np.random.default_rng(seed).uniform(-0.6, 0.6, (count, width)).astype(np.float32)


def rollout(env: Env, given: NDArray[np.float32]) -> list[tuple[list[float], float, bool]]:
    steps = []
    for action in given:
        observation, reward, terminated, truncated, _ = env.step(action)
        steps.append((observation.tolist(), float(reward), terminated))
        if terminated or truncated:
            break
    return steps


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", FLAT + GOALS)
def test_the_strict_checker_of_gymnasium_passes(
    name: str, mode: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    env = gymnasium.make(f"trundle/{name}-v0", action=mode, object="household")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped, skip_render_check=True)


def test_ids_are_registered_without_an_import() -> None:
    assert isinstance(gymnasium.make(f"trundle:{LOCKED}").unwrapped, LockedWheel)


@pytest.mark.parametrize("name", FLAT)
def test_a_seed_determines_the_episodes(name: str) -> None:
    def episodes(seed: int) -> list[Any]:
        # The LockedWheel task already sets `hidden`.
        hidden: dict[str, Any] = {} if name == "LockedWheel" else {"hidden": "catalogue"}
        env: Env = gymnasium.make(f"trundle/{name}-v0", object="random", **hidden)
        first = env.reset(seed=seed)[0].tolist(), rollout(env, actions(50))
        return [first, env.reset()[0].tolist(), rollout(env, actions(50))]

    assert episodes(7) == episodes(7)
    assert episodes(7) != episodes(8)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_a_copy_continues_identically(duplicate: Callable[[Env], Env], mode: str) -> None:
    env: Env = gymnasium.make("trundle/PushDoor-v0", action=mode)
    width = 6 if mode == "regrasp" else 3
    env.reset(seed=1)
    rollout(env, actions(10, width=width))
    other = duplicate(env)
    later = actions(15, seed=1, width=width)
    assert rollout(other, later) == rollout(env, later)
    assert other.reset()[0].tolist() == env.reset()[0].tolist()


def test_a_planner_branches_from_snapshots() -> None:
    env, other = PushAround(horizon=20), PushAround(horizon=20)
    env.reset(seed=3)
    rollout(env, actions(10))
    here = env.snapshot()
    futures = []
    for seed in range(3):
        futures.append(rollout(env, actions(20, seed)))
        env.restore(here)
        assert rollout(env, actions(20, seed)) == futures[-1]
        env.restore(here)
    assert futures[0] != futures[1]
    assert len(futures[0]) == 10, "the clock is part of a snapshot"
    other.restore(pickle.loads(pickle.dumps(here)))
    assert rollout(other, actions(20, 2)) == futures[2]
    assert other.reset()[0].tolist() == env.reset()[0].tolist()
    with pytest.raises(trundle.TrundleError, match="other options"):
        PushAround(noise=0.0).restore(here)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", FLAT)
def test_observations_are_in_their_space_and_hide_the_model(name: str, mode: str) -> None:
    env: Env = gymnasium.make(f"trundle/{name}-v0", noise=10.0, action=mode)
    for seed in range(5):
        observation, info = env.reset(seed=seed)
        assert info == {} and observation in env.observation_space
        for action in np.sign(actions(20, seed, 6 if mode == "regrasp" else 3)):
            observation, _, terminated, _, info = env.step(action)
            assert observation in env.observation_space and set(info) == INFO
            if terminated:
                break


def test_hidden_wheels_are_invisible_before_a_push() -> None:
    env: Env = gymnasium.make(LOCKED, noise=0.0, render_mode="rgb_array")
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


def test_given_effects_are_hidden() -> None:
    slope = {"kind": "floor_slope", "accel_x": 0.2, "accel_y": 0.0}
    env = Push(hidden="none", effects=[slope], noise=0.0)
    env.reset(seed=0, options={"start": (0.0, 0.0, 1.0), "goal": (2.0, 0.0, 0.0)})
    seen = Observation(np.array(rollout(env, np.zeros((20, 3), dtype=np.float32))[-1][0]))
    assert seen.position[0] > 0.05 and abs(seen.position[1]) < 1e-3, "it rolls down the slope by itself"
    assert env.hidden_model()["effect"][0]["kind"] == "floor_slope"


def test_the_sensor_reads_the_inertia_of_the_gripper() -> None:
    heavy = {"kind": "gripper_inertia", "mass": 5.0}
    given = np.tile(np.array([0.8, 0.0, 0.0], dtype=np.float32), (2, 1))
    felt = []
    for effects in ([], [heavy]):
        env = Push(action="velocity", hidden="none", noise=0.0, effects=effects)
        env.reset(seed=0, options={"start": (0.0, 0.0, 0.0), "goal": (2.0, 2.0, 0.0)})
        felt.append(Observation(np.array(rollout(env, given)[0][0])).force[0])
    # 0.24 m/s are reached in 50 ms: 4.8 m/s² on 5 kg.
    assert felt[1] - felt[0] == pytest.approx(24.0, rel=0.05)


def test_a_delayed_reading_is_a_mean() -> None:
    def first_force(*effects: dict[str, Any]) -> float:
        env = Push(action="push", hidden="none", noise=0.0, effects=effects)
        env.reset(seed=0, options={"start": (0.0, 0.0, 0.0), "goal": (2.0, 2.0, 0.0)})
        return float(Observation(env.step(np.array([1.0, 0.0, 0.5], dtype=np.float32))[0]).force[0])

    assert (
        first_force({"kind": "latency", "delay": 0.05}) == pytest.approx(first_force(), rel=0.2)
        and first_force() > 1.0
    )


def test_a_short_action_is_reached_at_its_end() -> None:
    env = Push(substeps=5, hidden="none", noise=0.0)
    env.reset(seed=0, options={"start": (0.0, 0.0, 0.0), "goal": (2.0, 2.0, 0.0)})
    steps = rollout(env, np.array([[0.2, 0, 0], [0, 0, 0]] * 2, dtype=np.float32))
    speeds = Observation(np.array([row for row, _, _ in steps])).velocity[:, 0]
    # Each 10 ms with a mean of 10 N on 22 kg.
    np.testing.assert_allclose(np.diff(speeds, prepend=0.0), 0.1 / 22.0, rtol=1e-6)


def test_the_time_limit_truncates() -> None:
    env: Env = gymnasium.make(LOCKED)
    env.reset(seed=0)
    still = np.zeros(3, dtype=np.float32)
    ends = [env.step(still)[2:4] for _ in range(300)]
    assert ends[-1] == (False, True) and set(ends[:-1]) == {(False, False)}


def test_the_goal_ends_the_episode() -> None:
    env: Env = gymnasium.make(LOCKED)
    env.reset(seed=0, options={"start": (1.0, 1.0, 3.0), "goal": (1.0, 1.0, -3.2)})
    _, reward, terminated, _, info = env.step(np.zeros(3, dtype=np.float32))
    assert terminated and info["is_success"] and info["distance"] == 0.0
    assert info["heading_error"] == pytest.approx(6.2 - 2 * np.pi)
    assert reward == pytest.approx(-0.05 * 0.3 * abs(info["heading_error"]))


def test_the_sensor_reads_the_commanded_wrench() -> None:
    env = LockedWheel(noise=0.0)
    env.reset(seed=0)
    action = np.array([0.3, -0.2, 0.1], dtype=np.float32)
    observation = env.step(action)[0]
    np.testing.assert_allclose(Observation(observation).wrench, action * env.ACTION_SCALE, rtol=1e-6)


def test_the_gripper_has_the_commanded_velocity() -> None:
    env = Push(action="velocity", hidden="none", noise=0.0)
    env.reset(seed=0, options={"start": (0.0, 0.0, 0.0), "goal": (2.0, 2.0, 0.0)})
    ahead = np.tile(np.array([0.5, 0.0, 0.0], dtype=np.float32), (20, 1))
    observation = np.array(rollout(env, ahead)[-1][0])
    np.testing.assert_allclose(Observation(observation).twist, [0.15, 0.0, 0.0], atol=2e-3)


def test_a_gripper_stalls_at_an_obstacle() -> None:
    env = PushAround(action="velocity", hidden="none", noise=0.0, horizon=0)
    seen = Observation(env.reset(seed=0)[0])
    touched, most = False, 0.0
    for _ in range(200):
        # Straight towards the observed middle of the box.
        way = seen.box_position - seen.position
        action = np.append(way / np.hypot(*way), 0.0).astype(np.float32)
        observation, _, ended, _, info = env.step(np.clip(action, -1, 1))
        seen = Observation(observation)
        touched |= info["touched"]
        # The limits are at the grasp, along the object's axes; as the springs give, the gripper is beside it.
        assert np.hypot(*seen.force) <= np.hypot(100.0, 100.0) + 1e-9 and abs(seen.torque) <= 42.0
        most = max(most, np.abs(seen.force).max())
        if ended:
            break
    assert touched and most > 50.0


def test_a_push_follows_its_direction() -> None:
    env = Push(action="push", hidden="none", noise=0.0, object="office_table")
    env.reset(seed=0, options={"start": (0.0, 0.0, 0.0), "goal": (2.0, 2.0, 0.0)})
    behind = np.array([1.0, 0.0, 1.0], dtype=np.float32)
    after = Observation(env.step(behind)[0])
    assert after.position[0] > 0.1 and abs(after.position[1]) < 1e-6, "pushed at its rear it goes ahead"
    assert after.force[0] > 0 and after.grasp[0] == pytest.approx(-0.6, abs=1e-6)


@pytest.mark.parametrize(
    ("action", "words"),
    [
        (np.zeros(2), r"\(3,\).*\(2,\)"),
        (np.zeros((1, 3)), r"\(3,\).*\(1, 3\)"),
        (np.array([0.0, np.nan, 0.0]), "NaN"),
        (np.array([0.0, np.inf, 0.0]), "inf"),
        (np.array([0.0, 1.5, 0.0]), "ClipAction"),
        ("left", "numbers"),
    ],
)
def test_an_invalid_action_is_refused(action: Any, words: str) -> None:
    env = LockedWheel()
    env.reset(seed=0)
    for kind in (InvalidAction, trundle.TrundleError):
        with pytest.raises(kind, match=words):
            env.step(action.astype(np.float32) if isinstance(action, np.ndarray) else action)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"wheel": 3}, "wheel.*same_object"),
        ({"goal": (9.0, 0.0, 0.0)}, "goal"),
        ({"start": (0.0, 0.0)}, "start.*3 numbers"),
        ({"start": "here"}, "start.*3 numbers"),
        ({"grasp": (0.0, 0.5)}, "grasp.*on the object"),
    ],
)
def test_an_invalid_option_is_refused(options: dict[str, Any], words: str) -> None:
    with pytest.raises(trundle.TrundleError, match=words):
        LockedWheel().reset(seed=0, options=options)


def test_a_goal_in_an_obstacle_is_refused() -> None:
    env = PushAround()
    box = Observation(env.reset(seed=0)[0]).box_position
    with pytest.raises(trundle.TrundleError, match=r"goal.*obstacle"):
        env.reset(seed=0, options={"goal": (*box, 0.0)})


def test_the_order_of_calls_is_checked() -> None:
    env = LockedWheel(render_mode="rgb_array")
    still = np.zeros(3, dtype=np.float32)
    for call in (lambda: env.step(still), env.render, env.hidden_model):
        with pytest.raises(ResetNeeded):
            call()
    env.reset(options={"start": (0.0, 0.0, 0.0), "goal": (0.0, 0.0, 0.0)})
    env.step(still)
    with pytest.raises(ResetNeeded):
        env.step(still)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"noise": -1.0}, "noise = -1"),
        ({"render_mode": "ansi"}, "rgb_array"),
        ({"action": "kick"}, "velocity"),
        ({"object": "piano"}, "piano.*kitchen_table"),
        ({"object": []}, "object"),
        ({"hidden": "nothing"}, "catalogue"),
        ({"effects": [{"kind": "ghost"}]}, "ghost"),
        ({"substeps": 0}, "substeps"),
        ({"drop_out": 1.0}, "drop_out"),
        ({"horizon": -1}, "horizon"),
        ({"substeps": 2.5}, "substeps"),
        ({"effects": "ghost"}, "effects"),
        ({"object": 3}, "object"),
    ],
)
def test_invalid_constructor_arguments_are_refused(arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(trundle.TrundleError, match=words):
        Push(**arguments)
    with pytest.raises(TypeError, match="nois"):
        gymnasium.make("trundle/PushPose-v0", nois=1.0)


@pytest.mark.parametrize("name", ["PushPose", "PushPath", "PushAround", "PushDoor"])
def test_the_image_shows_the_object_at_its_position(name: str) -> None:
    env: Env = gymnasium.make(f"trundle/{name}-v0", render_mode="rgb_array", object="household")
    x, y = Observation(env.reset(seed=2)[0]).position
    picture = np.asarray(env.render()).astype(int)
    assert picture.shape == (480, 480, 3)
    row, column = int((2.75 - y) / 5.5 * 480), int((x + 2.75) / 5.5 * 480)
    window = picture[row - 12 : row + 12, column - 12 : column + 12].reshape(-1, 3)
    red, _, blue = np.median(window, axis=0)
    assert red > blue + 20, "furniture is brown"


def test_a_window_shows_each_step(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    pytest.importorskip("pygame", reason="a window needs pygame")
    env = gymnasium.make("trundle/PushDoor-v0", render_mode="human")
    shown: list[int] = []
    monkeypatch.setattr(
        trundle.envs.window.Window, "show", lambda self, pixels, fps: shown.append(pixels.size)
    )
    env.reset(seed=0)
    rollout(env, actions(3))
    env.close()
    assert len(shown) == 4


def test_a_video_is_recorded(tmp_path: Any) -> None:
    pytest.importorskip("moviepy", reason="RecordVideo needs moviepy")
    env = gymnasium.make("trundle/PushDoor-v0", render_mode="rgb_array", horizon=5)
    video = gymnasium.wrappers.RecordVideo(env, str(tmp_path))
    video.reset(seed=0)
    for action in actions(5):
        video.step(action)
    video.close()  # type: ignore[no-untyped-call]
    assert list(tmp_path.glob("*.mp4"))
