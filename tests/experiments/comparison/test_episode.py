"""Records of an episode."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import gymnasium
import numpy as np
import pytest

import trundle
from trundle.experiments.comparison.config import Agent, Worlds
from trundle.experiments.comparison.episode import begin, learning_summary, play, time_limit
from trundle.experiments.runs.episode import count_onsets
from trundle.experiments.training.network import Network
from trundle.experiments.training.policy import About, Policy


@pytest.mark.parametrize(
    ("touched", "count"), [([], 0), ([True], 1), ([False, True, True, False, True], 2), ([True, True], 1)]
)
def test_a_continuous_contact_counts_once(touched: list[bool], count: int) -> None:
    assert count_onsets(touched) == count


def test_learnt_effects_are_listed_once_in_order() -> None:
    named = [("tether",), (), ("com_offset", "tether")]
    updates = [
        SimpleNamespace(time=0.5 + k, named=names, regrasp=(0.1, 0.2) if names else None)
        for k, names in enumerate(named)
    ]
    agent = SimpleNamespace(beliefs=(SimpleNamespace(updates=updates, fits=3),))
    assert learning_summary(agent) == {
        "fits": 3,
        "learning": 2.5,
        "regrasps": 2,
        "named": ["tether", "com_offset"],
    }
    assert learning_summary(SimpleNamespace()) == {"fits": 0, "learning": 0.0, "regrasps": 0, "named": []}


def test_a_privileged_policy_sees_hidden_parameters_and_episodes_of_version_1_end(tmp_path: Path) -> None:
    env: Any = trundle.envs.Oracle(gymnasium.make("trundle/PushPose-v1"))
    entries = env.observation_space.shape[0]
    weight = np.zeros((3, entries), dtype=np.float32)
    weight[2, entries - len(trundle.envs.Oracle.NAMES)] = 1e-3  # the mass
    described: dict[str, Any] = {
        **{"config": "c", "digest": "0", "algorithm": "PPO", "seed": 1, "steps": 0, "entries": entries},
        **{"env": "trundle/PushPose-v1", "env_kwargs": {}, "frame": "world", "frame_stack": 1},
        **{"activation": "tanh", "squashed": False, "clip_obs": 1e6, "hidden": 10},
    }
    network = Network([(weight, np.zeros(3, dtype=np.float32))], "tanh")
    Policy(About(**described), np.zeros(entries), np.ones(entries), network).save(tmp_path / "one.npz")
    worlds = Worlds("W", "trundle/PushPose-v1", 0, 1, [])
    agent = Agent("Knows", "policy", files=[str(tmp_path / "one.npz")])
    env, observation, player = begin(worlds, agent, 0, 3)
    mass = env.unwrapped.hidden_values()[0]
    assert player.predict(observation)[0] == pytest.approx([0.0, 0.0, 1e-3 * mass], rel=1e-5)
    row, _ = play(worlds, agent, 0, 3)
    assert row["limit"] == pytest.approx(15.0)
    assert row["contact"] == 0.0 and row["touches"] == 0


def test_the_shorter_time_limit_applies() -> None:
    assert time_limit(gymnasium.make("trundle/PushPose-v1")) == 300
    assert time_limit(gymnasium.make("trundle/PushPose-v1", horizon=12)) == 12
    assert time_limit(gymnasium.make("trundle/PushPose-v1", horizon=900)) == 300
    assert time_limit(gymnasium.make("trundle/PushPose-v0", horizon=12)) == 12


def test_only_the_oracle_knows_the_hidden_model() -> None:
    # A wheel with so much drag that a model with a free wheel cannot turn the table about it.
    wheel = {"kind": "viscous_wheel", "x": -0.5, "y": 0.3, "angle": 0.0, "mu_x": 800.0, "mu_y": 800.0}
    worlds = Worlds("W", "trundle/PushPose-v0", 0, 1, [], {"hidden": "none"}, [wheel])
    ends = {}
    agents = [Agent("Knows", "oracle"), Agent("Keeps to its belief", "adaptive", {"adapt": False})]
    for agent in agents:
        row, timing = play(worlds, agent, 0, 3)
        assert timing["decisions"] == round(row["seconds"] / 0.05)
        assert 0 < timing["longest"] <= timing["total"]
        ends[agent.kind] = row
    assert ends["oracle"]["success"]
    assert ends["oracle"]["return"] > 0.6 * ends["adaptive"]["return"]
