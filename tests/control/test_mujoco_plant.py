"""The adaptive agent on a plant of another engine: `examples/mujoco_plant.py`."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType
from typing import Any

import gymnasium
import numpy as np
import pytest
import tomli_w
from gymnasium.utils.env_checker import check_env

import trundle

pytest.importorskip("mujoco", reason="the extra [mujoco] is not installed")

ROOT = Path(__file__).resolve().parents[2]
SEEDS = range(100, 105)


def the_example() -> ModuleType:
    spec = importlib.util.spec_from_file_location("mujoco_plant", ROOT / "examples/mujoco_plant.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


example = the_example()


def test_the_agent_reaches_goals_and_locates_the_stiff_roller() -> None:
    env = example.RollerTable()
    agent = trundle.AdaptiveAgent(env)
    reached, near = 0, 0
    for seed in SEEDS:
        info, model = example.play(env, agent, seed)
        reached += info["is_success"]
        found = {p["name"]: p["value"] for p in model.parameters}
        place = [found.get("viscous_wheel.x", np.inf), found.get("viscous_wheel.y", np.inf)]
        near += bool(np.linalg.norm(np.subtract(place, example.FEET[env.stuck])) < 0.15)
    assert reached >= 4
    assert near >= 4


def test_the_environment_has_the_spaces_of_push_pose_and_passes_check_env() -> None:
    env, ours = example.RollerTable(), gymnasium.make("trundle/PushPose-v0")
    assert env.action_space == ours.action_space
    assert env.observation_space == ours.observation_space
    check_env(env, skip_render_check=True)
    source: Any = ours.unwrapped
    assert isinstance(env, trundle.agent.Pushable)
    assert np.array_equal(env.ACTION_SCALE, source.ACTION_SCALE)


def test_a_stiff_bearing_acts_as_viscous_drag_at_a_point() -> None:
    env = example.RollerTable()
    env.reset(seed=SEEDS[0])
    drags = [env.drag if k == env.stuck else example.FREE for k in range(4)]
    wheels = [
        {"kind": "viscous_wheel", "x": x, "y": y, "angle": 0.0, "mu_x": drag, "mu_y": drag}
        for (x, y), drag in zip(example.FEET, drags, strict=True)
    ]
    body = {"footprint": example.FOOTPRINT, "mass": example.MASS}
    table = {"format": "trundle-model/1", "body": body, "effect": wheels}
    model = trundle.Model.from_toml(tomli_w.dumps(table))
    (pose, twist), wrench = env.motion(), np.array([30.0, 15.0, 5.0])
    for _ in range(20):
        env.step((wrench / env.ACTION_SCALE).astype(np.float32))
    t = np.linspace(0.0, 1.0, 1001)
    held = np.minimum(1.0, t / example.RISE)[:, None] * [30.0, 15.0, 5.0 - 0.6 * 15.0]
    predicted = model.rollout(pose, twist, t, held)[0][-1]
    moved = env.motion()[0] - pose
    # The inertia of the balls and their slip cause a few per cent.
    assert np.linalg.norm(predicted - env.motion()[0]) < 0.05 * np.linalg.norm(moved)
