"""PPO in the arena."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("gym_pusht", reason="the arena needs gym-pusht: pip install trundle[arena]")

from trundle.experiments.arena import training
from trundle.experiments.arena.planner import costs
from trundle.experiments.arena.training import SHAPING_PX, Shaped, load, scaled, to_table, train
from trundle.experiments.arena.world import make

OPTIONS = {"reset_to_state": [180.0, 240.0, 256.0, 256.0, 0.3]}


def test_the_shaping_adds_the_decrease_of_the_cost_and_nothing_else() -> None:
    shaped, plain = Shaped(make()), make()
    shaped.reset(seed=1, options=OPTIONS)
    first = last = plain.reset(seed=1, options=OPTIONS)[0]
    extra = 0.0
    for _ in range(8):
        seen, earned, *_ = shaped.step(np.array([0.0, 0.1]))
        last, reward, *_ = plain.step(np.array([256.0, 281.6]))
        np.testing.assert_allclose(seen, scaled(last), atol=1e-6)
        extra += earned - float(reward)
    decrease = costs(first[None, None])[0] - costs(last[None, None])[0]
    assert abs(decrease) > 5.0
    assert extra == pytest.approx(decrease / SHAPING_PX, abs=1e-6)


def test_positions_keep_their_place_in_the_network() -> None:
    np.testing.assert_allclose(to_table(np.array([-1.0, 1.0])), [0.0, 512.0])
    np.testing.assert_allclose(to_table(np.array([0.0, 9.0])), [256.0, 512.0])
    np.testing.assert_allclose(
        scaled(np.array([0, 512, 256, 128, np.pi / 2])), [-1, 1, 0, -0.5, 0, 1], atol=1e-6
    )


def test_a_trained_policy_is_stored_and_commands_positions(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip(
        "stable_baselines3", reason="policies need stable-baselines3: pip install trundle[rl]"
    )
    monkeypatch.setattr(training, "ENVIRONMENTS", 1)
    train("sliding", 64, 0, tmp_path / "new" / "policy.zip")
    agent = load(tmp_path / "new" / "policy.zip")
    observation = make("sliding").reset(seed=0)[0]
    action = agent.act(observation)
    assert action.shape == (2,) and np.all((action >= 0) & (action <= 512))
    np.testing.assert_array_equal(action, agent.act(observation))
