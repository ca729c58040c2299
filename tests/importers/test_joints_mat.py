"""MATLAB files of joints with a map."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io

from tests.importers.conftest import Import
from tests.importers.mechanisms import check_joints
from trundle.importers import SourceError
from trundle.importers.matfile import MatFile

T = np.arange(5) / 10
Q = np.column_stack([T, T**2, -T])
SETTINGS: dict[str, Any] = {
    "joints": {"shoulder": "j1", "wrist": "j3"},
    "time": "log.t",
    "lists": {"q": "log.q"},
    "columns": {"effort_wrist": {"product": ["k", "i"], "index": 1}},
    "order": ["j1", "j2", "j3"],
    "recording": {"mechanism": {"model": "robot.xml"}},
}


@pytest.fixture
def source(tmp_path: Path) -> Path:
    (tmp_path / "robot.xml").write_text("<robot/>")
    scipy.io.savemat(tmp_path / "run.mat", {"log": {"t": T[:, None], "q": Q}, "k": 2.0, "i": T[:, None]})
    return tmp_path / "run.mat"


@pytest.mark.parametrize("transposed", [False, True])
def test_a_matrix_has_a_column_or_a_row_for_each_joint(
    imported: Import, source: Path, transposed: bool
) -> None:
    q = Q.T if transposed else Q
    scipy.io.savemat(source, {"log": {"t": T[:, None], "q": q}, "k": 2.0, "i": T[:, None]})
    got = imported(source, "mat", SETTINGS)
    check_joints(got)
    table = got.episodes["episode_00"]
    np.testing.assert_array_equal(table["q_shoulder"], T)
    np.testing.assert_array_equal(table["q_wrist"], -T)
    np.testing.assert_array_equal(table["effort_wrist"], 2.0 * T)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"order": ["j1", "j3"]}, r"`log\.q` of the shape \(5, 3\) has no dimension of 2"),
        ({"lists": {"q": "k"}}, r"`k` of the shape \(1, 1\) has no dimension of 3"),
        ({"lists": {"q": "log"}}, r"variable `log` is not an array of numbers"),
        (
            {"time": "k"},
            r"run\.mat: effort_wrist has 5 samples and its time 1; give each clock a `\[\[file\]\]`",
        ),
    ],
)
def test_unusable_variables_are_named(
    imported: Import, source: Path, change: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        imported(source, "mat", SETTINGS | change)


def test_a_variable_divides_a_file_into_episodes(imported: Import, source: Path) -> None:
    run = np.array([[1, 1, 2, 2, 2]]).T
    scipy.io.savemat(source, {"log": {"t": T[:, None], "q": Q}, "k": 2.0, "i": T[:, None], "run": run})
    got = imported(source, "mat", SETTINGS | {"episode_column": "run"})
    check_joints(got)
    assert {name: len(table["t"]) for name, table in got.episodes.items()} == {"1": 2, "2": 3}


def test_a_cell_array_is_a_list_of_matrices(tmp_path: Path) -> None:
    cell = np.empty((2, 1), dtype=object)
    cell[0, 0], cell[1, 0] = Q, Q[:2]
    text = np.empty((1, 1), dtype=object)
    text[0, 0] = "words"
    scipy.io.savemat(tmp_path / "run.mat", {"pieces": cell, "text": text})
    file = MatFile(tmp_path / "run.mat")
    for found, expected in zip(file.cell("pieces"), (Q, Q[:2]), strict=True):
        np.testing.assert_array_equal(found, expected)
    with pytest.raises(SourceError, match="variable `text` is not a cell array of matrices"):
        file.cell("text")
