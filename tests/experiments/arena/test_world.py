"""gym-pusht with hidden parameters: what is the benchmark's, and what changes."""

from __future__ import annotations

import importlib.util
import sys
from dataclasses import asdict, replace

import gymnasium
import numpy as np
import pytest

import trundle
from trundle.experiments.arena import world
from trundle.experiments.arena.probe import START, displacement
from trundle.experiments.arena.world import NOMINAL, PHYSICS, Hidden, draw, make

needs_pusht = pytest.mark.skipif(
    importlib.util.find_spec("gym_pusht") is None,
    reason="the arena needs gym-pusht: pip install trundle[arena]",
)
TARGETS = np.random.default_rng(0).uniform(150.0, 350.0, (40, 2))


def test_a_missing_benchmark_is_named_with_its_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.partition(".")[0] == "gym_pusht"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "gym_pusht", None)
    with pytest.raises(trundle.TrundleError, match=r"gym_pusht: pip install 'trundle\[arena\]'"):
        make()


def test_an_unknown_physics_is_named_with_the_choices() -> None:
    with pytest.raises(trundle.TrundleError, match="'wet': choose original, sliding"):
        make("wet")


def test_parameters_are_drawn_in_their_ranges() -> None:
    rng = np.random.default_rng(1)
    found = np.array([list(asdict(draw(rng)).values()) for _ in range(2000)])
    offset = world.OFFSET_PX
    low, high = zip(world.MASS, world.FRICTION_PX_PER_S2, (-offset, offset), (-offset, offset), strict=True)
    assert np.all(found >= low) and np.all(found <= high)
    width = np.subtract(high, low)
    assert np.all(found.min(0) < low + 0.02 * width) and np.all(found.max(0) > high - 0.02 * width)
    assert np.median(found[:, 1]) == pytest.approx(NOMINAL.friction, rel=0.1)


@needs_pusht
def test_nominal_parameters_leave_the_benchmark_as_it_is() -> None:
    hidden = make()
    published = gymnasium.make("gym_pusht/PushT-v0", disable_env_checker=True)
    first, _ = hidden.reset(seed=5, options={"reset_to_state": START, "hidden": asdict(NOMINAL)})
    expected, _ = published.reset(seed=5, options={"reset_to_state": START})
    np.testing.assert_allclose(first, expected, rtol=0, atol=1e-9)
    moved = expected[2:].copy()
    for target in TARGETS:
        found, *rest = hidden.step(target)
        expected, *others = published.step(target)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6)
        assert rest[0] == pytest.approx(others[0], abs=1e-8)
        assert rest[1:3] == others[1:3] and rest[3].keys() == others[3].keys()  # type: ignore[attr-defined]
    assert np.linalg.norm(expected[2:4] - moved[:2]) > 20.0
    assert hidden.observation_space == published.observation_space
    assert hidden.env.get_wrapper_attr("_max_episode_steps") == published.get_wrapper_attr(
        "_max_episode_steps"
    )


@needs_pusht
@pytest.mark.parametrize("physics", PHYSICS)
def test_the_seed_determines_start_and_parameters(physics: str) -> None:
    env = make(physics)
    published = gymnasium.make("gym_pusht/PushT-v0", disable_env_checker=True)
    ends, hidden = [], []
    for seed in (7, 7, 8):
        start, info = env.reset(seed=seed)
        np.testing.assert_allclose(start, published.reset(seed=seed)[0], rtol=0, atol=1e-9)
        assert "hidden" not in info
        hidden.append(env.hidden)
        ends.append([env.step(target)[0] for target in TARGETS][-1])
    assert hidden[0] == hidden[1] != hidden[2]
    np.testing.assert_array_equal(ends[0], ends[1])


@needs_pusht
@pytest.mark.parametrize("physics", PHYSICS)
def test_the_reset_block_has_the_parameters_and_the_pose_of_the_observation(physics: str) -> None:
    env = make(physics)
    observation, _ = env.reset(seed=9)
    bare = env.unwrapped
    assert isinstance(bare, gymnasium.Env)
    block = bare.block  # type: ignore[attr-defined]
    assert block.mass == env.hidden.mass
    assert block.moment == pytest.approx(3000.0 * env.hidden.mass)
    assert tuple(block.center_of_gravity) == pytest.approx((env.hidden.offset_x, 45.0 + env.hidden.offset_y))
    resting = env.step(observation[:2])[0]
    np.testing.assert_allclose(resting, observation, rtol=0, atol=1e-9)


@needs_pusht
def test_the_floor_slows_a_sliding_block_by_dry_friction() -> None:
    env = make("sliding")
    hidden = {"mass": 2.0, "friction": 800.0, "offset_x": 20.0, "offset_y": -10.0}
    env.reset(seed=0, options={"reset_to_state": [40.0, 40.0, 256.0, 256.0, 0.3], "hidden": hidden})
    bare = env.unwrapped
    block, space = bare.block, bare.space  # type: ignore[attr-defined]
    block.velocity, block.angular_velocity = (300.0, -400.0), 6.0
    for _ in range(10):
        space.step(0.01)
    assert block.velocity.length == pytest.approx(500.0 - 800.0 * 0.1, rel=1e-6)
    assert block.velocity.angle == pytest.approx(np.arctan2(-400.0, 300.0), abs=1e-6)
    assert block.angular_velocity == pytest.approx(6.0 - 800.0 * 40.0 / 3000.0 * 0.1, rel=1e-6)


@needs_pusht
@pytest.mark.parametrize(
    ("changed", "original", "sliding"),
    [
        (replace(NOMINAL, mass=3.0), False, True),
        (replace(NOMINAL, friction=200.0), False, True),
        (replace(NOMINAL, offset_x=30.0), True, True),
        (replace(NOMINAL, offset_y=-30.0), True, True),
    ],
)
def test_only_the_centre_of_mass_matters_in_the_published_physics(
    changed: Hidden, original: bool, sliding: bool
) -> None:
    for physics, matters in zip(PHYSICS, (original, sliding), strict=True):
        moved = displacement(changed, physics)
        assert moved > 5.0 if matters else moved == 0.0
