"""The EMPS benchmark: invented files of its layout, and the real data."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io

import trundle
from tests.importers.conftest import Import
from tests.importers.mechanisms import check_joints
from trundle.importers import read
from trundle.importers.matfile import MatFile

NAMES = ["DATA_EMPS.mat", "DATA_EMPS_PULSES.mat"]
MAT_MAP = Path(__file__).parents[2] / "configs" / "import" / "mat.toml"


def write(folder: Path, **changes: Any) -> Path:
    t = np.arange(20) / 1000
    variables: dict[str, Any] = {"t": t, "qm": t**2, "qg": t**2, "vir": 1 + t, "gtau": 35.0} | changes
    for name in NAMES:
        scipy.io.savemat(folder / name, {key: np.atleast_2d(value).T for key, value in variables.items()})
    return folder


def test_the_data_set_becomes_a_rail_recording(tmp_path: Path) -> None:
    got = read(write(tmp_path), "emps")
    recording = trundle.Recording(got.metadata, got.episodes)
    assert recording.metadata["object"]["dof"] == ["x"]
    assert recording.metadata["split"]["held_out"] == ["episode_01"]
    table = recording.episodes["episode_00"]
    np.testing.assert_allclose(table["force_x"], 35.0 * (1 + table["t"]))


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    (write(tmp_path) / NAMES[1]).unlink()
    with pytest.raises(ValueError, match=r"DATA_EMPS_PULSES\.mat: no such file"):
        read(tmp_path, "emps")


def test_another_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(
        ValueError, match=r"`qm`, `vir` have 20, 20, 7 samples .* is this a file of the benchmark"
    ):
        read(write(tmp_path, vir=np.ones(7)), "emps")


def test_the_real_data_set(real_data: Callable[[str], Path]) -> None:
    source = real_data("emps")
    got = read(source, "emps")
    recording = trundle.Recording(got.metadata, got.episodes)
    for table in recording.episodes.values():
        assert len(table["t"]) == 24841
        assert np.ptp(table["object_x"]) == pytest.approx(0.2465, abs=2e-4)
    by_map = read(source / NAMES[0], "mat", MAT_MAP).episodes["episode_00"]
    for column, values in by_map.items():
        np.testing.assert_array_equal(values, recording.episodes["episode_00"][column])


def test_the_voltage_contains_the_pulses(real_data: Callable[[str], Path]) -> None:
    """At each edge the command jumps by 5 V, and the position loop settles 5 V / (kp kv) = 0.128 mm away."""
    plain, pulsed = (MatFile(real_data("emps") / name) for name in NAMES)
    pulses = pulsed.vector("pulses_N")
    edges = np.flatnonzero(np.diff(pulses))
    volts = pulsed.vector("vir")
    jumps = (volts[edges + 1] - volts[edges]) / np.diff(pulses)[edges]
    np.testing.assert_allclose(jumps, 1.0, atol=0.15)
    # The position has settled just before the next edge.
    moved = (pulsed.vector("qm") - plain.vector("qm"))[edges]
    settled = 5.0 / float(plain.vector("kp")[0] * plain.vector("kv")[0])
    np.testing.assert_allclose(np.median(moved[1::2]) - np.median(moved[::2]), settled, rtol=0.1)


def test_format_2_is_a_slide_with_a_published_gain(tmp_path: Path, imported: Import) -> None:
    got = imported(write(tmp_path), "emps", {"format": 2})
    check_joints(got)
    assert got.metadata["effort"] == {"source": "commanded", "gain": 35.0}
    table = got.episodes["episode_00"]
    np.testing.assert_allclose(table["effort_load"], 1 + table["t"])
    np.testing.assert_allclose(table["target_load"], table["q_load"])
    with pytest.raises(ValueError, match="`format` = 3; it is one of 1, 2"):
        imported(tmp_path, "emps", {"format": 3})


def test_the_real_effort_is_that_of_the_published_model(
    real_data: Callable[[str], Path], imported: Import
) -> None:
    got = imported(real_data("emps"), "emps", {"format": 2})
    check_joints(got)
    table = got.episodes["episode_00"]
    box = np.ones(101) / 101
    v = np.convolve(np.gradient(table["q_load"], 1e-3), box, "same")
    moving = np.abs(v) > 0.02
    force = got.metadata["effort"]["gain"] * np.convolve(table["effort_load"], box, "same")
    published = 95.11 * np.convolve(np.gradient(v, 1e-3), box, "same") + 203.5 * v + 20.39 * np.sign(v) - 3.16
    assert np.std((force - published)[moving]) < 0.2 * np.std(force[moving])
