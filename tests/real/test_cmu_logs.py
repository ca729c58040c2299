"""CMU continuous logs: viscous and dry friction compared."""

from __future__ import annotations

import pytest

import trundle
from examples.real_recordings import (
    EARLIER,
    LATER,
    MODELS,
    compare_under_body,
    straight_sliding_force,
    with_held_out,
    wrench_r2,
)


@pytest.fixture(params=[*LATER, *EARLIER])
def held_out(
    request: pytest.FixtureRequest, later_logs: trundle.Recording, earlier_logs: trundle.Recording
) -> trundle.Recording:
    """The logs with one load and floor, one of them held out."""
    return with_held_out(later_logs if request.param in LATER else earlier_logs, request.param)


def test_dry_friction_explains_each_held_out_log_better(held_out: trundle.Recording) -> None:
    """The pressure under the face is unknown; both laws have a parameter for its spread."""
    viscous, dry, friction = compare_under_body(held_out)
    assert dry > viscous + 0.01
    assert dry > 0.9
    later = held_out.metadata["split"]["held_out"][0] in LATER
    assert friction == pytest.approx(0.73 if later else 0.355, rel=0.1)


def test_dry_friction_explains_the_force_better(held_out: trundle.Recording) -> None:
    force = {
        law: trundle.diagnose(held_out, MODELS / f"{law}_under_body.toml").answer["fit"]["held_out"]["before"]
        for law in ("drag", "friction")
    }
    assert force["friction"]["force_rmse"] < 0.9 * force["drag"]["force_rmse"]


@pytest.mark.parametrize("log", LATER)
def test_the_diagnosis_names_dry_friction(later_logs: trundle.Recording, log: str) -> None:
    split = with_held_out(later_logs, log)
    found = trundle.diagnose(split)
    assert found.verdict == "explained"
    assert found.missing[0] == "coulomb_friction"
    # Without a parameter for the pressure, spin damping would replace it.
    assert "second_wheel" not in found.missing
    corners = split.metadata["object"]["footprint"]
    assert wrench_r2(found.series, corners, "after") > wrench_r2(found.series, corners) + 0.05
    nominal = found.answer["nominal"]
    assert nominal["before"]["mass"]["identifiable"] is nominal["after"]["mass"]["identifiable"] is False
    assert nominal["after"]["mass"]["mean"] is None
    for figures in found.answer["fit"]["held_out"].values():
        given = {key for key, value in figures.items() if value is not None}
        assert given == {"force_rmse", "torque_rmse"}
    after, before = (found.answer["fit"]["held_out"][when]["force_rmse"] for when in ("after", "before"))
    assert after < before


def test_the_earlier_logs_have_another_load_or_floor(
    earlier_logs: trundle.Recording, later_logs: trundle.Recording
) -> None:
    """They are a separate recording because straight sliding takes half the force."""
    earlier, later = straight_sliding_force(earlier_logs), straight_sliding_force(later_logs)
    assert sorted(earlier) == list(EARLIER)
    assert sorted(later) == list(LATER)
    assert max(earlier.values()) < 0.7 * min(later.values())
