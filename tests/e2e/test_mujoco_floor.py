"""Diagnosis of dry friction under a table in MuJoCo, also in forms outside the catalogue."""

from __future__ import annotations

import pytest

import trundle
from tests.e2e.mujoco_floor import FRICTION, MASS, recording


@pytest.mark.slow
@pytest.mark.xfail(reason="a point of the body is named where the whole of it rubs")
def test_creeping_friction_is_named_with_its_creep_speed() -> None:
    """With the default creep of 0.1 mm/s the friction would be 3 % too low."""
    found = trundle.diagnose(recording("creeping", strength=30.0, feet=True, episodes=4))
    assert found.verdict == "explained"
    assert found.missing == ["coulomb_friction"]
    effect = found.answer["missing"][0]
    assert "under the whole body" in effect["statement"]
    assert effect["where"] is None
    assert effect["parameters"]["force"]["mean"] == pytest.approx(FRICTION, rel=0.01)
    assert effect["parameters"]["creep"]["mean"] == pytest.approx(1e-3, rel=0.15)
    assert found.answer["nominal"]["after"]["mass"]["mean"] == pytest.approx(MASS, rel=0.02)
    before, after = (found.answer["fit"]["held_out"][when] for when in ("before", "after"))
    assert after["window_position_rmse"] < 0.1 * before["window_position_rmse"]
    assert after["r2"] > 0.98


@pytest.mark.slow
def test_friction_of_each_joint_is_dry_friction_along_axes() -> None:
    """MuJoCo's friction loss of each joint separates x, y and rotation, unlike a floor."""
    found = trundle.diagnose(recording("joints", feet=True, episodes=4))
    assert (found.verdict, found.missing) == ("explained", ["axis_friction"])
    parameters = found.answer["missing"][0]["parameters"]
    for force in ("force_x", "force_y"):
        assert parameters[force]["mean"] == pytest.approx(FRICTION, rel=0.02)
    assert parameters["angle"]["mean"] == pytest.approx(0.0, abs=0.01)
