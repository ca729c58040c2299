"""Warnings and figures of held-out episodes."""

from __future__ import annotations

import pytest

import trundle
from tests.mechanism_diagnosis.recordings import ARM, arm_recording, log_of
from trundle.joint_diagnosis import engine


def test_a_held_out_episode_of_another_mechanism_is_reported() -> None:
    recording = arm_recording(0.0)
    episodes = {name: recording.frame(name) for name in recording}
    episodes["e3"] = log_of(ARM.format(shoulder="", elbow=' frictionloss="0.5"'), 3)
    changed = trundle.JointRecording(recording.metadata, episodes, recording.files)
    diagnosis = trundle.diagnose(changed)
    assert diagnosis.missing == []
    (warning,) = [one for one in diagnosis.answer["warnings"] if "held out" in one]
    assert warning.startswith("e3 (held out) behaves unlike the training episodes")
    assert "joint elbow" in warning


def test_episodes_of_one_mechanism_are_alike() -> None:
    assert not any("held out" in one for one in trundle.diagnose(arm_recording(0.3)).answer["warnings"])


def test_errors_of_positions_that_rise_are_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    paths = engine.mechanism_paths

    def worse(*args: object) -> dict[str, object]:
        found = paths(*args)  # type: ignore[arg-type]
        for path in found.values():
            assert path.after is not None
            path.after[:, 0] += 0.5
        return found  # type: ignore[return-value]

    monkeypatch.setattr(engine, "mechanism_paths", worse)
    warnings = trundle.diagnose(arm_recording(0.3)).answer["warnings"]
    (warning,) = [one for one in warnings if "became worse" in one]
    assert "position error in open loop of joint shoulder" in warning
    assert "elbow" not in warning
