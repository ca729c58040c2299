"""Pneumatic seal: one pressure determines the friction less well than several."""

from __future__ import annotations

import numpy as np
import pytest

import trundle
from examples.real_recordings import ALL_PRESSURES, SEALS

CONSTANT = {"force_bias", "floor_slope", "directional_friction"}
"""Effects that are equivalent to a constant force if each direction has one speed."""


@pytest.fixture(scope="module")
def diagnosed(seals: dict[str, trundle.Recording]) -> dict[str, trundle.Diagnosis]:
    return {name: trundle.diagnose(recording) for name, recording in seals.items()}


def force(found: trundle.Diagnosis, when: str) -> float:
    return float(found.answer["fit"]["held_out"][when]["force_rmse"])


@pytest.mark.parametrize("name", SEALS)
def test_at_one_pressure_the_offset_is_named(diagnosed: dict[str, trundle.Diagnosis], name: str) -> None:
    """Dry friction is the only further effect that may be named."""
    found = diagnosed[name]
    assert found.verdict == "explained"
    assert set(found.missing) & CONSTANT
    assert set(found.missing) <= CONSTANT | {"coulomb_friction"}
    for effect in found.answer["missing"]:
        # The three effects are tied, so none is certain.
        assert effect["effect"] == "coulomb_friction" or effect["probability"] < 0.9
    assert force(found, "after") < 0.4 * force(found, "before")


@pytest.mark.parametrize("name", SEALS)
def test_each_direction_has_one_speed(seals: dict[str, trundle.Recording], name: str) -> None:
    """Two speeds give two forces, which a viscous law with an offset explains like a dry one."""
    speeds: dict[bool, list[float]] = {False: [], True: []}
    for table in seals[name].episodes.values():
        t, x = table["t"], table["object_x"]
        turn = int(np.argmax(x))
        for forth, rows in ((True, slice(50, turn - 50)), (False, slice(turn + 50, -50))):
            speeds[forth].append(abs(np.polyfit(t[rows], x[rows], 1)[0]))
    for of_direction in speeds.values():
        assert np.std(of_direction) < 0.05 * np.mean(of_direction)


@pytest.mark.parametrize("name", ALL_PRESSURES)
def test_at_several_pressures_dry_friction_is_named(
    diagnosed: dict[str, trundle.Diagnosis], name: str
) -> None:
    """Alone, or tied with friction by direction and then with a lower probability."""
    found = diagnosed[name]
    assert found.verdict == "explained"
    probability = {effect["effect"]: effect["probability"] for effect in found.answer["missing"]}
    tied = ["coulomb_friction", "directional_friction"] in found.answer["tied"]
    assert 0.5 < probability["coulomb_friction"] < 0.9 if tied else probability["coulomb_friction"] > 0.95
    assert set(probability) <= CONSTANT | {"coulomb_friction"}
    assert force(found, "after") < force(found, "before")
