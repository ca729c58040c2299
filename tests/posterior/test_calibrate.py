"""Calibrations continue after an interruption, and are not mixed."""

from pathlib import Path

import pytest

import trundle
from tests.command import trundle as command
from trundle.calibration import calibrate

CONFIG = """
format = "trundle-calibration/1"
name = "mass alone"
method = "laplace"
starts = 1
[model]
format = "trundle-model/1"
[model.body]
footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
[prior]
body.mass = { distribution = "log_normal", median = 22, sd = 0.3 }
[push]
episodes = 1
duration = 2.0
force = 12.0
grasp = [-0.6, 0.0]
scatter = 0.1
[noise]
position = 0.0005
angle = 0.00175
force = 0.4
torque = 0.05
tare_force = 0.04
tare_torque = 0.005
"""


@pytest.fixture
def config(tmp_path: Path) -> Path:
    path = tmp_path / "calibrate.toml"
    path.write_text(CONFIG, encoding="utf-8")
    return path


def test_an_interrupted_calibration_continues(config: Path, tmp_path: Path) -> None:
    out = tmp_path / "rounds.jsonl"
    calibrate(config, replicates=3, out=out)
    first = out.read_text(encoding="utf-8").splitlines()
    done: list[float] = []
    whole = calibrate(config, replicates=6, out=out, progress=lambda _, share: done.append(share))
    assert out.read_text(encoding="utf-8").splitlines()[:4] == first
    assert done == [1.0]
    assert whole.rounds == calibrate(config, replicates=6).rounds


def test_another_calibration_is_not_overwritten(config: Path, tmp_path: Path) -> None:
    out = tmp_path / "rounds.jsonl"
    calibrate(config, replicates=1, out=out)
    with pytest.raises(trundle.TrundleError, match="another calibration"):
        calibrate(config, replicates=1, seed=1, out=out)


def test_the_command_prints_a_table_and_draws_a_figure(config: Path, tmp_path: Path) -> None:
    line: list[str | Path] = ["calibrate", config, "--replicates", "5", "--figure", "ranks.png"]
    ran = command(tmp_path, *line)
    assert ran.returncode == 0, ran.stderr
    assert "mass alone, laplace, 5 rounds" in ran.stdout and "body.mass" in ran.stdout
    assert (tmp_path / "ranks.png").stat().st_size > 1000
