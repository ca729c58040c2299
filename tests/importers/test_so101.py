"""Motions of the SO-101 arm: invented files of their layout, and the real data."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.importers.conftest import Import
from tests.importers.mechanisms import check_joints
from trundle.importers import read

NAMES = ["Rotation", "Pitch", "Jaw"]


def write(folder: Path, motion: str, seconds: float = 3.0) -> Path:
    place = folder / motion
    place.mkdir(parents=True)
    (place / "joint_list.txt").write_text("\n".join(NAMES) + "\n")
    state, control = ["type,timestamp,positions,velocities,torques"], ["type,timestamp,positions"]
    for k in range(round(seconds * 50)):
        t = k / 50
        state.append(f'STATE_MOTOR,{t * 1e6 + 5},"[{t}, {-t}, 0.5]","[1.0, -1.0, 0.0]","[0.0228, 0.0, 0.0]"')
        control.append(f'CONTROL,{t * 1e6 + 5},"[{t + 0.1}, {-t}, 0.5]"')
    (place / "state_motor.csv").write_text("\n".join(state) + "\n")
    (place / "control.csv").write_text("\n".join(control) + "\n")
    (place / "event.csv").write_text("type,timestamp,event\n")
    return folder


def test_one_joint_as_a_single_axis(tmp_path: Path, imported: Import) -> None:
    source = write(write(tmp_path / "so101", "swing"), "hold", 2.0)
    got = imported(source, "so101", {"joint": "Pitch", "piece": 1.0})
    check_joints(got)
    assert list(got.episodes) == ["hold_00", "hold_01", "swing_00", "swing_01", "swing_02"]
    assert got.metadata["split"]["held_out"] == ["swing_02"]
    assert got.metadata["mechanism"] == {"axis": "hinge", "gravity": True, "joints": ["Pitch"]}
    assert got.metadata["effort"]["signed"] is False
    table = got.episodes["swing_01"]
    np.testing.assert_allclose(table["q_Pitch"], -1.0 - table["t"], atol=0.021)
    np.testing.assert_allclose(table["q_Pitch"] - table["q_Pitch"][0], -table["t"], atol=1e-9)
    np.testing.assert_array_equal(table["v_Pitch"], -1.0)
    rotation = imported(source / "swing", "so101", {"joint": "Rotation"})
    check_joints(rotation)
    assert rotation.metadata["mechanism"]["gravity"] is False
    np.testing.assert_allclose(rotation.episodes["swing_00"]["target_Rotation"][0], 0.1)


def test_several_joints_with_a_model(tmp_path: Path, imported: Import) -> None:
    source = write(tmp_path / "so101", "swing")
    (tmp_path / "arm.xml").write_text("<mujoco/>")
    recording = {"mechanism": {"model": "arm.xml"}, "target": {"limit": 2.9}}
    got = imported(source, "so101", {"recording": recording, "joints": {"lift": "Pitch", "gripper": "Jaw"}})
    check_joints(got)
    assert got.files == {"arm.xml": "<mujoco/>"}
    assert got.metadata["target"] == {"stiffness": "free", "damping": "free", "limit": 2.9}
    # The opening 1 of the jaw is 1523 steps of the servo's encoder.
    assert got.metadata["noise"]["position_step"] == pytest.approx(2 * np.pi / 4096)
    np.testing.assert_allclose(got.episodes["swing_00"]["q_gripper"], 0.5 * 1523 * 2 * np.pi / 4096)
    check_joints(imported(source, "so101", {"recording": recording}))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({}, r"3 joints need a model.*or import a single axis with `joint` = \"Pitch\""),
        ({"joint": "Elbow"}, r"`joint`: no joint 'Elbow'; the joints are Rotation, Pitch, Jaw"),
        ({"joint": "Jaw", "joints": ["Jaw"]}, "give either `joint`, a single axis, or `joints`"),
        ({"joint": "Jaw", "motions": ["jump"]}, "no motion 'jump'; the motions are swing"),
        ({"joint": "Jaw", "piece": 0.0}, r"`piece` = 0\.0: must be at least 0\.5 s"),
        ({"joint": "Jaw", "recording": {"mechanism": 1}}, "`recording.mechanism` = 1: it is a table"),
    ],
)
def test_an_invalid_map_is_named(
    tmp_path: Path, imported: Import, change: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        imported(write(tmp_path / "so101", "swing"), "so101", change)


def test_damaged_motions_are_refused(tmp_path: Path, imported: Import) -> None:
    source = write(tmp_path / "so101", "swing")
    state = source / "swing" / "state_motor.csv"
    whole = state.read_text()
    state.write_text(whole[:-30])
    with pytest.raises(ValueError, match=r"state_motor\.csv: row 150"):
        imported(source, "so101", {"joint": "Pitch"})
    state.write_text(whole)
    (source / "swing" / "joint_list.txt").write_text("Rotation Pitch Pitch")
    with pytest.raises(ValueError, match=r"joint_list\.txt: must contain the name of each joint once"):
        imported(source, "so101", {"joint": "Pitch"})
    (source / "swing" / "joint_list.txt").write_text("Rotation Pitch")
    with pytest.raises(ValueError, match=r"row 1, column 'positions': a list of 3 values"):
        imported(source, "so101", {"joint": "Pitch"})
    (source / "swing" / "control.csv").unlink()
    (source / "swing" / "joint_list.txt").write_text("\n".join(NAMES))
    with pytest.raises(ValueError, match=r"no file 'swing/control\.csv'"):
        imported(source, "so101", {"joint": "Pitch"})
    with pytest.raises(ValueError, match="no folder with joint_list"):
        read(tmp_path, "so101")


@pytest.mark.parametrize("joint", ["Rotation", "Jaw"])
def test_the_real_motions(real_data: Callable[[str], Path], imported: Import, joint: str) -> None:
    """The measured position follows the commanded one, and the velocity is that of the position, late."""
    got = imported(real_data("so101"), "so101", {"joint": joint, "motions": ["chirp_sweep"]})
    check_joints(got)
    assert len(got.episodes) == 6
    table = got.episodes["chirp_sweep_03"]
    q, v = table[f"q_{joint}"], table[f"v_{joint}"]
    assert np.corrcoef(q, table[f"target_{joint}"])[0, 1] > 0.85
    difference = np.gradient(q, table["t"])
    lags = [np.corrcoef(difference[5:-5], np.roll(v, -k)[5:-5])[0, 1] for k in range(4)]
    assert int(np.argmax(lags)) == 1 and lags[1] > 0.8
    assert np.sum(np.abs(v)) == pytest.approx(np.sum(np.abs(difference)), rel=0.1)
    assert np.min(table[f"effort_{joint}"]) >= 0.0
