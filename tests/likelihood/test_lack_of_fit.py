"""The lack-of-fit report of `trundle fit`."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import trundle
from tests.command import trundle as command
from trundle.cli.commands.fit import UNITS, format_fit

CONFIGS = Path(__file__).resolve().parents[2] / "configs"
LACK = "the model does not explain these data: run `trundle diagnose`"


def scenario(friction: float) -> str:
    """Return the demo's scenario, of four pushes of 3 s, with other dry friction; none for 0 N."""
    text = (CONFIGS / "experiments" / "demo.toml").read_text(encoding="utf-8")
    text = text.replace("../objects", str(CONFIGS / "objects"))
    text = text.replace("duration = 6.0", "duration = 3.0").replace("count = 8", "count = 5")
    text = text.replace("held_out = 2 ", "held_out = 1 ")
    begin, end = text.index('[[effect]]\nkind = "coulomb_friction"'), text.index("[sensor]")
    if friction == 0.0:
        return text[:begin] + text[end:]
    return text.replace("force = 14.0", f"force = {friction}")


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("fits")
    found = {}
    for name, friction in {"demo": 14.0, "slight": 0.5, "clean": 0.0}.items():
        (folder / f"{name}.toml").write_text(scenario(friction), encoding="utf-8")
        trundle.simulate(folder / f"{name}.toml", seed=2).write(folder / name)
        found[name] = folder / name
    return found


@pytest.fixture(scope="module")
def fits(recordings: dict[str, Path]) -> dict[str, trundle.Fit]:
    return {name: trundle.fit(path) for name, path in recordings.items()}


def test_a_missing_effect_is_reported_in_the_first_line(fits: dict[str, trundle.Fit]) -> None:
    demo = fits["demo"]
    assert demo.explains_data is False
    assert demo.residual_force_rms is not None and demo.residual_force_rms > 5.0
    assert format_fit(demo.summary).splitlines()[0].endswith(LACK)
    assert "N rms" in format_fit(demo.summary).splitlines()[1]


def test_a_clean_recording_is_explained(fits: dict[str, trundle.Fit]) -> None:
    clean = fits["clean"]
    assert clean.explains_data is True
    assert clean.residual_force_rms is not None and clean.residual_force_rms < 0.5
    assert LACK not in format_fit(clean.summary)
    assert clean.summary["intervals"] == {"coverage": 0.9, "basis": "curvature", "episodes": None}


def test_intervals_include_model_error(fits: dict[str, trundle.Fit]) -> None:
    """Dry friction of 0.5 N is missing: plain standard deviations of the mass are about 10 g."""
    summary = fits["slight"].summary
    assert summary["intervals"] == {"coverage": 0.9, "basis": "sandwich", "episodes": 4}
    mass, plain = (fits[name].summary["parameters"][0] for name in ("slight", "clean"))
    assert mass["name"] == "body.mass" and mass["sd"] > 1.5 * plain["sd"]
    assert mass["low"] < mass["mean"] < mass["high"]
    # Student's t with three degrees of freedom.
    assert mass["high"] - mass["low"] == pytest.approx(2 * 2.353 * mass["sd"], rel=0.05)


def test_the_written_model_has_the_wider_intervals(fits: dict[str, trundle.Fit]) -> None:
    slight = fits["slight"]
    text = slight.model.to_toml()
    covariance = re.search(r"covariance = \[\s*\[\s*([-+.\de]+)", text)
    assert covariance is not None
    assert float(covariance[1]) ** 0.5 == pytest.approx(slight.summary["parameters"][0]["sd"], rel=1e-6)


def test_other_likelihoods_have_no_test(recordings: dict[str, Path]) -> None:
    found = trundle.fit(recordings["clean"], likelihood="windows", starts=1)
    assert found.explains_data is None and found.residual_force_rms is None
    assert "lack of fit not tested" in format_fit(found.summary).splitlines()[0]


@pytest.mark.parametrize("name", ["demo", "slight", "clean"])
def test_fit_and_sample_find_the_same_optimum(
    recordings: dict[str, Path], fits: dict[str, trundle.Fit], name: str
) -> None:
    drawn = trundle.sample(recordings[name])
    assert drawn.summary["method"] == "laplace"
    fitted = [parameter["mean"] for parameter in fits[name].summary["parameters"]]
    # If the model is far from the data, searches end at slightly different points of a flat optimum.
    apart = 0.02 if name == "demo" else 1e-9
    np.testing.assert_allclose(drawn.summary["modes"][0]["values"], fitted, rtol=apart)
    assert drawn.summary["lack_of_fit"]["found"] == (name != "clean")


def test_every_metric_has_a_unit(recordings: dict[str, Path], tmp_path: Path) -> None:
    ran = command(tmp_path, "fit", recordings["clean"], "--quiet")
    assert ran.returncode == 0, ran.stderr
    lines = ran.stdout.splitlines()
    assert lines[0].endswith("the model explains these data (no lack of fit found)")
    units = r"(kg|m|rad|N·s/m|N|N·m|Hz|\(dimensionless\)|nats per pose sample)"
    figures = [
        line for line in lines if line.strip().startswith(("training", "held_out", "body.", "viscous"))
    ]
    assert len(figures) == 6 + 2 * len(UNITS)
    for line in figures:
        assert re.search(rf"\d {units}$", line), line
