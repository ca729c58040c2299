"""Comparison of agents in the arena, its table, and the committed results."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest
from gymnasium.wrappers import TimeLimit

from trundle.experiments.arena import planner, run
from trundle.experiments.arena.world import PHYSICS, PushTHidden, make_bare
from trundle.experiments.backends import Local
from trundle.experiments.results import Row, read_lines

DOCS = Path(__file__).resolve().parents[3] / "docs"


def short_episodes(physics: str) -> PushTHidden:
    return PushTHidden(TimeLimit(make_bare(physics), 30), physics)


def rows(agent: str, coverage: list[float]) -> list[Row]:
    return [
        {
            "agent": agent,
            "seed": seed,
            "coverage": one,
            "early": one / 2,
            "success": one > 0.95,
            "actions": 10,
        }
        for seed, one in enumerate(coverage)
    ]


def test_differences_are_paired_by_world() -> None:
    oracle, nominal = rows("oracle", [1.0, 0.2, 0.6]), rows("nominal", [0.9, 0.1, 0.5])
    for order in (nominal, nominal[::-1]):
        lines = run.summary([*oracle, *order]).splitlines()
        cells = [cell.strip() for cell in lines[-1].strip("|").split("|")]
        assert len(lines) == 4 and cells[0] == "nominal"
        # A constant difference in every world has an interval of no width.
        assert cells[2:4] == ["0.500", "-0.100 [-0.100, -0.100]"]
        assert cells[5] == "-0.050 [-0.050, -0.050]"
        assert cells[1].endswith("0 of 3")
    assert "1 of 3" in lines[2]


@pytest.mark.parametrize("physics", PHYSICS)
def test_the_page_shows_the_committed_results(physics: str) -> None:
    found = read_lines(DOCS / "arena" / f"{physics}.jsonl")
    assert run.summary(found) in (DOCS / "arena.md").read_text(encoding="utf-8")
    played = {
        agent: {row["seed"] for row in found if row["agent"] == agent} for agent in ("oracle", "nominal")
    }
    assert played["oracle"] == played["nominal"]


@pytest.mark.skipif(
    importlib.util.find_spec("gym_pusht") is None,
    reason="the arena needs gym-pusht: pip install trundle[arena]",
)
def test_a_tournament_is_played_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(planner, "SAMPLES", 2)
    monkeypatch.setattr(planner, "ELITES", 1)
    monkeypatch.setattr(planner, "ITERATIONS", 1)
    monkeypatch.setattr(run, "make", short_episodes)
    arguments = ("sliding", ("oracle", "nominal"), [3], tmp_path, Local(1))
    first = run.tournament(*arguments)
    assert [row["agent"] for row in first] == ["oracle", "nominal"]
    assert first[0]["hidden"] == first[1]["hidden"]
    for row in first:
        assert 0.0 <= row["early"] <= row["coverage"] <= 1.0
        assert row["success"] == (row["coverage"] > 0.95) and 0 < row["actions"] <= 30
    monkeypatch.setattr(run, "make", None)
    assert run.tournament(*arguments) == first
