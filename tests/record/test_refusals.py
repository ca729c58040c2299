"""Errors that are specific to Python; Rust tests cover the others."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trundle

Tables = dict[str, dict[str, Any]]


def test_it_is_a_value_error() -> None:
    assert issubclass(trundle.TrundleError, ValueError)
    assert trundle.TrundleError.__module__ == "trundle"


@pytest.mark.parametrize("as_path", [str, Path])
def test_missing_folders(as_path: type) -> None:
    with pytest.raises(trundle.TrundleError) as refusal:
        trundle.read(as_path("missing"))
    assert str(refusal.value) == (
        "missing: there is no such folder; a recording is a folder with recording.toml "
        "and one table per episode (NAME.csv or NAME.parquet)"
    )


KEYS: dict[str, tuple[Any, str]] = {
    "nothing": (None, "metadata.extra: a value of type NoneType cannot be written as TOML; remove the key"),
    "an object": (object(), "metadata.extra: a value of type object cannot be written as TOML"),
    "a large number": (2**70, "metadata.extra: 1180591620717411303424 does not fit 64 bits"),
    "a key that is no text": ({1: 2}, "metadata.extra: the key 1 is not a string"),
    "deep": ([1, {"a": None}], "metadata.extra[1].a: a value of type NoneType"),
    "known to TOML alone": (1, "recording.toml: unknown field `extra`, expected one of `format`"),
}


@pytest.mark.parametrize("case", KEYS)
def test_metadata(metadata: dict[str, Any], tables: Tables, case: str) -> None:
    value, message = KEYS[case]
    with pytest.raises(trundle.TrundleError) as refusal:
        trundle.Recording({**metadata, "extra": value}, tables)
    assert str(refusal.value).startswith(message)


COLUMNS: dict[str, tuple[str, Any, str]] = {
    "words": ("force_x", ["a"] * 9, "episode episode_00, column force_x: not a sequence of numbers"),
    "a number": ("force_x", 3.0, "episode episode_00, column force_x: not a sequence of numbers"),
    "a matrix": (
        "force_x",
        np.zeros((9, 2)),
        "episode episode_00, column force_x: not a sequence of numbers",
    ),
    "too short": (
        "force_x",
        np.zeros(8),
        "episode episode_00, column force_x: the column has 8 cells, but t has 9",
    ),
    "a short note": (
        "note_remark",
        ["a"],
        "episode episode_00, column note_remark: the column has 1 cells, but t has 9",
    ),
    "an unknown column": ("speed", np.zeros(9), "episode episode_00, column speed: unknown column"),
    "time that stands still": (
        "t",
        np.zeros(9),
        "episode episode_00, row 2, column t: time 0 s does not follow",
    ),
    "half a pose": (
        "object_x",
        np.arange(9.0),
        "episode episode_00, row 2, column object_y: the cell is empty, but object_x = 1;",
    ),
}


@pytest.mark.parametrize("case", COLUMNS)
def test_columns(metadata: dict[str, Any], tables: Tables, case: str) -> None:
    name, cells, message = COLUMNS[case]
    tables["episode_00"][name] = cells
    with pytest.raises(trundle.TrundleError) as refusal:
        trundle.Recording(metadata, tables)
    assert str(refusal.value).startswith(message)


@pytest.mark.parametrize("name", ["", ".", "..", ".hidden", "a/b", "/a", "a\\b", "a\0b", "a/"])
def test_invalid_names(metadata: dict[str, Any], tables: Tables, name: str) -> None:
    with pytest.raises(trundle.TrundleError, match="is not a valid episode name"):
        trundle.Recording(metadata, {name: tables["episode_00"]})


def test_unknown_episodes(recording: trundle.Recording) -> None:
    with pytest.raises(trundle.TrundleError, match=r'^"b" is no episode of a table; there are: episode_00$'):
        recording.frame("b")


def test_unknown_table_formats(recording: trundle.Recording, tmp_path: Path) -> None:
    with pytest.raises(trundle.TrundleError, match='table = "xlsx": choose "csv" or "parquet"'):
        recording.write(tmp_path / "run", "xlsx")  # type: ignore[arg-type]
    assert not (tmp_path / "run").exists()
