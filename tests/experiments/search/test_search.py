"""`trundle train --search` for the adaptive agent, and its ranges; `tests/rl` tests it for trainings."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from trundle import TrundleError
from trundle.cli import main
from trundle.experiments.comparison import episode
from trundle.experiments.execution import Execution
from trundle.experiments.search import config
from trundle.experiments.search.ranges import Range, Search, assigned
from trundle.experiments.search.run import search
from trundle.settings import SettingsError

ROOT = Path(__file__).resolve().parents[3]
TINY = """
format = "trundle-train/1"
algorithm = "Adaptive"
env = "trundle/PushPoseHard-v1"
env_kwargs = { horizon = 6 }

[agent]
starts = 1
planner = { samples = 8, cost = { effort = 0.004 } }

[search]
trials = 3
first = 700_100
episodes = 2

[search.ranges]
"planner.temperature" = { low = 0.005, high = 0.1, log = true }
"planner.cost.margin" = { low = 0.03, high = 0.12 }
"planner.horizon" = { low = 5, high = 9, integer = true }
push = { choices = [0.5, 1.0] }
"""


def written(folder: Path, text: str = TINY) -> Path:
    path = folder / "tiny.toml"
    path.write_text(text)
    return path


def execution(out: Path) -> Execution:
    return Execution(out / "work", out, quiet=True)


def draws(one: Range, count: int = 400) -> Any:
    random = np.random.default_rng(0)
    return [one.draw(random) for _ in range(count)]


def test_draws_have_the_distribution_of_their_range() -> None:
    uniform = np.array(draws(Range(low=-1.0, high=3.0)))
    assert (uniform >= -1.0).all()
    assert (uniform <= 3.0).all()
    assert uniform.mean() == pytest.approx(1.0, abs=0.15)
    logs = np.log10(draws(Range(low=1e-4, high=1e-2, log=True)))
    assert logs.mean() == pytest.approx(-3.0, abs=0.1)
    assert np.mean(logs < -3.0) == pytest.approx(0.5, abs=0.1)
    assert set(draws(Range(low=1, high=3, integer=True))) == {1, 2, 3}
    assert set(map(str, draws(Range(choices=[[64, 64], "a"])))) == {
        "[64, 64]",
        "a",
    }
    scheduled = draws(Range(low=1e-5, high=1e-2, log=True, schedule=True), 20)
    assert all(one.startswith("lin_") and float(one[4:]) > 0.0 for one in scheduled)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({}, "give low < high, or choices"),
        ({"low": 2.0, "high": 1.0}, "low < high"),
        ({"low": 0.0, "high": 1.0, "log": True}, "low must be positive"),
        ({"choices": []}, "at least one"),
        ({"choices": [1], "low": 0.0}, "no other key"),
    ],
)
def test_invalid_ranges_are_refused(values: dict[str, Any], message: str) -> None:
    with pytest.raises(SettingsError, match=message):
        Range(**values)


def test_trials_depend_on_the_seed_and_their_number_only() -> None:
    ranges = {"a": Range(low=0.0, high=1.0), "b": Range(low=1.0, high=9.0, log=True)}
    one, more, other = Search(ranges), Search(ranges, trials=50), Search(ranges, seed=1)
    assert one.values(0) == {}
    assert [one.values(k) for k in range(1, 11)] == [more.values(k) for k in range(1, 11)]
    assert one.values(1) != one.values(2)
    assert one.values(1) != other.values(1)


def test_values_are_assigned_to_inner_tables() -> None:
    table = {"planner": {"samples": 8, "cost": {"effort": 0.1}}}
    found = assigned(table, {"planner.cost.margin": 0.2, "push": 1.0, "new.key": 3})
    assert found == {
        "planner": {"samples": 8, "cost": {"effort": 0.1, "margin": 0.2}},
        "push": 1.0,
        "new": {"key": 3},
    }
    assert table == {"planner": {"samples": 8, "cost": {"effort": 0.1}}}


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[search]", "[search]\nshares = 0.1", "unknown key `search.shares`"),
        ("log = true", "logarithmic = true", "unknown key `search.ranges.planner.temperature.logarithmic`"),
        ("low = 0.03, high = 0.12", "low = 0.12, high = 0.03", r"\[search.ranges.planner.cost.margin\].*low"),
        ("planner.cost.margin", "planner.cost.margins", "trial 1: planner: unknown field `margins`"),
        ('"planner.horizon"', '"planer.horizon"', "unknown key `agent.planer`"),
        ("push =", "pull =", "unknown key `agent.pull`"),
        ("first = 700_100", "first = 110_000", "tuning worlds have seeds from 500000"),
        ("horizon = 6", 'horizon = 6, split = "test"', 'split = "test": a search uses training objects'),
    ],
)
def test_invalid_settings_are_refused(old: str, new: str, message: str, tmp_path: Path) -> None:
    assert TINY.count(old) == 1
    with pytest.raises(TrundleError, match=message):
        config.read(written(tmp_path, TINY.replace(old, new)))


def results(folder: Path) -> dict[str, bytes]:
    return {name: (folder / "search" / name).read_bytes() for name in ("tiny.jsonl", "tiny.md")}


def test_a_search_compares_all_trials_in_the_same_worlds(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = written(tmp_path), tmp_path / "out"
    assert main(["train", str(path), "--search", "--out", str(out), "--quiet"]) == 0
    printed = capsys.readouterr().out
    assert printed == (out / "search/tiny.md").read_text() + "\n"
    rows = [json.loads(line) for line in (out / "search/tiny.jsonl").read_text().splitlines()]
    assert [row["trial"] for row in rows] == [0, 1, 2, 3]
    assert rows[0]["values"] == {}
    assert rows[0]["gain"] == 0.0
    _, given, _ = config.read(path)
    for row in rows[1:]:
        assert row["values"] == given.values(row["trial"])
        assert row["gain"] == pytest.approx(row["return"] - rows[0]["return"], abs=1e-4)
        assert row["gain"] != 0.0
    best = max(rows, key=lambda row: float(row["return"]))["trial"]
    assert f"## Settings of trial {best}" in printed
    order = [line.split(" | ")[0] for line in printed.splitlines() if line.startswith("| ")][2:]
    assert order[0] == f"| {best}"


def test_an_interrupted_search_continues(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = written(tmp_path)
    search(path, execution(tmp_path / "whole"))
    played = []
    play = episode.play

    def count(*arguments: Any) -> Any:
        played.append(arguments)
        if len(played) == 4:
            raise KeyboardInterrupt
        return play(*arguments)

    monkeypatch.setattr(episode, "play", count)
    with pytest.raises(KeyboardInterrupt):
        search(path, execution(tmp_path / "parts"))
    search(path, execution(tmp_path / "parts"))
    assert len(played) == 4 * 2 + 1
    assert results(tmp_path / "whole") == results(tmp_path / "parts")


def test_the_settings_of_the_agent_have_no_training(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    line = ["train", str(written(tmp_path)), "--out", str(tmp_path / "out")]
    assert main(line) == 2
    assert "has no training: give --search" in capsys.readouterr().err
    assert main([*line, "--search", "--seed", "1"]) == 2
    assert "--seed: not allowed with --search" in capsys.readouterr().err


@pytest.mark.parametrize(
    "path", sorted((ROOT / "configs/rl").glob("hard_*.toml")), ids=lambda path: path.stem
)
def test_the_ranges_of_the_configurations_are_valid(path: Path) -> None:
    settings, given, table = config.read(path)
    assert given.trials == 10
    assert settings.env_kwargs["split"] == "train"
    if not isinstance(settings, config.AgentTuning):
        short = config.training_table(table, settings, given, 1)
        assert short["n_timesteps"] == round(given.share * settings.n_timesteps)
        assert short["evaluation"]["first"] == given.first
