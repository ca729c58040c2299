"""Worlds depend on the seed only and are the same for all agents."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

import trundle
from trundle.envs import Observation
from trundle.experiments.comparison.config import Worlds
from trundle.experiments.comparison.world import draw_effects, make_world

FRICTION = {"kind": "coulomb_friction", "at": "foot", "force": [10.0, 30.0]}
BODY = {
    "footprint": [[-1.0, -0.5], [1.0, -0.5], [1.0, 0.5], [-1.0, 0.5]],
    "support": [[0.9, 0.4], [-0.9, 0.4]],
}


def unseen(effect: list[dict[str, Any]]) -> Worlds:
    options = {"hidden": "locked", "object": "random"}
    return Worlds("Unseen", "trundle/PushAround-v0", 0, 1, [], options, effect)


def hidden(worlds: Worlds, seed: int, **options: Any) -> tuple[Mapping[str, Any], Observation]:
    env, observation = make_world(worlds, seed, options)
    source: Any = env.unwrapped
    return source.hidden_model(), Observation(observation)


def test_an_effect_is_added_to_the_world_of_the_seed() -> None:
    for seed in range(5):
        plain, before = hidden(unseen([]), seed)
        more, after = hidden(unseen([FRICTION]), seed)
        assert more["body"] == plain["body"]
        assert more["effect"][:-1] == plain["effect"]
        added = more["effect"][-1]
        assert [added["x"], added["y"]] in plain["body"]["support"]
        assert 10 <= added["force"] <= 30
        for field in ("goal_pose", "half_size", "box_position", "box_direction", "box_half_size"):
            np.testing.assert_array_equal(getattr(before, field), getattr(after, field))


def test_the_world_does_not_depend_on_the_actions() -> None:
    by_wrench, first = hidden(unseen([FRICTION]), 3)
    by_velocity, second = hidden(unseen([FRICTION]), 3, action="velocity")
    assert by_wrench == by_velocity
    np.testing.assert_array_equal(first.goal_pose, second.goal_pose)


def test_values_are_fixed_ranges_or_choices() -> None:
    effects = [
        {"kind": "viscous_wheel", "at": "foot", "mu_x": [60.0, 90.0], "mu_y": 7.0, "angle": {"any": [0, 1]}}
    ]
    found = [draw_effects(effects, BODY, seed)[0] for seed in range(200)]
    assert {one["mu_y"] for one in found} == {7.0}
    assert {one["angle"] for one in found} == {0, 1}
    assert {(one["x"], one["y"]) for one in found} == {(0.9, 0.4), (-0.9, 0.4)}
    spread = np.array([one["mu_x"] for one in found])
    assert 60 <= spread.min() < 63
    assert 87 < spread.max() <= 90
    assert draw_effects(effects, BODY, 3) == draw_effects(effects, BODY, 3)


def test_a_place_lies_between_two_ellipses_in_any_direction() -> None:
    effects = [{"kind": "com_offset", "at": [0.3, 0.7]}]
    places = np.array([list(draw_effects(effects, BODY, seed)[0].values())[1:] for seed in range(300)])
    assert set(draw_effects(effects, BODY, 0)[0]) == {"kind", "com_x", "com_y"}
    shares = np.hypot(places[:, 0] / 1.0, places[:, 1] / 0.5)
    assert 0.3 <= shares.min() < 0.32
    assert 0.68 < shares.max() <= 0.7
    assert {(x > 0, y > 0) for x, y in places} == {(True, True), (True, False), (False, True), (False, False)}


def test_a_place_is_on_an_object_whose_origin_is_not_in_its_middle() -> None:
    body = {"footprint": [[-0.2, -0.4], [0.8, -0.4], [0.8, 0.1], [-0.2, 0.1]]}
    effects = [{"kind": "com_offset", "at": [0.5, 0.8]}]
    places = np.array([list(draw_effects(effects, body, seed)[0].values())[1:] for seed in range(300)])
    reached = np.array([places.min(axis=0), places.max(axis=0)])
    np.testing.assert_allclose(reached, [[-0.16, -0.32], [0.64, 0.08]], rtol=0.05)


@pytest.mark.parametrize(
    ("effect", "words"),
    [
        (
            {"kind": "coulomb_friction", "at": "foot", "force": [30.0, 10.0]},
            "force = [30.0, 10.0]: give a number",
        ),
        ({"kind": "coulomb_friction", "at": "foot", "force": {"all": [1]}}, "force = {'all': [1]}"),
        ({"kind": "coulomb_friction", "at": "feet", "force": 3.0}, "at = 'feet': give \"foot\""),
    ],
)
def test_invalid_values_are_refused(effect: dict[str, Any], words: str) -> None:
    with pytest.raises(trundle.TrundleError) as refused:
        draw_effects([effect], BODY, 0)
    assert words in str(refused.value)


def test_a_place_at_a_foot_needs_feet() -> None:
    with pytest.raises(trundle.TrundleError, match="has no supports"):
        draw_effects([FRICTION], {"footprint": BODY["footprint"]}, 0)


@pytest.mark.parametrize("options", [{"hiden": "locked"}, {"hidden": "lokced"}])
def test_an_environment_that_cannot_be_made_is_named(options: dict[str, Any]) -> None:
    worlds = Worlds("W", "trundle/PushAround-v0", 0, 1, [], options)
    with pytest.raises(trundle.TrundleError, match=r"hiden|lokced"):
        make_world(worlds, 0, {})


def test_other_environments_are_refused() -> None:
    for name in ("CartPole-v1", "trundle/Nothing-v0", "trundle/PushPoseGoal-v0"):
        with pytest.raises(trundle.TrundleError, match=name.split("/")[-1]):
            make_world(Worlds("W", name, 0, 1, []), 0, {})


def test_the_time_limit_is_that_of_the_environment() -> None:
    for options, limit in (({}, 15.0), ({"horizon": 40}, 2.0), ({"action": "push", "horizon": 2}, 2.0)):
        worlds = Worlds("W", "trundle/PushPose-v0", 0, 1, [], {"hidden": "none"})
        env, _ = make_world(worlds, 0, options)
        source: Any = env.unwrapped
        still, over, steps = np.zeros(3, dtype=np.float32), False, 0
        while not over:
            *_, terminated, truncated, info = env.step(still)
            over, steps = terminated or truncated, steps + 1
        assert not info["lost"]
        assert steps * source.control == pytest.approx(limit)
        assert source.horizon * source.control == pytest.approx(limit)
