"""Identifiability of a fit, profiles, and the choice of an optimiser."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import trundle
from trundle.cli import main
from trundle.identifiability import CHI2_1_QUANTILE_90, format_identifiability

SCENARIO = """
format = "trundle-scenario/1"
name = "table"
object = "{table}"
held_out = 0
[[effect]]
kind = "viscous_wheel"
x = -0.5
y = -0.3
angle = 0.2
mu_x = 15.0
mu_y = 180.0
[random]
count = 2
duration = 4.0
speed = 0.3
spin = 0.5
"""


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("push")
    table = Path(__file__).parents[2] / "configs" / "objects" / "office_table.toml"
    (folder / "push.toml").write_text(SCENARIO.format(table=table), encoding="utf-8")
    trundle.simulate(folder / "push.toml", seed=1).write(folder / "recording")
    return folder / "recording"


def test_every_fit_reports_identifiability(recording: Path) -> None:
    summary = trundle.fit(recording).summary
    held = summary["identifiability"]
    assert held["held"] == held["of"] == len(summary["parameters"]) == 6
    information = [direction["information"] for direction in held["directions"]]
    assert information == sorted(information, reverse=True)
    assert held["agreement"]["starts"] == 6
    assert format_identifiability(held)[0].startswith("identifiable directions: 6 of 6")


def test_both_optimisers_agree(recording: Path) -> None:
    by_name = {
        optimiser: {p["name"]: p for p in trundle.fit(recording, optimiser=optimiser).summary["parameters"]}
        for optimiser in ("lm", "lbfgs")
    }
    for name, ours in by_name["lm"].items():
        assert abs(ours["mean"] - by_name["lbfgs"][name]["mean"]) < 0.1 * ours["sd"], name


def test_an_unknown_optimiser_is_refused(recording: Path) -> None:
    with pytest.raises(trundle.TrundleError, match="choose 'lm' or 'lbfgs'"):
        trundle.fit(recording, optimiser="newton")  # type: ignore[arg-type]


def test_the_interval_of_a_profile_is_where_the_deviance_crosses(recording: Path) -> None:
    seen = trundle.profile(recording, "body.mass")
    assert seen.shape == "two-sided" and len(seen.modes) == 1
    low, high = seen.interval
    assert low is not None and high is not None and seen.mean is not None and seen.sd is not None
    assert (np.diff(seen.values) > 0).all() and seen.deviance.min() == 0
    assert high - low == pytest.approx(2 * 1.645 * seen.sd, rel=0.2)
    assert np.interp(high, seen.values, seen.deviance) == pytest.approx(CHI2_1_QUANTILE_90, rel=0.3)
    assert "body.mass lies between" in str(seen) and "|" in seen.plot()


def test_the_profile_of_a_fixed_parameter_is_refused(recording: Path) -> None:
    with pytest.raises(trundle.TrundleError, match=r"body\.mass"):
        trundle.profile(recording, "body.weight")
    with pytest.raises(trundle.TrundleError, match="finite"):
        trundle.profile(recording, "body.mass", grid=[np.nan])


def test_the_command_line_prints_both(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fit", str(recording), "--quiet", "--optimiser", "lbfgs"]) == 0
    assert "identifiable directions: 6 of 6" in capsys.readouterr().out
    assert main(["fit", str(recording), "--quiet", "--profile", "body.mass", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["shape"] == "two-sided"
