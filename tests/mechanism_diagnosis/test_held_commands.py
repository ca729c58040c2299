"""Held commands in simulations act from the time of their sample, also if times are rounded."""

from __future__ import annotations

import numpy as np
import pytest

import trundle
from tests.mechanism_diagnosis.recordings import NOMINAL, log_of
from trundle.held_samples import held_means
from trundle.joint_diagnosis.signals import read_signals
from trundle.mechanism import EffortDrive

DT = 0.004
T = np.round(np.arange(3000) * DT, 6)
NOT_QUITE = T * (1 - 1e-13)


@pytest.mark.parametrize("name", ["target", "on"])
def test_streams_at_times_a_little_before_their_samples(name: str) -> None:
    values = np.round(np.sin(3 * T)) if name == "on" else np.sin(3 * T)
    metadata = {
        "format": "trundle-recording/2",
        "name": "held",
        "mechanism": {"axis": "hinge", "joints": ["arm"]},
    }
    columns = {"t": T, "q_arm": np.sin(T), "target_arm": np.sin(3 * T), f"{name}_arm": np.abs(values)}
    recording = trundle.JointRecording(metadata, {"e": columns})
    signals = read_signals(recording, "e", "arm", NOT_QUITE)
    found = signals.command if name == "target" else signals.on
    assert (NOT_QUITE < T).mean() > 0.5
    np.testing.assert_allclose(found, np.abs(values), atol=1e-8)


def test_a_mean_has_the_impulse_of_faster_and_of_late_commands() -> None:
    times = np.array([0.0, 0.5, 1.0, 2.25])
    values = np.array([4.0, 0.0, 2.0, 6.0])
    np.testing.assert_allclose(held_means(times, values, np.arange(-1.0, 4.0)), [4.0, 2.0, 2.0, 5.0, 6.0])


def test_a_held_effort_acts_from_its_time_on_although_the_clock_accumulates_rounding_errors() -> None:
    drive = EffortDrive(T, np.arange(len(T))[:, None], hold=True)
    clock = np.cumsum(np.full(len(T), DT)) - DT
    assert (clock < T).any()
    found = [float(drive(t, np.zeros(1), np.zeros(1))[0][0]) for t in clock]
    np.testing.assert_array_equal(found, np.arange(len(T)))


def test_a_mechanism_that_starts_at_rest_is_simulated_from_rest() -> None:
    metadata = {
        "format": "trundle-recording/2",
        "name": "arm",
        "mechanism": {"model": "robot.xml", "joints": ["shoulder", "elbow"]},
        "start": {"at_rest": True},
        "split": {"held_out": ["e1"]},
    }
    episodes = {f"e{seed}": log_of(NOMINAL, seed, 6.0) for seed in range(2)}
    recording = trundle.JointRecording(metadata, episodes, {"robot.xml": NOMINAL.encode()})
    path = trundle.diagnose(recording).predictions["e1"]
    assert path.t[0] == 0.0
    assert path.before is not None
    error = np.abs(path.before - path.observed)[:20]
    assert error[0].max() == 0.0
    assert error.max() < 2e-3
