"""Offsets of encoders in models whose masses are not exact: both change the torque of gravity."""

from __future__ import annotations

import pytest

import trundle
from tests.mechanism_diagnosis.recordings import NOMINAL, recording_of

OFFSET = 0.09
TRUE_BODIES = {
    'mass="1.2" diaginertia="0.02 0.02 0.004"': 'mass="1.08" diaginertia="0.018 0.018 0.0036"',
    'mass="0.6" diaginertia="0.006 0.006 0.001"': 'mass="0.54" diaginertia="0.0054 0.0054 0.0009"',
}


@pytest.fixture(scope="module")
def found() -> trundle.JointDiagnosis:
    truth = NOMINAL
    for given, true in TRUE_BODIES.items():
        truth = truth.replace(given, true)
    return trundle.diagnose(recording_of(truth, OFFSET))


def test_an_offset_of_the_first_joint_is_tied_to_a_tilt_of_the_base(found: trundle.JointDiagnosis) -> None:
    assert {"encoder_offset:shoulder", "base_tilt"} in [set(tie) for tie in found.answer["tied"]]


def test_the_offset_and_the_masses_are_exact(found: trundle.JointDiagnosis) -> None:
    [effect] = found.answer["missing"]
    angle = effect["parameters"]["offset" if effect["effect"] == "encoder_offset" else "angle_y"]
    assert angle["mean"] == pytest.approx(OFFSET, abs=4 * angle["sd"])
    assert angle["sd"] < 0.01 * OFFSET
    assert found.model.nominal["mass:upper"] == pytest.approx(1.08, rel=0.01)
    assert found.model.nominal["mass:fore"] == pytest.approx(0.54, rel=0.01)
