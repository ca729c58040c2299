"""Forward simulation of plays and elastic transmissions between a drive and a carriage of 1 kg each."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

pytest.importorskip("mujoco")

from trundle.mechanism import EffortDrive, Mechanism, simulate
from trundle.mechanism.transmissions import Transmission, can_be_split, split_model

Floats = NDArray[np.float64]

AXIS = """<mujoco><worldbody><body name="carriage"><joint name="rail" type="slide" axis="1 0 0" {joint}/>
<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></worldbody></mujoco>"""
STIFFNESS, GAP = 100.0, 0.1
START = 0.1
DRIVE = EffortDrive([0.0, START], [[0.0], [1.0]], hold=True)


def pushed(transmission: Transmission, t: Floats) -> Floats:
    """Return the positions at the encoder under 1 N from START on, from rest."""
    mechanism = Mechanism.load(AXIS.format(joint='armature="1"'), ["rail"])
    split = split_model(mechanism, [transmission])
    q, _ = simulate(mechanism, t, [0.0], [0.0], DRIVE, split=split, step=1e-4)
    return q[:, 0]


@pytest.mark.parametrize("on_drive", [True, False])
def test_drive_and_carriage_vibrate_against_each_other(on_drive: bool) -> None:
    times = np.linspace(0.0, 1.0, 51)
    t = np.maximum(times - START, 0.0)
    frequency = np.sqrt(2 * STIFFNESS)
    deflection = (1.0 - np.cos(frequency * t)) / frequency**2
    expected = t**2 / 4 + (0.5 if on_drive else -0.5) * deflection
    found = pushed(Transmission("rail", on_drive, stiffness=STIFFNESS), times)
    np.testing.assert_allclose(found, expected, atol=1e-4)


@pytest.mark.parametrize("on_drive", [True, False])
def test_a_constant_push_begins_without_vibration(on_drive: bool) -> None:
    t = START + np.linspace(0.0, 1.0, 51)
    found = pushed(Transmission("rail", on_drive, stiffness=STIFFNESS), t)
    np.testing.assert_allclose(found, (t - START) ** 2 / 4, atol=1e-4)


@pytest.mark.parametrize("on_drive", [True, False])
def test_the_drive_crosses_the_play_alone(on_drive: bool) -> None:
    impact = np.sqrt(GAP)
    times = np.linspace(0.0, 0.9, 46)
    t = np.maximum(times - START, 0.0)
    after = np.maximum(t - impact, 0.0)
    drive = np.where(t < impact, t**2 / 2, GAP / 2 + impact / 2 * after + after**2 / 4)
    expected = drive if on_drive else np.maximum(drive - GAP / 2, 0.0)
    np.testing.assert_allclose(pushed(Transmission("rail", on_drive, gap=GAP), times), expected, atol=1e-3)


@pytest.mark.parametrize(("joint", "possible"), [("", False), ('armature="1"', True)])
def test_a_drive_without_inertia_has_no_motion_of_its_own(joint: str, possible: bool) -> None:
    mechanism = Mechanism.load(AXIS.format(joint=joint), ["rail"])
    assert can_be_split(mechanism, [Transmission("rail", on_drive=True, gap=GAP)]) == possible
    assert can_be_split(mechanism, [])


def test_a_fitted_inertia_of_the_drive_counts_when_the_model_is_compiled(
    recwarn: pytest.WarningsRecorder,
) -> None:
    fitted = Mechanism.load(AXIS.format(joint=""), ["rail"]).adjusted(armature={"rail": 1.0})
    split = split_model(fitted, [Transmission("rail", on_drive=True, gap=GAP)])
    assert split.compiled.dof_armature.tolist() == [1.0, 0.0]
    assert not recwarn
