"""Free pendulums: invented files of their layout, and the real data."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import scipy.io

from tests.importers.conftest import Import
from tests.importers.mechanisms import check_joints
from trundle.importers import read

T = np.arange(100) * 1e-3


def cell(*values: Any) -> Any:
    found = np.empty((len(values), 1), dtype=object)
    for k, value in enumerate(values):
        found[k, 0] = value
    return found


def write(path: Path, links: int = 2, times: Any = T[:, None], **changes: Any) -> Path:
    """Write two training pieces and one for validation, the links at ±0.1 rad from hanging down."""
    angles = np.vstack([np.pi + 0.1 * np.cos(9 * T), np.pi - 0.1 + 0 * T])[:links]
    piece = np.vstack([angles, 0 * angles])
    variables = {
        "Y_id": cell(piece, piece),
        "Y_vad": cell(piece),
        "Time_id": cell(times, times + 1.0),
        "Time_vad": cell(times + 2.0),
        "dt": 1e-3,
    }
    scipy.io.savemat(path, variables | changes)
    return path


def test_one_link_is_a_hinge_without_effort(tmp_path: Path) -> None:
    got = read(write(tmp_path / "single.mat", links=1), "pendulum")
    check_joints(got)
    assert list(got.episodes) == ["piece_00", "piece_01", "piece_02"]
    assert got.metadata["split"]["held_out"] == ["piece_02"]
    assert got.metadata["mechanism"] == {"axis": "hinge", "joints": ["arm"], "gravity": True}
    for table in got.episodes.values():
        np.testing.assert_allclose(table["t"], T, atol=1e-9)
        np.testing.assert_allclose(table["q_arm"], 0.1 * np.cos(9 * T), atol=1e-12)


def test_two_links_have_relative_angles_and_a_model(tmp_path: Path, imported: Import) -> None:
    got = read(write(tmp_path / "double.mat"), "pendulum")
    check_joints(got)
    table = got.episodes["piece_00"]
    np.testing.assert_allclose(table["q_upper"], 0.1 * np.cos(9 * T), atol=1e-12)
    np.testing.assert_allclose(table["q_upper"] + table["q_lower"], -0.1, atol=1e-12)
    model = mujoco.MjModel.from_xml_string(got.files["double_pendulum.xml"])
    assert [model.joint(k).name for k in range(2)] == got.metadata["mechanism"]["joints"]
    (tmp_path / "own.xml").write_text("<mujoco/>")
    settings = {"name": "mine", "recording": {"mechanism": {"model": "own.xml"}}}
    other = imported(tmp_path / "double.mat", "pendulum", settings)
    check_joints(other)
    assert list(other.files) == ["own.xml"] and other.metadata["name"] == "mine"


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"Y_vad": np.ones((2, 3))}, r"variable `Y_vad` is not a cell array of matrices"),
        ({"Time_vad": cell(T, T)}, r"`Y_vad` has 1 pieces and `Time_vad` 2 times"),
        ({"Time_vad": cell(T[:9])}, r"`Y_vad\{1\}` of the shape \(4, 100\) with 9 times: must have 2 rows"),
        ({"Y_vad": cell(np.ones((3, 100)))}, r"`Y_vad\{1\}` of the shape \(3, 100\)"),
        ({"Y_vad": cell(np.ones((2, 100)))}, "pieces of one link and of two"),
        (
            {"Y_vad": cell(np.full((4, 100), np.nan))},
            r"`Y_vad\{1\}`, column 1: an angle or a time is not a number",
        ),
        ({"Time_vad": cell(T[::-1])}, r"`Y_vad\{1\}`, column 2: time 0\.098 s is not after the one before"),
    ],
)
def test_other_files_are_refused(tmp_path: Path, changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=r"double\.mat: " + message):
        read(write(tmp_path / "double.mat", **changes), "pendulum")


def test_a_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"is a folder; give single\.mat or double\.mat"):
        read(tmp_path, "pendulum")


def test_the_real_single_pendulum_falls_towards_zero(real_data: Callable[[str], Path]) -> None:
    got = read(real_data("pendulum") / "single.mat", "pendulum")
    check_joints(got)
    amplitudes = [float(np.ptp(table["q_arm"])) for table in got.episodes.values()]
    assert np.all(np.diff(amplitudes) < 0.0) and len(amplitudes) == 6
    table = got.episodes["piece_00"]
    smooth = np.convolve(table["q_arm"], np.ones(20) / 20, "valid")
    acceleration = np.diff(smooth, 2) / 1e-6
    frequency = -np.polyfit(np.sin(smooth[1:-1]), np.convolve(acceleration, np.ones(20) / 20, "same"), 1)[0]
    published = 0.1476 * 9.81 * 0.1478 / (0.1476 * 0.1478**2 + 1.09e-4)
    assert frequency == pytest.approx(published, rel=0.02)


def test_the_model_reproduces_the_real_double_pendulum(real_data: Callable[[str], Path]) -> None:
    got = read(real_data("pendulum") / "double.mat", "pendulum")
    check_joints(got)
    assert len(got.episodes) == 30
    model = mujoco.MjModel.from_xml_string(got.files["double_pendulum.xml"])
    model.opt.timestep = 1e-3
    for name, tolerance in (("piece_00", 0.05), ("piece_15", 0.01)):
        q = np.column_stack([got.episodes[name][f"q_{joint}"] for joint in ("upper", "lower")])
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = q[20], (q[40] - q[0]) / 0.04
        simulated = []
        for _ in range(500):
            simulated.append(data.qpos.copy())
            mujoco.mj_step(model, data)
        assert np.max(np.sqrt(np.mean((np.array(simulated) - q[20:520]) ** 2, axis=0))) < tolerance
