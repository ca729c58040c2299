"""Warnings and figures of held-out episodes."""

from __future__ import annotations

import numpy as np
import pytest

import trundle
from tests.mechanism_diagnosis.recordings import ARM, NOMINAL, arm_recording, log_of, recording_of
from trundle import _native
from trundle.joint_diagnosis import engine, held_out


def test_a_held_out_episode_of_another_mechanism_is_reported() -> None:
    recording = arm_recording(0.0)
    episodes = {name: log_of(NOMINAL, seed) for seed, name in enumerate(recording)}
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
    def worse(*args: object) -> dict[str, object]:
        found = held_out.mechanism_paths(*args)  # type: ignore[arg-type]
        for path in found.values():
            assert path.after is not None
            path.after[:, 0] += 0.5
        return found  # type: ignore[return-value]

    monkeypatch.setattr(engine, "mechanism_paths", worse)
    warnings = trundle.diagnose(arm_recording(0.3)).answer["warnings"]
    (warning,) = [one for one in warnings if "became worse" in one]
    assert "position error in open loop of joint shoulder" in warning
    assert "elbow" not in warning


def test_open_loops_that_diverge_without_the_effect_raise_no_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    def diverged(*args: object) -> dict[str, object]:
        found = held_out.mechanism_paths(*args)  # type: ignore[arg-type]
        for path in found.values():
            assert path.before is not None and path.after is not None
            path.before[:, 0] += 60.0
            path.after[:, 0] += 140.0
        return found  # type: ignore[return-value]

    monkeypatch.setattr(engine, "mechanism_paths", diverged)
    warnings = trundle.diagnose(arm_recording(0.3)).answer["warnings"]
    assert not any("became worse" in one for one in warnings)


def test_an_effect_that_increases_the_held_out_misfit_is_reported() -> None:
    recording = arm_recording(0.3)
    episodes = {
        name: log_of(ARM.format(shoulder="", elbow=' frictionloss="0.3"'), k)
        for k, name in enumerate(recording)
    }
    episodes["e3"] = log_of(NOMINAL, 3)
    diagnosis = trundle.diagnose(trundle.JointRecording(recording.metadata, episodes, recording.files))
    (effect,) = diagnosis.answer["missing"]
    assert effect["effect"] == "joint_dry_friction"
    assert (effect["explains"] or 0.0) < -0.1
    assert any(one.startswith("joint_dry_friction makes predictions") for one in diagnosis.answer["warnings"])


def test_a_timing_within_a_sample_alone_is_no_wrong_value() -> None:
    recording = arm_recording(0.0)
    late = {name: log_of(NOMINAL, seed, delay_steps=2) for seed, name in enumerate(recording)}
    diagnosis = trundle.diagnose(trundle.JointRecording(recording.metadata, late, recording.files))
    timings = [diagnosis.answer["nominal"]["after"][f"timing:{joint}"]["mean"] for joint in recording.joints]
    assert timings[0] == pytest.approx(0.002, abs=3e-4)
    assert diagnosis.verdict == "consistent"


def stepped(t: np.ndarray) -> np.ndarray:
    """Return positions that follow steps within some 60 ms."""
    targets = np.where((t // 0.7) % 2 == 0, 0.3, -0.3)
    q, v, found = 0.0, 0.0, []
    dt, w = t[1] - t[0], 40.0
    for target in targets:
        found.append(q)
        v += dt * (w * w * (target - q) - 2 * w * v)
        q += dt * v
    return np.array(found)


@pytest.mark.parametrize(("step", "tolerance"), [(0.0, 0.1), (1.5e-3, 0.3)], ids=["exact", "quantised"])
def test_causal_velocities_follow_fast_steps(step: float, tolerance: float) -> None:
    t = np.arange(0.0, 10.0, 0.001)
    q = stepped(t)
    recorded = np.round(q / step) * step if step else q
    metadata = {
        "format": "trundle-recording/2",
        "name": "steps",
        "mechanism": {"axis": "hinge", "joints": ["arm"]},
    }
    columns = {"t": t, "q_arm": recorded, "effort_arm": np.sin(t)}
    own = _native._joint_motion(trundle.JointRecording(metadata, {"one": columns}))["episodes"]["one"]
    velocity = np.interp(own["t"], t, np.gradient(q, t))
    error = np.sqrt(np.mean((own["causal_v"][:, 0] - velocity)[100:] ** 2))
    assert error < tolerance  # velocities reach 8.8 rad/s


def test_later_samples_do_not_change_causal_states() -> None:
    recording = recording_of(NOMINAL)
    frames = {name: recording.frame(name) for name in recording}
    frames["e3"].loc[frames["e3"].index[-200:], "q_elbow"] += 1.0
    changed = trundle.JointRecording(recording.metadata, frames, recording.files)
    first, second = (_native._joint_motion(one)["episodes"]["e3"] for one in (recording, changed))
    rows = first["t"] < 6.9
    np.testing.assert_array_equal(first["causal_v"][rows], second["causal_v"][rows])
    assert not np.array_equal(first["causal_v"], second["causal_v"])
