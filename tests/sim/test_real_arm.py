"""Options of the arm and of the time that decisions take."""

from __future__ import annotations

import pickle
import time
from typing import Any

import gymnasium
import numpy as np
import pytest
from numpy.typing import NDArray

import trundle
from trundle.envs import Observation, PushPose

START = {"start": (0.0, 0.0, 0.0), "goal": (2.0, 2.0, 0.0)}
ALL: dict[str, Any] = {
    "arm": {"lag": 0.08, "rate": 8.0, "delay": 0.03, "saturation": 0.9, "noise": 0.02, "wrist": {}},
    "sensor_delay": 0.07,
    "realtime": 0.02,
}


def forces(steps: int = 4, **options: Any) -> NDArray[np.float64]:
    """Return the measured forces of a push of 50 N, N."""
    env = PushPose(version=1, hidden="none", noise=0.0, **options)
    env.reset(seed=0, options=START)
    action = np.array([0.5, 0.0, 0.0], dtype=np.float32)
    return np.array([Observation(env.step(action)[0]).force[0] for _ in range(steps)])


def test_a_lag_is_exponential() -> None:
    seconds = 0.05 * np.arange(1, 5)
    # The command ramps within 20 ms, which delays it by 10 ms on average.
    expected = 50.0 * (1.0 - np.exp(-(seconds - 0.01) / 0.08))
    np.testing.assert_allclose(forces(arm={"lag": 0.08}), expected, rtol=0.02)


@pytest.mark.parametrize("options", [{"arm": {"delay": 0.1}}, {"realtime": 0.05, "arm": {"delay": 0.05}}])
def test_delay_and_decision_time_add_up(options: dict[str, Any]) -> None:
    np.testing.assert_allclose(forces(**options), [0.0, 0.0, 50.0, 50.0], atol=1e-9)


def test_a_sensor_delay_shows_the_past() -> None:
    prompt, late = forces(5), forces(5, sensor_delay=0.1)
    np.testing.assert_allclose(late[2:], prompt[:3], atol=1e-9)
    np.testing.assert_allclose(late[:2], 0.0, atol=1e-9)


def test_rate_and_saturation_limit_the_force() -> None:
    np.testing.assert_allclose(forces(2, arm={"rate": 2.0}), [10.0, 20.0], rtol=0.02)
    np.testing.assert_allclose(forces(2, arm={"saturation": 0.3}), [30.0, 30.0], rtol=1e-6)


def test_a_soft_wrist_reaches_the_commanded_force_late() -> None:
    felt = forces(15, arm={"wrist": {"stiffness": 500.0, "damping": 40.0}})
    assert felt[0] < 45.0
    # The hand of 2 kg in front of the table of 22 kg.
    assert felt[-1] == pytest.approx(50.0 * 22.0 / 24.0, rel=0.01)


def test_a_slow_decision_lengthens_the_step() -> None:
    env: Any = gymnasium.make("trundle/PushPose-v1", realtime=0.12, horizon=10)
    env.reset(seed=0)
    still = np.zeros(3, dtype=np.float32)
    ends = [env.step(still) for _ in range(4)]
    assert [end[4]["duration"] for end in ends] == pytest.approx([0.15, 0.15, 0.15, 0.05])
    assert [end[3] for end in ends] == [False, False, False, True]


def test_a_measured_decision_lets_the_world_go_on() -> None:
    env = PushPose(version=1, realtime="measured")
    env.reset(seed=0)
    time.sleep(0.11)
    assert env.step(np.zeros(3, dtype=np.float32))[4]["duration"] >= 0.15 - 1e-9


@pytest.mark.parametrize("action", ["wrench", "velocity", "regrasp", "push"])
def test_copies_and_batches_with_a_real_arm_are_identical(action: str) -> None:
    options = {**ALL, "action": action}
    if action == "push":
        options["arm"] = {key: value for key, value in ALL["arm"].items() if key != "wrist"}
    envs = gymnasium.make_vec("trundle/PushAroundHard-v1", num_envs=2, **options)
    env: Any = gymnasium.make("trundle/PushAroundHard-v1", **options)
    width = env.action_space.shape[0]
    given = np.random.default_rng(0).uniform(-0.4, 0.4, (12, 2, width)).astype(np.float32)
    envs.reset(seed=4)
    env.reset(seed=5)
    for number, step in enumerate(given):
        together, alone = envs.step(step)[0][1], env.step(step[1])[0]
        np.testing.assert_array_equal(together, alone)
        if number == 6:
            kept = pickle.loads(pickle.dumps(env.unwrapped.snapshot()))
    env.unwrapped.restore(kept)
    for step in given[7:]:
        repeated = env.step(step[1])[0]
    np.testing.assert_array_equal(repeated, alone)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"arm": {"lag": 3.0}}, r"arm\.lag"),
        ({"arm": {"laag": 0.1}}, "laag"),
        ({"arm": {"wrist": {}}, "action": "push"}, "wrist"),
        ({"arm": 0.1}, "mapping"),
        ({"realtime": "measure"}, "measured"),
        ({"realtime": -0.1}, "realtime"),
        ({"sensor_delay": 2.0}, "sensor_delay"),
        ({"level": "easy", "object": "bed"}, "one of them"),
        ({"level": "easy", "mass": (1, 2)}, "mass"),
        ({"mass": (1, 2)}, "random"),
        ({"friction": (2, 1)}, "friction"),
        ({"touch_cost": -1.0}, "touch_cost"),
        ({"dtype": "int32"}, "dtype"),
    ],
)
def test_invalid_options_are_named(options: dict[str, Any], message: str) -> None:
    with pytest.raises(trundle.TrundleError, match=message):
        PushPose(version=1, **options)
