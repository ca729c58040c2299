"""Draws of the posterior of a small recording, and their diagnostics."""

from pathlib import Path

import numpy as np
import pytest

import trundle
from tests.command import trundle as command
from trundle.cli.commands.sample import format_parameter as line_of
from trundle.posterior import add_diagnostics, import_arviz

SCENARIO = """
format = "trundle-scenario/1"
name = "short pushes"
object = "{objects}/office_table.toml"
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
count = 2
duration = 4.0
speed = 0.3
spin = 0.5
"""

SHORT = {"chains": 2, "draws": 60, "warmup": 60, "starts": 3}


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("posterior")
    objects = Path(__file__).resolve().parents[2] / "configs/objects"
    (folder / "scenario.toml").write_text(SCENARIO.format(objects=objects), encoding="utf-8")
    trundle.simulate(folder / "scenario.toml", seed=1).write(folder / "recording")
    return folder / "recording"


@pytest.fixture(scope="module")
def posterior(recording: Path) -> trundle.Posterior:
    return trundle.sample(recording, method="nuts", **SHORT)  # type: ignore[arg-type]


def test_draws_have_names_and_shapes(posterior: trundle.Posterior) -> None:
    assert set(posterior.draws) == {
        "body.mass",
        *(f"viscous_wheel.{n}" for n in ["x", "y", "angle", "mu_x", "mu_y"]),
    }
    assert all(values.shape == (2, 60) and np.isfinite(values).all() for values in posterior.draws.values())
    assert all(values.shape == (2, 60) for values in posterior.stats.values())


def test_a_short_run_has_not_converged(posterior: trundle.Posterior) -> None:
    assert not posterior.converged
    assert posterior.summary["verdict"].startswith("NOT CONVERGED: ")
    assert "effective draws" in posterior.summary["verdict"]


def test_disagreeing_chains_are_detected() -> None:
    rng = np.random.default_rng(0)
    summary = {
        "method": "nuts",
        "modes": [{}],
        "parameters": [{"name": "m", "unit": "kg", "identifiable": True}],
    }
    stats = {"diverging": np.zeros((4, 1000), dtype=bool)}
    agreeing = rng.normal(size=(4, 1000))
    assert add_diagnostics(summary, {"m": agreeing}, stats)["converged"]
    apart = add_diagnostics(summary, {"m": agreeing + np.array([[0], [0], [0], [0.5]])}, stats)
    assert not apart["converged"] and "R-hat" in apart["verdict"]
    left = {"diverging": stats["diverging"].copy()}
    left["diverging"][0, 3] = True
    assert "1 trajectories diverged" in add_diagnostics(summary, {"m": agreeing}, left)["verdict"]


def test_predictions_cover_the_episodes_by_name(posterior: trundle.Posterior) -> None:
    assert [poses.attrs["held_out"] for poses in posterior.predictive.values()] == [0, 1]
    for poses in posterior.predictive.values():
        assert poses.dims == ("chain", "draw", "time", "axis")
        assert poses.shape[:2] == (2, 50)
        assert np.isfinite(poses.values).all()


def test_inference_data_is_restored_from_disk(posterior: trundle.Posterior, tmp_path: Path) -> None:
    groups = {"posterior", "sample_stats", "posterior_predictive", "observed_data"}
    data = posterior.to_inference_data()
    assert groups <= {
        str(name).strip("/") for name in (data.groups() if callable(data.groups) else data.groups)
    }
    path = posterior.write(tmp_path / "posterior.nc")
    again = import_arviz().from_netcdf(path)
    assert np.array_equal(again.posterior["body.mass"].values, posterior.draws["body.mass"])
    assert [p.name for p in tmp_path.iterdir()] == ["posterior.nc"]


def test_unidentifiable_parameters_have_no_number(recording: Path) -> None:
    # The position of a wheel without friction is not identifiable.
    text = """
format = "trundle-model/1"
[body]
[[effect]]
kind = "viscous_wheel"
mu_x = 1e-3
mu_y = 1e-3
"""
    found = trundle.sample(recording, trundle.Model.from_toml(text), method="laplace", draws=100, starts=2)
    mass, *place = found.summary["parameters"]
    assert mass["identifiable"] and mass["sd"] > 0.0
    for parameter in place:
        assert not parameter["identifiable"] and "mean" not in parameter, parameter
        assert "not identifiable from these data" in line_of(parameter)


@pytest.mark.parametrize(
    ("change", "words"),
    [({"chains": 0}, "chains = 0"), ({"draws": -1}, "draws = -1"), ({"method": "gibbs"}, "gibbs")],
)
def test_invalid_settings_are_refused(recording: Path, change: dict[str, object], words: str) -> None:
    with pytest.raises(trundle.TrundleError, match=words):
        trundle.sample(recording, **change)  # type: ignore[arg-type]


def test_the_command_prints_the_verdict(recording: Path, tmp_path: Path) -> None:
    line: list[str | Path] = [
        "sample",
        recording,
        "--method",
        "laplace",
        "--draws",
        "40",
        "--starts",
        "2",
        "--out",
        "posterior.nc",
    ]
    ran = command(tmp_path, *line)
    assert ran.returncode == 0, ran.stderr
    assert "Laplace approximation" in ran.stdout and "viscous_wheel.mu_y" in ran.stdout
    assert (tmp_path / "posterior.nc").exists()
