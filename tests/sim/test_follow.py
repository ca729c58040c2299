"""`Push.follow`: a motion from another simulator in place of a step."""

from typing import Any

import gymnasium
import numpy as np
import pytest

import trundle
from trundle.envs import Observation


def make(**options: Any) -> Any:
    env: Any = gymnasium.make("trundle/PushAround-v1", noise=0.0, **options).unwrapped
    env.reset(seed=4)
    return env


def resting(pose: Any, substeps: int = 25) -> tuple[Any, Any, Any]:
    return np.tile(pose, (substeps, 1)), np.zeros((substeps, 3)), np.zeros((substeps, 3))


def test_the_observation_is_that_of_the_given_motion() -> None:
    env = make()
    pose, grasp = [0.3, -0.4, 0.5], Observation(env.reset(seed=4)[0]).grasp
    twists, wrench = np.tile([0.2, 0.1, -0.3], (25, 1)), np.array([30.0, -10.0, 4.0])
    about_origin = [30.0, -10.0, 4.0 + grasp[0] * -10.0 - grasp[1] * 30.0]
    found, *_ = env.follow(np.tile(pose, (25, 1)), twists, np.tile(about_origin, (25, 1)))
    seen = Observation(found)
    # The heading and the tare have hardly any noise left.
    assert seen.pose == pytest.approx(pose)
    assert seen.twist == pytest.approx(twists[0])
    assert seen.wrench == pytest.approx(wrench)
    assert np.array_equal(seen.goal_vector, Observation(env.reset(seed=4)[0]).goal_vector)


def test_the_reward_is_the_published_cost() -> None:
    env = make()
    pose = np.array([0.3, -0.4, 0.5])
    goal = np.array(env.scene()["goal"])
    distance = np.hypot(*(pose - goal)[:2])
    heading = abs(np.angle(np.exp(1j * (pose - goal)[2])))
    impulses = np.zeros(25)
    impulses[:5] = 0.4
    _, reward, _, _, info = env.follow(*resting(pose), impulses)
    touch = 10.0 * 0.01
    assert reward == pytest.approx(-0.05 * (distance + 0.3 * heading + 0.05) - touch)
    assert info["touched"]
    assert info["contact_time"] == pytest.approx(0.01)
    assert info["contact_impulse"] == pytest.approx(2.0)


def test_the_goal_ends_the_episode_and_a_reset_begins_another() -> None:
    env = make()
    _, _, terminated, _, info = env.follow(*resting(env.scene()["goal"]))
    assert terminated
    assert info["success_without_touching"]
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.follow(*resting(env.scene()["goal"]))


def test_a_step_after_it_starts_from_the_given_state() -> None:
    env = make(hidden="none")
    x, y, heading = env.scene()["object"]
    env.follow(np.tile([x, y, heading], (25, 1)), np.tile([0.2, 0.0, 0.0], (25, 1)), np.zeros((25, 3)))
    found, *_ = env.step(np.zeros(3, dtype=np.float32))
    # A freely rolling table keeps its velocity.
    assert Observation(found).pose == pytest.approx([x + 0.01, y, heading], abs=1e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"poses": np.zeros((25, 2))}, r"\(n, 3\)"),
        ({"substeps": 24}, "24 instead of 25"),
        ({"impulses": np.zeros(3)}, r"impulses of shape \(3,\)"),
        ({"wrenches": "none"}, "could not convert"),
        ({"twists": np.full((25, 3), np.nan)}, "not finite in step 0"),
        ({"options": {"action": "velocity"}}, "wrench"),
        ({"options": {"arm": {"lag": 0.1}}}, "arm"),
        ({"options": {"realtime": 0.02}}, "arm"),
    ],
    ids=["shape", "count", "impulses", "numbers", "finite", "action", "arm", "realtime"],
)
def test_other_motions_are_refused_and_change_nothing(change: dict[str, Any], message: str) -> None:
    env = make(**change.pop("options", {}))
    before = env.scene()["object"]
    poses, twists, wrenches = resting(before, change.pop("substeps", 25))
    given = {"poses": poses, "twists": twists, "wrenches": wrenches, **change}
    with pytest.raises(trundle.TrundleError, match=message):
        env.follow(**given)
    assert env.scene()["object"] == before
