"""Results outlive an interruption; trials of two settings never stand in one table."""

import json
from pathlib import Path
from typing import Any

import pytest

from trundle import TrundleError
from trundle.paper.experiment import Section, Show, carry_out
from trundle.paper.results import Results, Row

SETTINGS: dict[str, Any] = {"seeds": 4, "size": 1.5}


class Counting:
    """An experiment that is interrupted at its third trial, the first time."""

    FILE, TITLE = "counting", "Counting"

    def __init__(self) -> None:
        self.performed: list[int] = []
        self.interrupt = True

    def trials(self, settings: dict[str, Any]) -> list[Row]:
        return [{"seed": seed} for seed in range(settings["seeds"])]

    def perform(self, settings: dict[str, Any], trial: Row, show: Show) -> Row:
        if self.interrupt and trial["seed"] == 2:
            raise KeyboardInterrupt
        self.performed.append(trial["seed"])
        return {"value": trial["seed"] / 3, "none": float("inf")}

    def settings(self, options: object) -> dict[str, Any]:
        return SETTINGS

    def section(self, settings: dict[str, Any], rows: object) -> Section:
        return Section("", {})


def run(experiment: Counting, path: Path, settings: dict[str, Any] = SETTINGS) -> list[Row]:
    return carry_out(experiment, settings, Results(path, settings), lambda text: None)


def test_an_interrupted_experiment_goes_on_where_it_was(tmp_path: Path) -> None:
    path, experiment = tmp_path / "counting.jsonl", Counting()
    with pytest.raises(KeyboardInterrupt):
        run(experiment, path)
    kept = [json.loads(line) for line in path.read_text().splitlines()]
    assert [line["trial"]["seed"] for line in kept[1:]] == [0, 1]
    experiment.interrupt = False
    rows = run(experiment, path)
    assert experiment.performed == [0, 1, 2, 3]
    assert [(row["seed"], row["value"], row["none"]) for row in rows][1] == (1, 0.333333, None)
    assert list(tmp_path.iterdir()) == [path]


def test_results_of_other_settings_are_not_taken_over(tmp_path: Path) -> None:
    path, experiment = tmp_path / "counting.jsonl", Counting()
    experiment.interrupt = False
    run(experiment, path)
    run(experiment, path, {**SETTINGS, "seeds": 5})
    assert experiment.performed == [0, 1, 2, 3, 4]
    run(experiment, path, {"seeds": 5, "size": 2.0})
    assert experiment.performed == [0, 1, 2, 3, 4, 0, 1, 2, 3, 4]


def test_a_file_that_holds_no_results_is_named(tmp_path: Path) -> None:
    path = tmp_path / "counting.jsonl"
    path.write_text("[1, 2]\n")
    with pytest.raises(TrundleError, match=r"counting\.jsonl.*--fresh"):
        Results(path, SETTINGS)
