"""CSV files of joints with a map."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.importers.conftest import Import
from tests.importers.mechanisms import check_joints

SLIDE = {"mechanism": {"axis": "slide"}}
MODEL = '<mujoco><worldbody><body><joint name="a"/><joint name="b"/></body></worldbody></mujoco>'
LISTS: dict[str, Any] = {
    "joints": ["b", "a"],
    "skip_rows": 2,
    "time": {"name": "stamp", "unit": "us"},
    "lists": {"q": "positions", "effort": {"name": "torques", "scale": -1.0}},
    "order": ["a", "other", "b"],
    "recording": {"mechanism": {"model": "robot.xml"}},
}
"""Map of `lists`."""


def lists(path: Path, *rows: str) -> Path:
    """Write two lines of a preamble, a header and rows."""
    rows = rows or tuple(f'{k}00,"[{k}.5, 9, -{k}]","[1.0, 2.0, {k}]"' for k in range(3))
    path.write_text("robot 7\n\nstamp,positions,torques\n" + "\n".join(rows) + "\n")
    return path


@pytest.fixture
def model(tmp_path: Path) -> Path:
    (tmp_path / "robot.xml").write_text(MODEL)
    return tmp_path / "robot.xml"


def test_columns_of_lists_in_another_order(imported: Import, tmp_path: Path, model: Path) -> None:
    got = imported(lists(tmp_path / "log.csv"), "csv", LISTS)
    check_joints(got)
    table = got.episodes["episode_00"]
    assert list(table) == ["t", "q_b", "q_a", "effort_b", "effort_a"]
    np.testing.assert_allclose(table["t"], [0.0, 1e-4, 2e-4])
    np.testing.assert_array_equal(table["q_a"], [0.5, 1.5, 2.5])
    np.testing.assert_array_equal(table["q_b"], [0.0, -1.0, -2.0])
    np.testing.assert_array_equal(table["effort_b"], [0.0, -1.0, -2.0])
    assert got.metadata["mechanism"] == {"model": "robot.xml", "joints": ["b", "a"]}
    assert got.files == {"robot.xml": MODEL}


@pytest.mark.parametrize("cell", ["(0.5 9 -1)", "0.5; 9; -1", "[0.5,9,-1]", "{0.5,  9 , -1}"])
def test_spellings_of_lists(imported: Import, tmp_path: Path, model: Path, cell: str) -> None:
    file = lists(tmp_path / "log.csv", f'0,"{cell}",', '1,"[1, 1, 1]","[1,2,3]"', '2,"[1, 1, 1]","[1,2,3]"')
    table = imported(file, "csv", LISTS).episodes["episode_00"]
    assert (table["q_a"][0], table["q_b"][0]) == (0.5, -1.0)
    assert np.isnan(table["effort_a"][0]) and table["effort_a"][1] == -1.0


def test_files_of_an_episode_with_different_rates(imported: Import, tmp_path: Path) -> None:
    """Subfolders are episodes; commands come from a slower file, and the last one before the start holds."""
    for k, name in enumerate(("fast", "slow")):
        folder = tmp_path / "runs" / name
        folder.mkdir(parents=True)
        rows = "".join(f"{100 + k + i * 0.01},{i}\n" for i in range(11))
        (folder / "state.csv").write_text(f"t,x\n{rows}")
        (folder / "command.txt").write_text(f"sec;u;f\n{99.5 + k};1,5;0\n{100.055 + k};2,5;7\n")
    settings: dict[str, Any] = {
        "joints": ["rail"],
        "file": [
            {"path": "*/state.csv", "time": "t", "columns": {"q_rail": {"name": "x", "unit": "mm"}}},
            {
                "path": "*/command.txt",
                "time": "sec",
                "delimiter": ";",
                "decimal": ",",
                "columns": {"target_rail": {"name": "u", "unit": "cm"}, "effort_rail": "f"},
            },
        ],
        "recording": {**SLIDE, "split": {"held_out": ["slow"]}, "effort": {"source": "measured"}},
    }
    with pytest.raises(ValueError, match=r"command\.txt: row 1, column 'sec': '99\.5' is not a number"):
        imported(tmp_path / "runs", "csv", settings)
    for name in ("fast", "slow"):
        file = tmp_path / "runs" / name / "command.txt"
        file.write_text(file.read_text().replace(".", ","))
    got = imported(tmp_path / "runs", "csv", settings)
    check_joints(got)
    assert list(got.episodes) == ["fast", "slow"]
    table = got.episodes["slow"]
    assert len(table["t"]) == 12
    np.testing.assert_allclose(table["q_rail"][[0, 1]], [0.0, 0.001])
    there = np.isfinite(table["target_rail"])
    np.testing.assert_allclose(table["t"][there], [0.0, 0.055])
    np.testing.assert_allclose(table["target_rail"][there], [0.015, 0.025])
    assert "slow: effort_rail: 1 samples outside the interval of all positions omitted" in got.remarks
    assert np.sum(np.isfinite(table["effort_rail"])) == 1
    settings["recording"]["effort"]["source"] = {"rail": "commanded"}
    effort = imported(tmp_path / "runs", "csv", settings).episodes["slow"]["effort_rail"]
    np.testing.assert_array_equal(effort[np.isfinite(effort)], [0.0, 7.0])


def test_a_missing_file_of_an_episode_is_named(imported: Import, tmp_path: Path) -> None:
    for name in ("a_state.csv", "a_command.csv", "b_state.csv"):
        (tmp_path / name).write_text("t,x\n0,1\n1,2\n")
    files = [
        {"path": f"*_{kind}.csv", "time": "t", "columns": {column: "x"}}
        for kind, column in (("state", "q_rail"), ("command", "target_rail"))
    ]
    settings = {"joints": ["rail"], "file": files, "recording": SLIDE}
    with pytest.raises(ValueError, match=r"b_command\.csv: no such file, which episode 'b' needs"):
        imported(tmp_path, "csv", settings)
    with pytest.raises(ValueError, match="is a file; give the folder"):
        imported(tmp_path / "a_state.csv", "csv", settings)
    files[0]["path"] = "*_pose.csv"
    with pytest.raises(ValueError, match=r"no file '\*_pose\.csv'; correct `path`"):
        imported(tmp_path, "csv", settings)


def test_a_column_divides_a_file_into_episodes(imported: Import, tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    file.write_text("t,run,x\n0,7,0.1\n0.1,7,0.2\n0,8,0.3\n0.1,8,0.4\n0.2,8,0.5\n")
    settings = {"joints": ["j"], "time": "t", "columns": {"q_j": "x"}, "recording": SLIDE}
    with pytest.raises(
        ValueError, match=r"row 3: time 0 s is before that of row 2 \(0\.1 s\).*`episode_column`"
    ):
        imported(file, "csv", settings)
    got = imported(file, "csv", {**settings, "episode_column": "run"})
    check_joints(got)
    assert {name: list(table["q_j"]) for name, table in got.episodes.items()} == {
        "7": [0.1, 0.2],
        "8": [0.3, 0.4, 0.5],
    }


def test_files_are_episodes_and_can_be_cut(imported: Import, tmp_path: Path) -> None:
    for name in ("up", "down"):
        (tmp_path / f"{name}.csv").write_text("t,x,u\n0,0,1\n1,1,\n2,2,3\n3,3,\n")
    columns = {"q_j": "x", "target_j": "u"}
    settings = {"joints": ["j"], "time": "t", "columns": columns, "recording": SLIDE}
    assert list(imported(tmp_path, "csv", settings).episodes) == ["down", "up"]
    cut = [{"name": "late", "source": "up", "start": 1.0}]
    got = imported(tmp_path, "csv", {**settings, "episode": cut})
    check_joints(got)
    np.testing.assert_array_equal(got.episodes["late"]["q_j"], [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(got.episodes["late"]["target_j"], [1.0, 3.0, np.nan])


def test_degrees(imported: Import, tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    file.write_text("t,x,v,f\n0,90,1,5\n1,180,-2,6\n")
    settings: dict[str, Any] = {
        "joints": ["j"],
        "time": "t",
        "columns": {"q_j": "x", "v_j": "v", "effort_j": "f"},
        "recording": {"mechanism": {"axis": "hinge"}},
    }
    with pytest.raises(ValueError, match=r'row 1: q_j = 90 is more than 2 turns .* set `angle` = "degrees"'):
        imported(file, "csv", settings)
    table = imported(file, "csv", {**settings, "angle": "degrees"}).episodes["episode_00"]
    np.testing.assert_allclose(table["q_j"], [np.pi / 2, np.pi])
    np.testing.assert_allclose(table["v_j"], np.radians([1.0, -2.0]))
    np.testing.assert_array_equal(table["effort_j"], [5.0, 6.0])
    table = imported(file, "csv", {**settings, "angle": {"j": "radians"}}).episodes["episode_00"]
    np.testing.assert_array_equal(table["q_j"], [90.0, 180.0])
    settings["columns"]["q_j"] = {"name": "x", "unit": "deg"}
    table = imported(file, "csv", settings).episodes["episode_00"]
    np.testing.assert_allclose(table["q_j"], [np.pi / 2, np.pi])


@pytest.mark.parametrize(
    ("row", "message"),
    [
        (
            '300,"[1, 2]","[1,2,3]"',
            r"row 4, column 'positions': a list of 2 values, but `order` .* has 3: a, other, b",
        ),
        ('300,"[1, 2, x]","[1,2,3]"', r"row 4, column 'positions': '\[1, 2, x\]' is not a list of numbers"),
        ('150,"[1, 2, 3]","[1,2,3]"', r"row 4: time 0\.00015 s is before that of row 3 \(0\.0002 s\)"),
        ('300,"[1, 2, 3"', r"row 4 has 2 cells and the header 3"),
        ('x,"[1, 2, 3]","[1,2,3]"', r"row 4, column 'stamp': 'x' is not a number"),
    ],
)
def test_an_invalid_row_is_named(
    imported: Import, tmp_path: Path, model: Path, row: str, message: str
) -> None:
    rows = [f'{k}00,"[{k}.5, 9, -{k}]","[1.0, 2.0, {k}]"' for k in range(3)]
    with pytest.raises(ValueError, match=r"log\.csv: " + message):
        imported(lists(tmp_path / "log.csv", *rows, row), "csv", LISTS)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"joints": []}, "`joints` is empty"),
        ({"joints": ["a", "a"]}, "'a' occurs twice"),
        ({"joints": {"x": "a", "y": "a"}}, "'a' occurs twice; names in the log must be unique"),
        ({"joints": ["a", "wrist"]}, "`joints`: 'wrist' is not in `order`; the joints are a, other, b"),
        ({"columns": {"q_wrist": "t"}}, "`columns.q_wrist`: unknown joint 'wrist'; the joints are b, a"),
        (
            {"columns": {"qq_a": "t"}},
            "unknown column; the columns of joints are q_JOINT, v_JOINT, effort_JOINT",
        ),
        ({"columns": {"effort_a": "stamp"}}, "effort_a is mapped twice"),
        ({"angle": "gradians"}, "`angle` = 'gradians'"),
        ({"angle": {"wrist": "degrees"}}, "`angle.wrist`: unknown joint; the joints are b, a"),
        ({"lists": {"p": "positions"}}, "`lists` = 'p'; it is one of 'q', 'v'"),
        ({"lists": {"q": {"name": "positions", "unit": "Nm"}}}, "`lists.q.unit` = 'Nm': unknown unit"),
        ({"lists": {"q": {"name": "positions", "index": 1}}}, "`lists.q`: give only `name`, `unit`"),
        ({"lists": {"effort": "torques"}}, "no position of joint 'b'; map q_b, or remove it from `joints`"),
        ({"lists": {}}, "give either `columns` and `lists`"),
        ({"time": "t"}, "no column 't'; the columns are 'stamp', 'positions', 'torques'"),
        ({"recording": {}}, "`recording.mechanism.model` is missing"),
        ({"recording": {"mechanism": {"axis": "hinge"}}}, "for a single joint, and `joints` has 2"),
        ({"recording": {"mechanism": {"model": "robot.xml", "joints": ["a"]}}}, "differs from `joints`"),
        ({"recording": {"mechanism": 3}}, "`recording.mechanism` = 3: it is a table"),
        ({"joint": ["a"]}, "unknown key `joint`; did you mean `joints`"),
    ],
)
def test_an_invalid_map_is_named(
    imported: Import, tmp_path: Path, model: Path, change: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        imported(lists(tmp_path / "log.csv"), "csv", LISTS | change)


def test_a_missing_time_is_named(imported: Import, tmp_path: Path) -> None:
    settings = {key: value for key, value in LISTS.items() if key != "time"}
    with pytest.raises(ValueError, match=r"map\.toml: `time` is missing"):
        imported(lists(tmp_path / "log.csv"), "csv", settings)


def test_joints_of_different_times_are_refused(imported: Import, tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("t,x,y\n0,1,\n1,2,\n2,,3\n3,,4\n")
    (tmp_path / "robot.xml").write_text(MODEL)
    columns = {"q_a": "x", "q_b": "y"}
    settings = {"joints": ["a", "b"], "time": "t", "columns": columns, "recording": LISTS["recording"]}
    with pytest.raises(ValueError, match="the positions of a, b have no interval in common"):
        imported(tmp_path / "log.csv", "csv", settings)
