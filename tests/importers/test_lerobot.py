"""LeRobot data sets, written in their layout."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

from tests.importers.conftest import Import
from tests.importers.mechanisms import check_joints

NAMES = ["pan.pos", "lift.pos", "gripper.pos"]
SETTINGS: dict[str, Any] = {
    "joints": {"lift": "lift.pos", "gripper": "gripper.pos"},
    "angle": {"lift": "degrees"},
    "recording": {"mechanism": {"model": "robot.xml"}},
}
Change = Callable[[dict[str, Any]], None]


def write(folder: Path, change: Change = lambda _: None, **info: Any) -> Path:
    """Write two files with two episodes of ten frames each, the gripper in percent."""
    for file in range(2):
        number = np.repeat([2 * file, 2 * file + 1], 10)
        frame = np.tile(np.arange(10), 2)
        state = np.column_stack([0 * frame, 10 * frame + number, 100 - frame]).astype(np.float32)
        table = {
            "observation.state": state.tolist(),
            "action": (state + 1).tolist(),
            "timestamp": (frame / 30).astype(np.float32).tolist(),
            "frame_index": frame.tolist(),
            "episode_index": number.tolist(),
        }
        change(table)
        path = folder / "data" / "chunk-000" / f"file-{file:03d}.parquet"
        path.parent.mkdir(parents=True, exist_ok=True)
        parquet.write_table(pyarrow.table(table), path)
    (folder / "meta").mkdir()
    feature = {"dtype": "float32", "shape": [3], "names": NAMES}
    content = {
        "codebase_version": "v3.0",
        "fps": 30,
        "features": {"observation.state": feature, "action": feature},
    }
    (folder / "meta" / "info.json").write_text(json.dumps(content | info))
    return folder


@pytest.fixture(autouse=True)
def model(tmp_path: Path) -> None:
    (tmp_path / "robot.xml").write_text("<mujoco/>")


def test_states_and_actions_of_chosen_joints(imported: Import, tmp_path: Path) -> None:
    got = imported(write(tmp_path / "set"), "lerobot", SETTINGS)
    check_joints(got)
    assert list(got.episodes) == [f"episode_{k:06}" for k in range(4)]
    table = got.episodes["episode_000003"]
    assert list(table) == ["t", "q_lift", "q_gripper", "target_lift", "target_gripper"]
    np.testing.assert_allclose(table["t"], np.arange(10) / 30, atol=1e-7)
    np.testing.assert_allclose(table["q_lift"], np.radians(10 * np.arange(10) + 3), rtol=1e-6)
    np.testing.assert_allclose(table["target_lift"], np.radians(10 * np.arange(10) + 4), rtol=1e-6)
    np.testing.assert_allclose(table["q_gripper"], 100 - np.arange(10))
    assert "fps = 30" in got.metadata["notes"]["times"]


def test_chosen_episodes_without_actions(imported: Import, tmp_path: Path) -> None:
    settings = {
        "joints": ["lift.pos"],
        "angle": "degrees",
        "episodes": [1, 2],
        "target": False,
        "recording": {"mechanism": {"axis": "hinge"}},
    }
    names = {"dtype": "float32", "names": {"motors": NAMES}}
    got = imported(write(tmp_path / "set", features={"observation.state": names}), "lerobot", settings)
    check_joints(got)
    assert list(got.episodes) == ["episode_000001", "episode_000002"]
    assert list(got.episodes["episode_000001"]) == ["t", "q_lift.pos"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"joints": ["knee"], "angle": "degrees"},
            r"`joints`: no joint 'knee'; the joints are pan\.pos, lift\.pos, gripper\.pos",
        ),
        ({"angle": None}, r"`angle` is missing: \"degrees\" or \"radians\""),
        ({"episodes": [9]}, r"no episode of `episodes` = \[9\]"),
        ({"recording": {}}, r"`recording\.mechanism\.model` is missing"),
    ],
)
def test_an_invalid_map_is_named(
    imported: Import, tmp_path: Path, change: dict[str, Any], message: str
) -> None:
    settings = {key: value for key, value in (SETTINGS | change).items() if value is not None}
    with pytest.raises(ValueError, match=message):
        imported(write(tmp_path / "set"), "lerobot", settings)


def test_radians_are_kept(imported: Import, tmp_path: Path) -> None:
    got = imported(write(tmp_path / "set"), "lerobot", SETTINGS | {"angle": {"lift": "radians"}})
    assert np.max(got.episodes["episode_000000"]["q_lift"]) == 90.0


def shorten(table: dict[str, Any]) -> None:
    table["observation.state"][4] = [1.0, 2.0]


def void(table: dict[str, Any]) -> None:
    table["action"][2] = [1.0, None, 2.0]


def rewind(table: dict[str, Any]) -> None:
    table["timestamp"][13] = 0.0


def forget(table: dict[str, Any]) -> None:
    del table["timestamp"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (shorten, r"file-000\.parquet: row 5, column 'observation\.state': \[1\.0, 2\.0\] must be 3 numbers"),
        (void, r"row 3, column 'action': \[1\.0, None, 2\.0\] must be 3 numbers, as in meta/info\.json"),
        (rewind, r"row 14, column 'timestamp': 0 s is not after the row before in episode_000001"),
        (forget, r"no column 'timestamp'; the columns are observation\.state, action"),
    ],
)
def test_an_invalid_row_is_named(imported: Import, tmp_path: Path, change: Change, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        imported(write(tmp_path / "set", change), "lerobot", SETTINGS)


@pytest.mark.parametrize(
    ("info", "message"),
    [
        ({"codebase_version": "v1.6"}, r"codebase_version = 'v1\.6': only versions 2 and 3"),
        ({"features": 3}, "no table `features`"),
        ({"features": {"action": {"names": NAMES}}}, r"no feature 'observation\.state'"),
        ({"features": {"observation.state": {"names": None}}}, r"features\.observation\.state\.names = None"),
        (
            {"features": {"observation.state": {"names": NAMES[:2]}}},
            r"no joint 'gripper\.pos'|must be 2 numbers",
        ),
    ],
)
def test_an_invalid_description_is_named(
    imported: Import, tmp_path: Path, info: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        imported(write(tmp_path / "set", **info), "lerobot", SETTINGS)


def test_missing_and_truncated_files_are_named(imported: Import, tmp_path: Path) -> None:
    source = write(tmp_path / "set")
    table = source / "data" / "chunk-000" / "file-001.parquet"
    whole = table.read_bytes()
    table.write_bytes(whole[:-100])
    with pytest.raises(
        ValueError, match=r"file-001\.parquet: not a readable Parquet file .* download it again"
    ):
        imported(source, "lerobot", SETTINGS)
    table.unlink()
    (source / "data" / "chunk-000" / "file-000.parquet").unlink()
    with pytest.raises(
        ValueError, match=r"no data/chunk-\*/file-\*\.parquet; download the data set completely"
    ):
        imported(source, "lerobot", SETTINGS)
    (source / "meta" / "info.json").write_text("{")
    with pytest.raises(ValueError, match=r"info\.json: not valid JSON"):
        imported(source, "lerobot", SETTINGS)
    (source / "meta" / "info.json").unlink()
    with pytest.raises(ValueError, match=r"info\.json: no such file; give the folder of a LeRobot data set"):
        imported(source, "lerobot", SETTINGS)
