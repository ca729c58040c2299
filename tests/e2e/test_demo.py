"""The demo: a table with hidden dry friction is pushed, recorded and diagnosed, and the answer is used."""

import json
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

import trundle as package
from tests.command import trundle
from tests.e2e.conftest import Demo

FILES = ["diagnosis.json", "model.toml", "predictions.parquet", "report.html"]


@pytest.fixture(scope="session")
def answer(demo: Demo) -> dict[str, Any]:
    loaded: dict[str, Any] = json.loads((demo.diagnosis / "diagnosis.json").read_text())
    return loaded


def test_the_hidden_friction_is_named_and_located(answer: dict[str, Any]) -> None:
    assert answer["verdict"] == "explained"
    (found,) = answer["missing"]
    assert found["effect"] == "coulomb_friction"
    force, point = found["parameters"]["force"], found["where"]["body_point"]
    assert abs(force["mean"] - 14.0) < max(5 * force["sd"], 0.3)
    np.testing.assert_allclose(point["mean"], [0.5, -0.3], atol=0.02)


def test_the_recording_does_not_name_the_hidden_effect(demo: Demo) -> None:
    text = (demo.recording / "recording.toml").read_text()
    assert not any(word in text for word in ("coulomb", "friction", "wheel", "mu_x"))


def test_exactly_the_documented_files_are_written(demo: Demo) -> None:
    assert sorted(path.name for path in demo.diagnosis.iterdir()) == FILES
    assert sorted(path.name for path in demo.folder.iterdir()) == ["diagnosis", "recording"]


def test_the_metrics_follow_from_the_predictions(demo: Demo, answer: dict[str, Any]) -> None:
    table = pd.read_parquet(demo.diagnosis / "predictions.parquet")
    assert sorted(table["episode"].unique()) == ["episode_06", "episode_07"]
    for which in ("before", "after"):
        given = answer["fit"]["held_out"][which]
        for key, value in recomputed(table, which).items():
            assert given[key] == pytest.approx(value, rel=1e-9), (which, key)


def recomputed(table: pd.DataFrame, which: str) -> dict[str, float]:
    """Return the open-loop metrics by their definitions, from observed and simulated poses."""
    gap = np.stack([table[f"{which}_{axis}"] - table[f"observed_{axis}"] for axis in "xy"], axis=1)
    turn = wrapped(np.asarray(table[f"{which}_theta"] - table["observed_theta"]))
    last = np.asarray(table.groupby("episode")["t"].idxmax())
    return {
        "position_rmse": float(np.sqrt(np.mean(np.sum(gap**2, axis=1)))),
        "heading_rmse": float(np.sqrt(np.mean(turn**2))),
        "final_position_error": float(np.mean(np.linalg.norm(gap[last], axis=1))),
        "final_heading_error": float(np.mean(np.abs(turn[last]))),
    }


def wrapped(angle: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray((angle + np.pi) % (2 * np.pi) - np.pi)


def test_the_held_out_fit_is_ten_times_better(answer: dict[str, Any]) -> None:
    before, after = (answer["fit"]["held_out"][which] for which in ("before", "after"))
    assert after["position_rmse"] < 0.1 * before["position_rmse"]
    assert after["log_predictive_density"] > before["log_predictive_density"]


def test_the_same_seed_gives_the_same_bytes(demo: Demo, tmp_path: Path) -> None:
    ran = trundle(demo.folder, "diagnose", "recording", "--out", tmp_path / "again")
    assert ran.returncode == 0, ran.stderr
    for name in FILES:
        assert (tmp_path / "again" / name).read_bytes() == (demo.diagnosis / name).read_bytes(), name


def test_the_extended_model_reproduces_the_predictions(demo: Demo, tmp_path: Path) -> None:
    out = tmp_path / "predictions.parquet"
    ran = trundle(demo.folder, "predict", "recording", "--model", "diagnosis/model.toml", "--out", out)
    assert ran.returncode == 0, ran.stderr
    ours, theirs = pd.read_parquet(out), pd.read_parquet(demo.diagnosis / "predictions.parquet")
    both = ours[["episode", "t", "predicted_x"]].merge(theirs, on=["episode", "t"])
    assert len(both) == len(theirs)
    np.testing.assert_allclose(both["predicted_x"], both["after_x"], atol=1e-6)


def test_the_extended_model_loads_in_python(demo: Demo) -> None:
    model = package.Model.read(demo.diagnosis / "model.toml")
    assert "coulomb_friction" in str(model.to_toml())


@pytest.mark.parametrize("verb", ["check", "info"])
def test_the_recording_is_sound(demo: Demo, verb: str) -> None:
    ran = trundle(demo.folder, verb, "recording", "--json")
    assert ran.returncode == 0, ran.stderr
    found = json.loads(ran.stdout)
    if verb == "check":
        assert [finding for finding in found if finding["severity"] == "error"] == []
    else:
        assert len(found["episodes"]) == 8


@pytest.mark.slow
def test_progress_never_decreases(demo: Demo) -> None:
    reports: list[tuple[str, float]] = []
    package.diagnose(demo.recording, progress=lambda stage, share: reports.append((stage, share)))
    stages, shares = [stage for stage, _ in reports], [share for _, share in reports]
    assert len(reports) > 20
    assert shares[0] == 0.0
    assert shares == sorted(shares)
    assert 0.9 < shares[-1] <= 1.0
    began = [stages.index(stage) for stage in dict.fromkeys(stages)]
    assert len(began) >= 4
    assert [stage for stage, _ in groupby(stages)] == [stages[k] for k in began], "a stage came back"


@pytest.mark.slow
def test_two_processes_give_the_same_diagnoses_and_errors(demo: Demo, tmp_path: Path) -> None:
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "recording.toml").write_text('format = "trundle-recording/9"\n')
    ran = trundle(tmp_path, "diagnose", demo.recording, "broken", "--out", "both", "--jobs", "2")
    assert ran.returncode == 2
    assert ran.stderr.startswith("trundle: broken")
    assert ran.stdout.startswith("office table: explained\n")
    both = [folder / "diagnosis.json" for folder in (demo.diagnosis, tmp_path / "both/recording")]
    assert both[0].read_bytes() == both[1].read_bytes()
