"""The plant in MuJoCo moves as trundle's, on other physics."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded

import trundle
from trundle.envs import Observation
from trundle.experiments.comparison.config import Agent, Worlds
from trundle.experiments.comparison.episode import play
from trundle.experiments.comparison.world import make_world

pytest.importorskip("mujoco", reason="the extra [mujoco] is not installed")

from trundle.experiments.comparison.mujoco_plant import MujocoPlant

SEEDS = range(600_000, 600_012)
SLIDING = {"hidden": "none", "effects": [{"kind": "support_friction", "force": 40.0, "spread": 1.0}]}


def worlds(simulator: Any, **options: Any) -> Worlds:
    return Worlds("", "trundle/PushAroundMedium-v1", 0, 1, [], options, simulator=simulator)


def last_poses(simulator: Any, seed: int, **options: Any) -> tuple[Any, Any, bool]:
    """Return the first and the last observed pose of random pushes, and whether an obstacle was touched."""
    env, first = make_world(worlds(simulator, **options), seed, {})
    assert isinstance(env, MujocoPlant) == (simulator == "mujoco")
    rng, touched, last = np.random.default_rng(seed), False, first
    for _ in range(6):
        action = rng.uniform(-0.4, 0.4, 3).astype(np.float32)
        for _ in range(4):
            last, _, terminated, _, info = env.step(action)
            touched |= info["touched"]
            if terminated:
                return Observation(first).pose, Observation(last).pose, touched
    return Observation(first).pose, Observation(last).pose, touched


def has_caster(seed: int, options: dict[str, Any]) -> bool:
    env: Any = make_world(worlds("trundle", **options), seed, {})[0].unwrapped
    return any(effect["kind"] == "caster_swivel" for effect in env.hidden_model().get("effect", ()))


@pytest.mark.parametrize(
    "options", [{"hidden": "locked"}, {"hidden": "wheels"}, SLIDING], ids=["locked", "wheels", "sliding"]
)
def test_both_engines_move_the_object_alike(options: dict[str, Any]) -> None:
    compared = 0
    for seed in SEEDS:
        if has_caster(seed, options):
            # The first direction of a caster and the slip of its tyre differ.
            continue
        start, ours, touched = last_poses("trundle", seed, **options)
        same_start, theirs, also = last_poses("mujoco", seed, **options)
        assert np.array_equal(start, same_start)
        if touched or also:
            continue
        way = np.hypot(*(ours - start)[:2])
        # Balls slip and have inertia of their own.
        assert np.hypot(*(theirs - ours)[:2]) < 0.02 + 0.05 * way, seed
        assert abs(np.angle(np.exp(1j * (theirs - ours)[2]))) < 0.08, seed
        compared += 1
    assert compared >= 6


def test_contact_with_an_obstacle_is_reported_and_stops_the_object() -> None:
    env = MujocoPlant(gymnasium.make("trundle/PushAround-v1", noise=0.0, hidden="none"))
    env.reset(seed=3)
    push: Any = env.unwrapped
    for _ in range(60):
        scene = push.scene()
        middle = np.mean(scene["obstacles"][0], axis=0)
        x, y, heading = scene["object"]
        way = np.array([middle[0] - x, middle[1] - y])
        c, s = np.cos(heading), np.sin(heading)
        force = 0.4 * np.array([[c, s], [-s, c]]) @ (way / np.hypot(*way))
        _, _, terminated, _, info = env.step(np.array([*force, 0.0], dtype=np.float32))
        if terminated or info["contact_time"] > 0.2:
            break
    assert info["contact_time"] > 0.0
    assert info["contact_impulse"] > 1.0


def test_the_adaptive_agent_reaches_goals_in_mujoco() -> None:
    for seed in (620_000, 620_001):
        row, _ = play(worlds("mujoco"), Agent("", "adaptive"), 0, seed)
        assert row["success"], seed
        assert row["touches"] == 0, seed


def test_actions_are_clipped() -> None:
    last = []
    for size in (1.0, 3.0):
        env, _ = make_world(worlds("mujoco"), 600_001, {})
        for _ in range(4):
            last.append(env.step(np.full(3, size, dtype=np.float32))[0])
    assert np.array_equal(last[:4], last[4:])


def test_other_objects_and_effects_are_refused() -> None:
    with pytest.raises(trundle.TrundleError, match="action"):
        MujocoPlant(gymnasium.make("trundle/PushAround-v1", action="velocity"))
    with pytest.raises(ResetNeeded):
        MujocoPlant(gymnasium.make("trundle/PushAround-v1")).step(np.zeros(3, dtype=np.float32))
    env = MujocoPlant(gymnasium.make("trundle/PushAround-v1", effects=[{"kind": "spin_drag", "spin": 5.0}]))
    with pytest.raises(trundle.TrundleError, match="spin_drag"):
        env.reset(seed=0)


def test_the_time_limit_holds() -> None:
    env = MujocoPlant(gymnasium.make("trundle/PushAround-v1", max_episode_steps=3))
    env.reset(seed=0)
    ends = [env.step(np.zeros(3, dtype=np.float32))[3] for _ in range(3)]
    assert ends == [False, False, True]
