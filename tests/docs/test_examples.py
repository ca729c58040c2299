"""The examples that start from logs or arrays."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import trundle
from tests.command import trundle as command

ROOT = Path(__file__).resolve().parents[2]


def load_example(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, ROOT / "examples" / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_a_model_fitted_to_logs_predicts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fit = load_example("fit_your_recording").main(tmp_path)
    found = {p["name"]: p["mean"] for p in fit.summary["parameters"]}
    # The environment of seed 3 hides 22 kg and a wheel at (0.5, -0.3) m.
    assert found["body.mass"] == pytest.approx(22.0, abs=0.3)
    assert found["viscous_wheel.x"] == pytest.approx(0.5, abs=0.01)
    assert found["viscous_wheel.y"] == pytest.approx(-0.3, abs=0.01)
    assert trundle.Model.read(tmp_path / "model.toml").parameters == fit.model.parameters
    printed = capsys.readouterr().out
    moved, off = (
        float(re.findall(f"{words} (\\S+) m", printed)[0]) for words in ("moved", "error at the end")
    )
    assert moved > 0.5
    assert off < 0.15 * moved
    assert fit.summary["held_out"]["window_position_rmse"] < 0.03


def test_the_command_imports_the_same_recording(tmp_path: Path) -> None:
    load_example("fit_your_recording").main(tmp_path)
    line = ["import", "logs", "--from", "csv", "--map", "map.toml", "--out", "repeated"]
    ran = command(tmp_path, *line)
    assert ran.returncode == 0, ran.stderr
    first, second = (trundle.read(tmp_path / name) for name in ("recording", "repeated"))
    assert first.metadata == second.metadata
    assert list(first.episodes) == list(second.episodes)
    for name, table in first.episodes.items():
        for key, column in table.items():
            np.testing.assert_array_equal(column, second.episodes[name][key])


def test_arrays_are_diagnosed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = load_example("diagnose_your_recording").main(tmp_path / "found")
    # configs/experiments/demo.toml: dry friction of 14 N at (0.5, -0.3) m.
    assert (found.verdict, found.missing) == ("explained", ["coulomb_friction"])
    effect = found.answer["missing"][0]
    assert effect["parameters"]["force"]["mean"] == pytest.approx(14.0, rel=0.03)
    assert effect["where"]["body_point"]["mean"] == pytest.approx([0.5, -0.3], abs=0.02)
    held_out = found.answer["fit"]["held_out"]
    assert held_out["after"]["position_rmse"] < 0.1 * held_out["before"]["position_rmse"]
    names = {"diagnosis.json", "model.toml", "predictions.parquet", "report.html"}
    assert {path.name for path in (tmp_path / "found").iterdir()} == names
    assert "diagnosed: explained" in capsys.readouterr().out


def test_regressors_find_what_a_robot_has_in_addition(capsys: pytest.CaptureFixture[str]) -> None:
    changes = load_example("mechanism_regressors").main()
    assert changes["mass:lower"] == pytest.approx(0.2 * 0.7, abs=0.01)
    assert changes["mass:upper"] == pytest.approx(0.0, abs=0.02)
    assert changes["dry friction:elbow"] == pytest.approx(0.5, abs=0.01)
    assert changes["dry friction:shoulder"] == pytest.approx(0.0, abs=0.01)
    assert "moving bodies: upper 1.5 kg, lower 0.7 kg" in capsys.readouterr().out
