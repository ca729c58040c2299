"""Small versions of the experiments, with the results that the document states."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from trundle.experiments.paper import EXPERIMENTS
from trundle.experiments.paper.experiment import Settings, parse_settings, read
from trundle.experiments.results import Row, read_trials

CONFIGS = Path(__file__).resolve().parents[3] / "configs"


def performed(name: str, trial: Row, **changed: Any) -> tuple[Any, Row]:
    """Run one trial of an experiment with some settings changed."""
    experiment = EXPERIMENTS[name]
    file = experiment.__name__.rpartition(".")[2]
    settings: Settings = replace(read(experiment.Settings, file, CONFIGS), **changed)
    return settings, {**trial, **experiment.perform(settings, trial), "seconds": 1.0}


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_committed_results_are_readable(name: str) -> None:
    experiment = EXPERIMENTS[name]
    path = CONFIGS.parent / "docs" / "paper" / f"{experiment.__name__.rpartition('.')[2]}.jsonl"
    stored, rows = read_trials(path)
    settings = parse_settings(path, experiment.Settings, stored)
    assert set(settings.task_objects) == set(settings.objects)
    assert settings == parse_settings(path, experiment.Settings, settings.plain())
    for trial, row in zip(experiment.trials(settings), rows, strict=True):
        assert trial.items() <= row.items()


@pytest.mark.parametrize(("name", "linear"), [("shopping_cart", False), ("chair:free", True)])
def test_fig6_regressions_suffice_for_linear_objects_only(name: str, linear: bool) -> None:
    trial = {"reading": "cm_deg", "object": name, "seed": 3}
    settings, row = performed("fig6", trial, counts=[8, 50], learners=["pbr", "lr", "lwr"])
    assert row["r2"]["pbr"][0] >= settings.threshold
    assert row["r2"]["lr"][0] < settings.threshold
    assert (row["r2"]["lr"][1] >= settings.threshold) == linear
    assert row["coasting"] < 0.5


def test_fig6_the_same_seed_gives_the_same_scores() -> None:
    trial = {"reading": "of_motion", "object": "bed:steering castor", "seed": 1}
    once, again = (performed("fig6", trial, counts=[10])[1]["r2"] for _ in range(2))
    assert once == again


def test_fig6_more_starts_do_not_improve_the_fit() -> None:
    trial = {"reading": "of_motion", "object": "shopping_cart", "seed": 1}
    few, many = (
        performed("fig6", trial, counts=[10, 50], learners=["pbr"], starts=n)[1]["r2"]["pbr"] for n in (8, 64)
    )
    assert few == pytest.approx(many, abs=1e-3)
    assert few[1] < 0.995


def test_fig8_noise_affects_physics_less() -> None:
    found = {sigma: performed("fig8", {"sigma": sigma, "seed": 0})[1]["missing"] for sigma in (0.0, 0.5)}
    assert found[0.0]["pbr"] < 1e-6
    assert found[0.5]["pbr"] < 0.05 < min(found[0.5][name] for name in ("lr", "lwr"))


def test_open_loop_only_the_right_model_reaches_the_goal() -> None:
    trial = {"hold": 0.5, "axes": "object", "object": "office_table:locked", "seed": 0}
    settings, row = performed("open-loop", trial, sizes=[0.0, 0.3], counts=[])
    radius = settings.task_objects[trial["object"]].radius
    right, wrong = row["runs"]
    assert right["r2"] == 1.0
    assert right["error"] < 0.05 * radius
    assert not right["touched"]
    assert right["poses"][-1][:2] == pytest.approx([settings.length, 0.0], abs=0.05 * radius)
    assert max(abs(pose[1]) for pose in right["poses"]) > settings.obstacle  # around the obstacle
    assert wrong["r2"] < settings.threshold
    assert wrong["error"] > radius
    assert wrong["planned"] < 0.05 * radius  # the model is wrong, not the plan


@pytest.mark.slow
def test_the_wheel_is_located_if_the_model_has_dry_friction() -> None:
    trial = {"friction": "support_friction", "seed": 0}
    settings, row = performed("wheel", trial, episodes=3)
    assert row["fits"]["support_friction"]["error"] < settings.limit < row["fits"]["wheel"]["error"]
    assert row["fits"]["support_friction"]["evidence"] > row["fits"]["coulomb_friction"]["evidence"]


def test_fig5_only_the_learnt_model_predicts_the_push() -> None:
    _, row = performed("fig5", {"pushes": 1, "case": "office_table:locked", "seed": 0})
    last = {way: row[way]["errors"]["episode_00"][0] for way in ("before", "steps", "final")}
    assert last["final"] < 0.03 < last["before"]
    assert row["steps"]["errors"]["episode_00"][0] > last["final"]
