"""CSV files through a column map."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trundle
from trundle.importers import Imported, read

Import = Callable[[Path, str, dict[str, Any]], Imported]
EXAMPLE = Path(__file__).parents[2] / "configs" / "import" / "csv.toml"
HEADER = "stamp_ms;cart_x;cart_y;cart_yaw;hand_x;hand_y;hand_yaw;fx;fy;tz"
PLAIN: dict[str, Any] = {
    "time": "t",
    "columns": {
        name: name for name in ("object_x", "object_y", "object_theta", "force_x", "force_y", "torque_z")
    },
}


def write_log(path: Path, start_ms: int) -> Path:
    """Write a log at 100 Hz with a tracker at 50 Hz, so that every pose is repeated."""
    rows = [HEADER]
    for k in range(100):
        seen = 2 * (k // 2)
        pose = f"{10 * seen};{-5 * seen};{90 + seen};{10 * seen + 200};0;{seen}"
        rows.append(f"{start_ms + 10 * k};{pose};{k / 10};{k / 5};{1000 + k}")
    path.write_text("\n".join(rows) + "\n")
    return path


def write_plain(path: Path, *rows: str) -> Path:
    header = "t,object_x,object_y,object_theta,force_x,force_y,torque_z"
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


def test_the_example_map_converts_a_folder_of_logs(tmp_path: Path) -> None:
    (tmp_path / "logs").mkdir()
    write_log(tmp_path / "logs" / "b.csv", 1_750_000_000_000)
    write_log(tmp_path / "logs" / "a.csv", 5)
    got = read(tmp_path / "logs", "csv", EXAMPLE)
    recording = trundle.Recording(got.metadata, got.episodes)
    assert recording.name == "hospital cart"
    assert list(recording.episodes) == ["episode_00", "episode_01"]
    late = recording.episodes["episode_01"]
    np.testing.assert_allclose(late["t"], np.arange(100) / 100, atol=1e-6)
    seen = np.arange(0, 100, 2)
    for name, values in {
        "object_x": seen / 100,
        "object_y": -seen / 200,
        "object_theta": np.radians(90 + seen),
        "gripper_x": seen / 100 + 0.2,
    }.items():
        column = late[name][~np.isnan(late[name])]
        if name == "object_theta":
            column = np.unwrap(column)
        np.testing.assert_allclose(column, values, atol=1e-9, err_msg=name)
    np.testing.assert_allclose(late["force_x"], np.arange(100) / 10)
    np.testing.assert_allclose(late["force_y"], -np.arange(100) / 5)
    np.testing.assert_allclose(late["torque_z"], 1 + np.arange(100) / 1000)
    assert "a.csv: object: 50 samples repeated omitted" in got.remarks


def test_an_empty_cell_is_a_missing_sample(imported: Import, tmp_path: Path) -> None:
    file = write_plain(tmp_path / "log.csv", "0,1,2,0,3,4,5", "0.1,,,,6,7,8", "0.2,1.5,2,0,,,")
    table = imported(file, "csv", PLAIN).episodes["episode_00"]
    np.testing.assert_array_equal(table["object_x"], [1.0, np.nan, 1.5])
    np.testing.assert_array_equal(table["force_x"], [3.0, 6.0, np.nan])


def test_streams_may_have_separate_clocks(imported: Import, tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    file.write_text("tp,x,tf,f\n10.0,0.1,10.5,1\n10.2,0.3,10.7,2\n")
    settings = {
        "times": {"object": "tp", "wrench": "tf"},
        "columns": {"object_x": "x", "force_x": "f"},
        "recording": {"object": {"dof": ["x"]}},
    }
    table = imported(file, "csv", settings).episodes["episode_00"]
    np.testing.assert_allclose(table["t"], [0.0, 0.2, 0.5, 0.7])
    np.testing.assert_array_equal(table["object_x"], [0.1, 0.3, np.nan, np.nan])


def test_columns_without_a_header_are_numbered(imported: Import, tmp_path: Path) -> None:
    file = tmp_path / "log.txt"
    file.write_text("# two lines\n# of prose\n0.0\t0.5\t7\n0.1\t0.6\t8\n")
    settings = {
        "delimiter": "\t",
        "header": False,
        "skip_rows": 2,
        "time": "1",
        "columns": {"object_x": "2", "force_x": "3"},
    }
    table = imported(file, "csv", settings).episodes["episode_00"]
    np.testing.assert_array_equal(table["force_x"], [7.0, 8.0])


def test_a_y_up_tracker(imported: Import, tmp_path: Path) -> None:
    """z and x of the tracker are the floor axes; a rotation about its y is the heading."""
    parts = ("x", "y", "z", "qw", "qx", "qy", "qz")
    half = np.radians(15.0)
    file = tmp_path / "log.csv"
    file.write_text(
        "t," + ",".join(parts) + ",fx,fy,tz\n"
        f"0,1,2,3,{np.cos(half)},0,{np.sin(half)},0,1,2,3\n0.1,1,2,4,{np.cos(half)},0,{np.sin(half)},0,1,2,3\n"
    )
    settings = {
        "time": "t",
        "world": {"plane": ["z", "x"]},
        # The tracked body also has y up, so its axes are exchanged in the same way.
        "object": {"offset": {"quaternion_wxyz": [0.5, -0.5, -0.5, -0.5]}},
        "columns": {f"object_{p}": p for p in parts} | {"force_x": "fx", "force_y": "fy", "torque_z": "tz"},
    }
    table = imported(file, "csv", settings).episodes["episode_00"]
    np.testing.assert_allclose(table["object_x"], [3.0, 4.0])
    np.testing.assert_allclose(table["object_y"], [1.0, 1.0])
    np.testing.assert_allclose(table["object_theta"], np.radians(30.0))


def test_files_of_spreadsheets(imported: Import, tmp_path: Path) -> None:
    """A byte-order mark, quotes, line ends of Windows, empty lines, spaces, a delimiter at the end."""
    file = tmp_path / "log.csv"
    header = '"t", object_x ,"object_y",object_theta,force_x,force_y,torque_z'
    rows = [header, '0, 1,"2",0,3,4,5,', "", "0.1,1.5,2,0,,,", ""]
    file.write_bytes(b"\xef\xbb\xbf" + "\r\n".join(rows).encode())
    table = imported(file, "csv", PLAIN).episodes["episode_00"]
    np.testing.assert_array_equal(table["object_x"], [1.0, 1.5])
    np.testing.assert_array_equal(table["torque_z"], [5.0, np.nan])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", r"log\.csv: is empty; it must have a header"),
        (b"t,x,t\n1,2,3\n", r"log\.csv: has two columns 't'; rename one of them in the header"),
        (b"t,x\n1,\xff\n", r"log\.csv: cannot be read with encoding utf-8, delimiter ','"),
    ],
)
def test_a_file_that_is_not_a_table_is_refused(
    imported: Import, tmp_path: Path, content: bytes, message: str
) -> None:
    (tmp_path / "log.csv").write_bytes(content)
    with pytest.raises(ValueError, match=message):
        imported(tmp_path / "log.csv", "csv", PLAIN)


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("0.1,1,2,oops,3,4,5", r"log\.csv: row 2, column 'object_theta': 'oops' is not a number"),
        ("0.1,1,2,1_0,3,4,5", r"log\.csv: row 2, column 'object_theta': '1_0' is not a number"),
        ("0.1,1,2,0,3,4,5,6", r"log\.csv: row 2 has 8 cells and the header 7"),
        ("0.1,1,,0,3,4,5", r"log\.csv: row 2: object_y is empty but other columns of object are not"),
    ],
)
def test_an_invalid_cell_is_named(imported: Import, tmp_path: Path, row: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        imported(write_plain(tmp_path / "log.csv", "0,1,2,0,3,4,5", row), "csv", PLAIN)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"columns": {"object_x": "nowhere"}}, r"no column 'nowhere'; the columns are 't', 'object_x'"),
        ({"columns": {"velocity_x": "t"}}, "`columns.velocity_x`: unknown column"),
        (
            {"columns": {"object_x": {"name": "object_x", "unit": "deg"}}},
            "unknown unit; use one of 'm', 'cm', 'mm', 'um'",
        ),
        (
            {"columns": {"object_x": {"unit": "mm"}}},
            "`columns.object_x`: give one of `name`, `product` and `sum`",
        ),
        (
            {"columns": {"object_x": {"name": "t", "units": "mm"}}},
            "`columns.object_x.units`; did you mean",
        ),
        ({"columns": {"object_x": 3}}, "`columns.object_x` = 3; it is a string or a table"),
        (
            {"columns": {"object_x": "t", "object_y": "t"}},
            "a pose needs object_x, object_y and either",
        ),
        ({"columns": {}}, "`columns` is empty"),
        ({"times": {"sensor": "t"}}, "`times` = 'sensor'; it is one of 'object', 'gripper', 'wrench'"),
        ({"delimiter": ";"}, "no column 't'"),
        ({"delimiter": ", "}, "`delimiter` = ', ': must be one character"),
    ],
)
def test_an_invalid_map_is_named(
    imported: Import, tmp_path: Path, change: dict[str, Any], message: str
) -> None:
    file = write_plain(tmp_path / "log.csv", "0,1,2,0,3,4,5")
    with pytest.raises(ValueError, match=message):
        imported(file, "csv", PLAIN | change)


def test_a_missing_time_column_is_refused(imported: Import, tmp_path: Path) -> None:
    file = write_plain(tmp_path / "log.csv", "0,1,2,0,3,4,5")
    with pytest.raises(ValueError, match=r"no time for object; set `time` or `times\.object`"):
        imported(file, "csv", {"columns": PLAIN["columns"]})


def test_an_empty_folder_is_refused(imported: Import, tmp_path: Path) -> None:
    (tmp_path / "none").mkdir()
    with pytest.raises(ValueError, match=r"none: no \*\.csv in this folder"):
        imported(tmp_path / "none", "csv", PLAIN)
