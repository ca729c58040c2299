"""Gains of efforts at joints that move the same bodies."""

from __future__ import annotations

import pytest

import trundle
from tests.mechanism_diagnosis.recordings import ARM, NOMINAL, log_of

pytest.importorskip("mujoco")

FRICTION = 0.8
GAIN = 1.3


def diagnosed(**mechanism: object) -> trundle.JointDiagnosis:
    """Return the diagnosis of an arm with friction in the shoulder and a wrong gain at the elbow."""
    truth = ARM.format(shoulder=f' frictionloss="{FRICTION}"', elbow="")
    episodes = {f"e{seed}": log_of(truth, seed) for seed in range(4)}
    for columns in episodes.values():
        columns["effort_elbow"] = GAIN * columns["effort_elbow"]
    metadata = {
        "format": "trundle-recording/2",
        "name": "arm",
        "mechanism": {"model": "robot.xml", "joints": ["shoulder", "elbow"], **mechanism},
        "split": {"held_out": ["e3"]},
    }
    return trundle.diagnose(trundle.JointRecording(metadata, episodes, {"robot.xml": NOMINAL.encode()}))


def test_a_gain_is_tied_with_the_inverse_gain_of_a_joint_that_moves_the_same_free_mass() -> None:
    # The mass of the forearm takes the gain of the elbow; all other efforts are then too small.
    found = diagnosed()
    gains = {"effort_gain:shoulder", "effort_gain:elbow"}
    assert [set(tie) for tie in found.answer["tied"]] == [gains]
    assert "joint_dry_friction:shoulder" in found.missing
    (gain,) = (one for one in found.answer["missing"] if one["effect"] == "effort_gain")
    assert gain["probability"] < 0.9


def test_known_masses_tell_the_joint_of_a_gain() -> None:
    found = diagnosed(free=["armature", "damping"])
    assert set(found.missing) == {"effort_gain:elbow", "joint_dry_friction:shoulder"}
    assert found.answer["tied"] == []
