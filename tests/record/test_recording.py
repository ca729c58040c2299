"""Recordings created, written and read in Python."""

from __future__ import annotations

import copy
import datetime
import pickle
import threading
import time
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

import trundle

Tables = dict[str, dict[str, Any]]


@pytest.mark.parametrize("table", ["csv", "parquet"])
def test_the_round_trip_is_exact(
    recording: trundle.Recording, tables: Tables, tmp_path: Path, table: Literal["csv", "parquet"]
) -> None:
    recording.write(tmp_path / "run", table)
    assert sorted(file.name for file in (tmp_path / "run").iterdir()) == [
        f"episode_00.{table}",
        "recording.toml",
    ]
    again = trundle.read(str(tmp_path / "run"))
    assert again == recording
    assert again.metadata == recording.metadata
    for name, cells in tables["episode_00"].items():
        if name == "note_remark":
            assert again.episodes["episode_00"][name] == cells
        else:
            np.testing.assert_array_equal(again.episodes["episode_00"][name], cells)


def test_columns_have_the_order_of_the_format(recording: trundle.Recording) -> None:
    names = ["t", "object_x", "object_y", "object_theta", "force_x", "force_y", "torque_z", "note_remark"]
    assert list(recording.episodes["episode_00"]) == names
    assert list(recording.frame("episode_00").columns) == names


def test_episodes_are_sorted_by_name(metadata: dict[str, Any], tables: Tables) -> None:
    one = tables["episode_00"]
    assert list(trundle.Recording(metadata, {"b": one, "a": one, "A": one}).episodes) == ["A", "a", "b"]


def test_arrays_are_shared_and_read_only_and_frames_are_copies(recording: trundle.Recording) -> None:
    arrays = recording.episodes["episode_00"]
    assert arrays["t"] is recording.episodes["episode_00"]["t"]
    with pytest.raises(ValueError, match="read-only"):
        arrays["t"][0] = 5.0
    frame = recording.frame("episode_00")
    frame.loc[0, "t"] = 5.0
    assert recording.episodes["episode_00"]["t"][0] == 0.0


def test_a_data_frame_is_an_episode(recording: trundle.Recording, metadata: dict[str, Any]) -> None:
    frame = recording.frame("episode_00")
    assert trundle.Recording(metadata, {"episode_00": frame}) == recording


@pytest.mark.parametrize("kind", [np.float32, np.int64, list, pd.Series])
def test_numeric_types(metadata: dict[str, Any], tables: Tables, kind: Any) -> None:
    table = tables["episode_00"]
    whole = np.arange(9)
    table["force_x"] = kind(whole) if kind in (list, pd.Series) else whole.astype(kind)
    table["force_y"] = np.arange(18.0)[::2]  # not contiguous
    read = trundle.Recording(metadata, tables).episodes["episode_00"]
    np.testing.assert_array_equal(read["force_x"], whole)
    np.testing.assert_array_equal(read["force_y"], 2 * whole)


def test_metadata_include_defaults(recording: trundle.Recording) -> None:
    assert recording.name == "a table"
    assert recording.metadata["at_rest"] is True
    assert recording.metadata["object"]["dof"] == ["x", "y", "theta"]
    usual = {"frame": "object", "sign": "on_object", "raw": False, "contact": "grasp", "source": "measured"}
    assert recording.metadata["wrench"] == usual


def test_notes_keep_their_types(metadata: dict[str, Any], tables: Tables, tmp_path: Path) -> None:
    zone = datetime.timezone(datetime.timedelta(hours=-3, minutes=-30))
    notes = {
        "moment": datetime.datetime(2026, 11, 21, 5, 6, 7, 250000, tzinfo=datetime.timezone.utc),
        "elsewhere": datetime.datetime(2026, 11, 21, 5, 6, 7, tzinfo=zone),
        "local": datetime.datetime(2026, 11, 21, 5, 6, 7),
        "day": datetime.date(2026, 11, 21),
        "time": datetime.time(5, 6, 7),
        "deep": {"er": [1, 2.5, "three", True, {"x": []}]},
    }
    recording = trundle.Recording({**metadata, "notes": notes}, tables)
    assert recording.metadata["notes"] == notes
    recording.write(tmp_path / "run")
    assert trundle.read(tmp_path / "run").metadata["notes"] == notes


def test_numpy_values_are_metadata(metadata: dict[str, Any], tables: Tables) -> None:
    metadata["object"] = {"footprint": np.array([[0, 0], [1, 0], [0, 1]]), "mass": np.float64(3.5)}
    read = trundle.Recording(metadata, tables).metadata["object"]
    assert read["footprint"] == [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
    assert read["mass"] == 3.5


@pytest.mark.parametrize("copy", [copy.deepcopy, lambda recording: pickle.loads(pickle.dumps(recording))])
def test_a_recording_can_be_pickled(recording: trundle.Recording, copy: Any) -> None:
    assert copy(recording) == recording


@given(value=st.floats(min_value=1e-300, max_value=1e300))
def test_metadata_numbers_are_read_back_exactly(value: float) -> None:
    metadata = {
        "format": "trundle-recording/1",
        "name": "rail",
        "object": {"dof": ["x"], "mass": value},
        "wrench": {"frame": "object", "sign": "on_object"},
    }
    tables = {"a": {"t": [0.0, 1.0], "object_x": [0.0, 1.0], "force_x": [1.0, 1.0]}}
    assert trundle.Recording(metadata, tables).metadata["object"]["mass"] == value


def test_other_threads_run_while_a_recording_is_read(metadata: dict[str, Any], tmp_path: Path) -> None:
    n = 200_000
    t = np.arange(n) / 1000
    metadata["object"] = {"dof": ["x"]}
    trundle.Recording(metadata, {"a": {"t": t, "object_x": t / 3, "force_x": t / 7}}).write(tmp_path / "run")
    span: list[float] = []

    def read() -> None:
        span.append(time.perf_counter())
        trundle.read(tmp_path / "run")
        span.append(time.perf_counter())

    reader = threading.Thread(target=read)
    reader.start()
    turns = []
    while reader.is_alive():
        turns.append(time.perf_counter())
    begin, end = span
    # This thread could not run if the reader held the interpreter.
    assert any(0.3 < (turn - begin) / (end - begin) < 0.7 for turn in turns)


def test_an_unrelated_folder_is_not_changed(recording: trundle.Recording, tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("precious")
    with pytest.raises(
        trundle.TrundleError, match=r"already exists and is not a recording; choose another path"
    ):
        recording.write(tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == ["thesis.tex"]
