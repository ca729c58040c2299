"""CMU's continuous logs: viscous against dry friction from the motion along the way."""

from __future__ import annotations

import pytest

import trundle
from examples.real_recordings import EARLIER, LATER, holding_out, straight, under_body, wrench_r2


@pytest.mark.parametrize("log", LATER)
def test_dry_friction_explains_each_held_out_log_better(later_logs: trundle.Recording, log: str) -> None:
    viscous, dry, friction = under_body(holding_out(later_logs, log))
    assert dry > viscous + 0.01
    assert dry > 0.87
    assert friction == pytest.approx(0.72, abs=0.08)


@pytest.mark.parametrize("log", LATER)
def test_the_diagnosis_says_dry_friction(later_logs: trundle.Recording, log: str) -> None:
    split = holding_out(later_logs, log)
    found = trundle.diagnose(split)
    assert found.verdict == "explained"
    assert "coulomb_friction" in found.missing
    corners = split.metadata["object"]["footprint"]
    assert wrench_r2(found.series, corners, "after") > wrench_r2(found.series, corners) + 0.05
    nominal = found.answer["nominal"]
    assert nominal["before"]["mass"]["identifiable"] is nominal["after"]["mass"]["identifiable"] is False
    assert nominal["after"]["mass"]["mean"] is None
    for figures in found.answer["fit"]["held_out"].values():
        given = {key for key, value in figures.items() if value is not None}
        assert given == {"force_rmse", "torque_rmse"}


def test_the_earlier_logs_are_of_another_load_or_floor(
    earlier_logs: trundle.Recording, later_logs: trundle.Recording
) -> None:
    """Why they are a recording of their own: sliding straight takes half the force."""
    earlier, later = straight(earlier_logs), straight(later_logs)
    assert sorted(earlier) == list(EARLIER)
    assert sorted(later) == list(LATER)
    assert max(earlier.values()) < 0.7 * min(later.values())
