"""Tables of rows whose statistics are computed by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from trundle.experiments.comparison import tables
from trundle.experiments.comparison.config import Agent, Settings, Target, Worlds
from trundle.experiments.comparison.document import headlines
from trundle.experiments.comparison.scores import quick_success, regret, regret_iqm, success, time_to_success


def row(seed: int, reward: float, **more: Any) -> dict[str, Any]:
    usual = {"run": 0, "success": True, "lost": False, "touches": 0, "seconds": 4.0, "limit": 15.0, "fits": 1}
    usual |= {"learning": 0.5}
    ends = {"distance": 0.03, "heading": 0.05, "radius": 0.6, "regrasps": 0, "named": []}
    return {"seed": seed, "return": reward, **usual, **ends, **more}


ORACLE = [row(0, -1.0), row(1, -2.0), row(2, -1.0)]
MINE = [
    row(0, -1.1),
    row(1, -2.2, fits=5, learning=2.5),
    row(2, -4.0, success=False, seconds=3.0, lost=True, named=["tether"]),
]
SETTINGS = Settings(
    name="n",
    title="T",
    worlds={"w": Worlds("Worlds", "e", 0, 3, ["oracle", "mine"], {"hidden": "locked"}, [{"kind": "tether"}])},
    agents={"oracle": Agent("Oracle", "oracle"), "mine": Agent("Mine", "adaptive", {"diagnose": True})},
    main="mine",
    pairs=[("mine", "oracle")],
    targets=[
        Target("w", "mine", "success", least=0.6),
        Target("w", "mine", "quick success", least=0.6),
        Target("w", "mine", "regret", most=5.0),
    ],
)
RESULTS = {"w": {"oracle": ORACLE, "mine": MINE}}


def test_regret_of_sums_and_of_worlds() -> None:
    assert regret(MINE, ORACLE).value == pytest.approx((1.1 + 2.2 + 4.0) / 4.0 - 1)
    assert regret(MINE, ORACLE, time_to_success).value == pytest.approx((4.0 + 4.0 + 15.0) / 12.0 - 1)
    worlds = [row(k, -2.0) for k in range(8)]
    six_alike = [row(k, -2.2) for k in range(6)] + [row(6, -100.0), row(7, -2.0)]
    assert regret_iqm(six_alike, worlds).value == pytest.approx(0.1)


def test_rates() -> None:
    assert success(MINE).value == pytest.approx(2 / 3)
    assert quick_success(MINE, 0.5).value == pytest.approx(1 / 3)


def test_targets_use_intervals() -> None:
    lines = tables.targets(SETTINGS, RESULTS).splitlines()[2:]
    assert [line.split(" | ")[-1] for line in lines] == [
        "met, interval reaches beyond |",
        "**not met** |",
        "met |",
    ]


def test_named_effects_are_compared_with_hidden_ones() -> None:
    line = tables.diagnoses(SETTINGS, RESULTS).splitlines()[2]
    assert line.startswith("| `w` | Mine | 33.3 %")
    assert line.split(" | ")[3].startswith("0.0 %")


def test_hidden_effects_have_diagnosis_names() -> None:
    def hidden(options: dict[str, Any], *kinds: str) -> set[str] | None:
        worlds = Worlds("", "e", 0, 3, [], options, [{"kind": kind} for kind in kinds])
        return tables.hidden_effects(worlds)

    assert hidden({"hidden": "none"}, "viscous_wheel", "support_friction", "spin_drag") == {
        "coulomb_friction",
        "second_wheel",
    }
    assert hidden({"hidden": "locked", "effects": [{"kind": "tether"}]}) == {"tether"}
    assert hidden({}, "tether") is None
    assert hidden({"hidden": "locked"}, "viscous_wheel") == {"second_wheel"}
    paper = Worlds("", "trundle/LockedWheel-v0", 0, 3, [], {}, [{"kind": "tether"}])
    assert tables.hidden_effects(paper) == {"tether"}
    assert tables.naming_cells(MINE, None) == ["–", "–"]


def test_the_first_sentence_states_success_and_regret() -> None:
    assert headlines(SETTINGS, RESULTS).startswith(
        "- **Worlds** (`w`, 3 worlds): Mine succeeds without touching in 66.7 % ["
    )
    assert "loses 83 % [" in headlines(SETTINGS, RESULTS)
    assert headlines(SETTINGS, RESULTS).endswith("; Oracle 100.0 %.")


def test_the_first_line_names_the_policies_that_are_ahead() -> None:
    agents = {**SETTINGS.agents, "policy": Agent("PPO", "policy", files=["a.npz"])}
    settings = replace(SETTINGS, agents=agents)
    assert "ahead" not in headlines(settings, RESULTS)
    behind = {"w": {**RESULTS["w"], "policy": [row(k, -9.0) for k in range(3)]}}
    first = headlines(settings, behind).splitlines()[0]
    assert first == "- **Trained policies that are ahead of Mine**: none in any group."
    cheaper = {"w": {**RESULTS["w"], "policy": [row(k, -0.1) for k in range(3)]}}
    first = headlines(settings, cheaper).splitlines()[0]
    assert first.startswith("- **Trained policies that are ahead of Mine**: PPO in `w` (success +33.3 [")


def test_a_fixed_agent_has_no_success_by_number_of_fits() -> None:
    fixed = [{**one, "fits": 0, "learning": 0.0} for one in MINE]
    settings = {"oracle": SETTINGS.agents["oracle"], "mine": Agent("Fixed", "adaptive", {"adapt": False})}
    table = tables.outcomes(Settings("n", "T", SETTINGS.worlds, settings, "mine"), {"mine": fixed})
    assert table.splitlines()[2].split(" | ")[3] == "–"
