"""A diagnosis does not depend on the units of length, force and time."""

from __future__ import annotations

import copy
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import trundle

SCENARIO = """
format = "trundle-scenario/1"
name = "table"
object = "{objects}/office_table.toml"
held_out = 1

[[effect]]
kind = "viscous_wheel"
x = -0.5
y = 0.3
angle = 0.3
mu_x = 180.0
mu_y = 320.0

[[effect]]
kind = "floor_slope"
accel_x = 0.06
accel_y = -0.03

[sensor]
rate = 100.0

[tracker]
rate = 40.0

[random]
count = 5
duration = 4.0
speed = 0.3
spin = 0.5
"""

OBJECTS = Path(__file__).parents[2] / "configs" / "objects"


def rescaled(recording: trundle.Recording, length: float, force: float, time: float) -> trundle.Recording:
    """Return the recording in smaller units."""
    metadata = copy.deepcopy(recording.metadata)
    body = metadata["object"]
    for key in ("footprint", "support"):
        if key in body:
            body[key] = (np.asarray(body[key]) * length).tolist()
    if "mass" in body:
        body["mass"] *= force * time**2 / length
    wrench = metadata["wrench"]
    if "precontact" in wrench:
        assert isinstance(wrench["precontact"], list)
        wrench["precontact"] = [t * time for t in wrench["precontact"]]
    if "noise" in metadata:
        noise = metadata["noise"]
        noise["pose"] = [noise["pose"][0] * length, noise["pose"][1] * length, noise["pose"][2]]
        noise["force"] *= force
        noise["torque"] *= force * length
    sizes = {"t": time, "object_x": length, "object_y": length, "gripper_x": length, "gripper_y": length}
    sizes |= {"force_x": force, "force_y": force, "force_z": force}
    sizes |= {f"torque_{axis}": force * length for axis in "xyz"}
    episodes = {
        name: {title: np.asarray(values) * sizes.get(title, 1.0) for title, values in columns.items()}
        for name, columns in recording.episodes.items()
    }
    return trundle.Recording(metadata, episodes)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> trundle.Recording:
    """Return a recording of a table on a slope."""
    folder = tmp_path_factory.mktemp("units")
    (folder / "scenario.toml").write_text(SCENARIO.format(objects=OBJECTS.as_posix()))
    trundle.simulate(folder / "scenario.toml", seed=3).write(folder / "recording")
    return trundle.read(folder / "recording")


@pytest.fixture(scope="module")
def in_si(recording: trundle.Recording) -> trundle.Diagnosis:
    """Return the diagnosis in SI units."""
    return trundle.diagnose(recording, check=False)


@pytest.fixture(scope="module")
def in_large_units(recording: trundle.Recording) -> trundle.Diagnosis:
    """Return the diagnosis in a large unit of length."""
    return diagnosed(recording, 10, 0, 0)


def diagnosed(recording: trundle.Recording, length: int, force: int, time: int) -> trundle.Diagnosis:
    return trundle.diagnose(rescaled(recording, 2.0**length, 2.0**force, 2.0**time), check=False)


def test_the_slope_is_named(in_si: trundle.Diagnosis) -> None:
    assert in_si.verdict == "explained"
    assert in_si.missing == ["floor_slope"]


def agree(one: trundle.Diagnosis, other: trundle.Diagnosis) -> bool:
    """Return whether verdict, names and probabilities are the same."""
    probabilities = [
        {effect["effect"]: effect["probability"] for effect in diagnosis.answer["missing"]}
        for diagnosis in (one, other)
    ]
    return one.verdict == other.verdict and probabilities[0] == pytest.approx(probabilities[1], abs=1e-3)


def test_the_answer_does_not_depend_on_the_unit_of_length(
    in_si: trundle.Diagnosis, in_large_units: trundle.Diagnosis
) -> None:
    assert agree(in_large_units, in_si), in_large_units


SINGLE_UNITS = [(-10, 0, 0), (0, 10, 0), (0, -10, 0), (0, 0, 10), (0, 0, -10)]


@pytest.mark.parametrize(
    ("length", "force", "time"),
    [
        *(pytest.param(*powers, marks=pytest.mark.slow) for powers in [*SINGLE_UNITS, (10, -10, 10)]),
        (-10, 10, -10),
    ],
)
def test_the_answer_does_not_depend_on_units(
    recording: trundle.Recording, in_si: trundle.Diagnosis, length: int, force: int, time: int
) -> None:
    other = diagnosed(recording, length, force, time)
    assert agree(other, in_si), other


def test_numbers_are_in_the_units_of_the_recording(
    in_si: trundle.Diagnosis, in_large_units: trundle.Diagnosis
) -> None:
    def values(diagnosis: trundle.Diagnosis) -> NDArray[np.float64]:
        answer = diagnosis.answer
        slope = answer["missing"][0]["parameters"]["accel_x"]["mean"]
        mass = answer["nominal"]["after"]["mass"]["mean"]
        return np.array([slope, mass, answer["fit"]["held_out"]["after"]["position_rmse"]])

    # The step of the final simulation depends on a speed in m/s.
    assert values(in_large_units) == pytest.approx(values(in_si) * [1024.0, 1 / 1024.0, 1024.0], rel=1e-3)
