"""The estimate of an arm from commands and readings, and its use by `trundle.AdaptiveAgent`."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
from numpy.typing import NDArray

import trundle
from trundle._native import _ArmEstimate
from trundle.agent import Belief
from trundle.envs import Observation

STEPS = 24


def pushed(seed: int = 3, **options: Any) -> tuple[Belief, float]:
    """Return a belief after random pushes of a freely rolling object, and the mass of the object, kg."""
    env = gymnasium.make("trundle/PushPose-v1", hidden="none", **options)
    agent = trundle.AdaptiveAgent(env)
    observation, _ = env.reset(seed=seed)
    belief = agent._first_belief(Observation(observation))
    random = np.random.default_rng(seed)
    for _ in range(STEPS):
        action = random.uniform(-0.4, 0.4, 3).astype(np.float32)
        belief.command = action * agent._scale
        belief.observe(Observation(env.step(action)[0]))
    source: Any = env.unwrapped
    return belief, source.hidden_model()["body"]["mass"]


def response(**options: Any) -> _ArmEstimate:
    """Return the estimate after random pushes."""
    belief, _ = pushed(**options)
    assert belief.arm is not None
    return belief.arm


@pytest.mark.parametrize("lag", [0.05, 0.08, 0.15])
@pytest.mark.parametrize("delay", [0.0, 0.05, 0.1])
def test_lag_and_delay_of_an_environment_are_recovered(lag: float, delay: float) -> None:
    found = response(arm={"lag": lag, "delay": delay})
    assert found.delay == pytest.approx(delay, abs=0.011)
    for kind, values in (found.force, found.torque):
        assert kind == "lag"
        assert dict(values)["time_constant"] == pytest.approx(lag, rel=0.15)


def test_delays_of_arm_sensors_and_decisions_add_up() -> None:
    found = response(arm={"lag": 0.08, "delay": 0.03}, sensor_delay=0.04, realtime=0.05)
    assert found.delay == pytest.approx(0.12, abs=0.011)


def test_a_soft_wrist_is_recognised() -> None:
    kind, values = response(arm={"wrist": {}}).force
    # A hand of 2 kg at 2000 N/m in front of an object of about 20 kg.
    assert kind == "compliant"
    assert dict(values)["frequency"] == pytest.approx(33.0, rel=0.25)


def test_an_ideal_arm_changes_no_action() -> None:
    def actions(arm: bool) -> list[Any]:
        env = gymnasium.make("trundle/PushAround-v1", hidden="locked")
        agent = trundle.AdaptiveAgent(env, trundle.AgentSettings(arm=arm))
        observation, _ = env.reset(seed=5)
        chosen = []
        for step in range(12):
            action, _ = agent.predict(observation, episode_start=step == 0)
            observation = env.step(action)[0]
            chosen.append(action.tolist())
        return chosen

    assert actions(True) == actions(False)


@pytest.mark.parametrize(
    ("options", "share"),
    [({"arm": {"lag": 0.08}}, 0.2), ({"sensor_delay": 0.04}, 0.3), ({"arm": {"wrist": {}}}, 0.3)],
)
def test_impulses_explain_the_change_of_speed(options: dict[str, Any], share: float) -> None:
    belief, mass = pushed(noise=0.0, **options)

    def error() -> float:
        before, wrench, dt, after = belief.transitions(0.05, 0.02)
        force = [turned(one, heading) for one, heading in zip(wrench[:, :2], before[:, 2], strict=True)]
        # The mean force is rotated by the heading at the start of the action only.
        missing = np.array(force) * dt[:, None] - mass * (after[:, 3:5] - before[:, 3:5])
        return float(np.sqrt(np.mean(missing**2)))

    columns = belief.columns(0.05, 0.02)
    assert np.all(np.diff(columns["t"]) > 0)
    assert np.isfinite(columns["force_x"]).all() and np.isnan(columns["object_x"]).sum() == 4 * STEPS
    estimated = error()
    belief.arm = None
    assert estimated < share * error()


def turned(vector: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([cos * vector[0] - sin * vector[1], sin * vector[0] + cos * vector[1]])


def test_the_estimate_is_shown() -> None:
    assert "lag 80 ms" in repr(response(arm={"lag": 0.08}))


def test_invalid_times_are_refused() -> None:
    with pytest.raises(trundle.TrundleError, match="give 0 < rise <= period"):
        _ArmEstimate(0.05, 0.06, [100.0, 100.0, 40.0])


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ({"mass": 0.0}, "mass = 0"),
        ({"starts": 1001}, "starts = 1001: must be 1 to 1000"),
        ({"seed": -1}, "seed = -1"),
        ({"learner": "linear", "diagnose": True}, "a regression cannot be diagnosed"),
    ],
)
def test_invalid_settings_are_refused(values: dict[str, Any], reason: str) -> None:
    with pytest.raises(trundle.TrundleError, match=reason):
        trundle.AgentSettings(**values)


def test_unknown_settings_are_refused() -> None:
    with pytest.raises(TypeError, match="diagnos"):
        trundle.AgentSettings(diagnos=True)  # type: ignore[call-arg]
