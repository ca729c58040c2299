"""EMPS: fits and diagnosis compared with the publication."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

import trundle
from examples.real_recordings import MODELS, missing_force, ripple, spectrum

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def fits(axis: trundle.Recording) -> dict[str, Mapping[str, Any]]:
    names = ("rail_viscous", "rail_dry_bias", "rail_dry_slope", "rail_directional")
    return {name: trundle.fit(axis, MODELS / f"{name}.toml", starts=2).summary for name in names}


def values(summary: dict[str, Any]) -> dict[str, float]:
    return {p["name"].partition(".")[2]: p["mean"] for p in summary["parameters"]}


def window(summary: dict[str, Any]) -> float:
    """Error one second ahead on the held-out file, mm."""
    return 1e3 * float(summary["held_out"]["window_position_rmse"])


def test_dry_friction_and_offset_agree_with_the_publication(fits: dict[str, dict[str, Any]]) -> None:
    """Janot, Gautier and Brunot 2019: 95.11 kg, 203.5 N·s/m, 20.39 N, -3.16 N."""
    found = values(fits["rail_dry_bias"])
    assert found["mass"] == pytest.approx(95.11, rel=0.01)
    assert found["mu_x"] == pytest.approx(203.5, rel=0.04)
    assert found["force"] == pytest.approx(20.39, rel=0.03)
    assert found["force_x"] == pytest.approx(-3.16, rel=0.03)


def test_friction_by_direction_agrees_with_the_publication(fits: dict[str, dict[str, Any]]) -> None:
    """The same with friction by direction: 166.7 forward, 240.4 back, 20.1 and 20.6 N."""
    found = values(fits["rail_directional"])
    assert found["mu_x"] + found["difference"] == pytest.approx(166.7, rel=0.03)
    assert found["mu_x"] - found["difference"] == pytest.approx(240.4, rel=0.045)
    assert found["force"] == pytest.approx(20.35, rel=0.03)


def test_each_law_improves_the_held_out_error(fits: dict[str, dict[str, Any]]) -> None:
    """An independent estimate of the three models, one second ahead: 6.2, 2.0 and 1.4 mm."""
    assert window(fits["rail_viscous"]) == pytest.approx(6.4, abs=0.4)
    assert window(fits["rail_dry_bias"]) == pytest.approx(2.05, abs=0.15)
    assert window(fits["rail_directional"]) == pytest.approx(1.45, abs=0.15)
    open_loop = [fits[name]["held_out"]["position_rmse"] for name in ("rail_viscous", "rail_directional")]
    assert open_loop[1] < 0.11 * open_loop[0]


def test_bias_and_slope_are_indistinguishable_on_a_rail(fits: dict[str, dict[str, Any]]) -> None:
    bias, slope = values(fits["rail_dry_bias"]), values(fits["rail_dry_slope"])
    assert slope["accel_x"] * slope["mass"] == pytest.approx(-bias["force_x"], rel=2e-3)
    assert window(fits["rail_dry_slope"]) == pytest.approx(window(fits["rail_dry_bias"]), rel=2e-3)


@pytest.mark.slow
def test_the_diagnosis_names_the_published_effects(axis: trundle.Recording) -> None:
    found = trundle.diagnose(axis, MODELS / "rail_viscous.toml")
    assert found.verdict == "explained"
    # The offset, or friction by direction, which takes its place.
    assert "coulomb_friction" in found.missing
    assert set(found.missing) & {"directional_friction", "force_bias", "floor_slope"}
    after = found.answer["fit"]["held_out"]["after"]
    assert after["position_rmse"] < 0.012
    assert after["window_position_rmse"] < 2.1e-3
    assert after["heading_rmse"] is None
    assert found.answer["mismatch"]["regime"]
    # The ripple of the screw remains and is the largest period.
    largest = found.answer["residual"]["periods"][0]
    assert largest["of"] == "position"
    assert largest["period"] == pytest.approx(2.5e-3, rel=0.01)
    assert 0.7 < largest["amplitude"] < 1.4
    # The drive's delay is detected and does not improve predictions.
    assert "latency" in {effect["effect"] for effect in found.answer["immaterial"]}


def test_the_residual_is_a_ripple_and_a_delay(
    axis: trundle.Recording, fits: dict[str, dict[str, Any]]
) -> None:
    fitted = [p["mean"] for p in fits["rail_directional"]["parameters"]]
    left = missing_force(axis, "episode_00", fitted)
    for speed in (0.083, 0.125):
        cycles, power = spectrum(ripple(left, speed)[1], speed)
        assert 1.0 / cycles[np.argmax(power)] == pytest.approx(2.5e-3, rel=0.02)
    for episode in axis.episodes:
        prompt, late = (np.std(missing_force(axis, episode, fitted, s)["missing"]) for s in (0.0, 0.8e-3))
        assert late < 0.8 * prompt, episode
