"""The log likelihood of a posterior, and leave-one-out cross-validation by ArviZ."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import trundle
from tests.command import trundle as command
from trundle.posterior import import_arviz

OBJECTS = Path(__file__).resolve().parents[2] / "configs/objects"
SCENARIO = f"""
format = "trundle-scenario/1"
name = "pushes"
object = "{OBJECTS.as_posix()}/office_table.toml"
held_out = 1

[[effect]]
kind = "viscous_wheel"
x = -0.5
y = 0.3
angle = 0.3
mu_x = 20.0
mu_y = 180.0

[sensor]
rate = 100.0
[tracker]
rate = 50.0
[random]
count = 4
duration = 2.0
speed = 0.3
spin = 0.5
"""
WHEEL = """
[[effect]]
kind = "viscous_wheel"
x = -0.5
y = 0.3
angle = 0.3
"""
DRAG = """
[[effect]]
kind = "support_drag"
"""
BODY = """
format = "trundle-model/1"
[body]
footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
mass = 22.0
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a recording of four pushes, one of them held out, and two models."""
    path = tmp_path_factory.mktemp("loo")
    (path / "scenario.toml").write_text(SCENARIO, encoding="utf-8")
    (path / "wheel.toml").write_text(BODY + WHEEL, encoding="utf-8")
    (path / "drag.toml").write_text(BODY + DRAG, encoding="utf-8")
    trundle.simulate(path / "scenario.toml", seed=1).write(path / "recording")
    return path


@pytest.fixture(scope="module")
def posterior(folder: Path) -> trundle.Posterior:
    """Return the posterior of the true model's friction coefficients."""
    return trundle.sample(folder / "recording", folder / "wheel.toml", draws=100, starts=2)


def test_points_are_the_training_episodes(posterior: trundle.Posterior) -> None:
    found = posterior.log_likelihood
    assert found.dims == ("chain", "draw", "episode") and found.shape == (4, 100, 3)
    assert list(found.episode.values) == ["episode_00", "episode_01", "episode_02"]
    assert np.isfinite(found).all()


def test_a_parameter_far_from_the_mode_is_less_likely(posterior: trundle.Posterior) -> None:
    """The density of Laplace's draws is that of the posterior: likelihood times prior."""
    total = posterior.log_likelihood.sum("episode").to_numpy().ravel()
    density = posterior.stats["lp"].ravel()
    assert np.corrcoef(total, density)[0, 1] > 0.95
    assert np.ptp(total) > 1.0


def test_arviz_compares_models_by_episodes(folder: Path, posterior: trundle.Posterior) -> None:
    az = import_arviz()
    right = az.loo(posterior.to_inference_data())
    assert right.n_data_points == 3
    other = trundle.sample(folder / "recording", folder / "drag.toml", draws=100, starts=2)
    assert az.loo(other.to_inference_data()).elpd_loo < right.elpd_loo - 100.0


def test_the_file_of_the_command_has_the_group(folder: Path) -> None:
    line = [
        "sample",
        "recording",
        "--model",
        "wheel.toml",
        "--draws",
        "20",
        "--starts",
        "1",
        "--out",
        "posterior.nc",
    ]
    ran = command(folder, *line)
    assert ran.returncode == 0, ran.stderr
    az = import_arviz()
    data = az.from_netcdf(folder / "posterior.nc")
    assert data.log_likelihood["episodes"].dims == ("chain", "draw", "episode")
    assert az.loo(data).n_data_points == 3
