"""A diagnosis does not depend on the units of length, force and time."""

from __future__ import annotations

import copy
from pathlib import Path

import numpy as np
import pytest

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
def in_si(recording: trundle.Recording) -> dict[str, object]:
    """Return the answer in SI units."""
    return summary(trundle.diagnose(recording, check=False))


def summary(diagnosis: trundle.Diagnosis) -> dict[str, object]:
    """Return the verdict and the probabilities by name."""
    missing = {effect["effect"]: effect["probability"] for effect in diagnosis.answer["missing"]}
    return {"verdict": diagnosis.verdict, "missing": missing}


def test_the_slope_is_named(in_si: dict[str, object]) -> None:
    assert in_si["verdict"] == "explained"
    assert list(in_si["missing"]) == ["floor_slope"]  # type: ignore[call-overload]


SINGLE_UNITS = [(10, 0, 0), (-10, 0, 0), (0, 10, 0), (0, -10, 0), (0, 0, 10), (0, 0, -10)]


@pytest.mark.parametrize(
    ("length", "force", "time"),
    [
        *(pytest.param(*powers, marks=pytest.mark.slow) for powers in SINGLE_UNITS),
        (10, -10, 10),
        (-10, 10, -10),
    ],
)
def test_verdict_names_and_probabilities_do_not_depend_on_units(
    recording: trundle.Recording, in_si: dict[str, object], length: int, force: int, time: int
) -> None:
    other = summary(trundle.diagnose(rescaled(recording, 2.0**length, 2.0**force, 2.0**time), check=False))
    assert other["verdict"] == in_si["verdict"]
    assert other["missing"] == pytest.approx(in_si["missing"], abs=1e-3)


def test_numbers_are_in_the_units_of_the_recording(recording: trundle.Recording) -> None:
    def values(diagnosis: trundle.Diagnosis) -> tuple[float, float, float]:
        answer = diagnosis.answer
        slope = answer["missing"][0]["parameters"]["accel_x"]["mean"]
        return (
            slope,
            answer["nominal"]["after"]["mass"]["mean"],
            answer["fit"]["held_out"]["after"]["position_rmse"],
        )

    si = values(trundle.diagnose(recording, check=False))
    large = values(trundle.diagnose(rescaled(recording, 1024.0, 1.0, 1.0), check=False))
    # The step of the final simulation depends on a speed in m/s.
    assert large == pytest.approx((si[0] * 1024.0, si[1] / 1024.0, si[2] * 1024.0), rel=1e-3)
