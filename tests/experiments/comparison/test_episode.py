"""Records of an episode."""

from types import SimpleNamespace

import pytest

from trundle.experiments.comparison.config import Agent, Worlds
from trundle.experiments.comparison.episode import learning_summary, play
from trundle.experiments.runs.episode import count_onsets


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
