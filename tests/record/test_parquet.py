"""Parquet files of other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import trundle

Tables = dict[str, dict[str, Any]]

WAYS: dict[str, dict[str, Any]] = {
    **{name: {"compression": name} for name in ["none", "snappy", "gzip", "zstd", "lz4"]},
    "row groups": {"row_group_size": 2},
    "no dictionary": {"use_dictionary": False},
    "small pages": {"data_page_size": 8, "write_batch_size": 1},
    "second page format": {"data_page_version": "2.0"},
    "first format": {"version": "1.0"},
    "checksums": {"write_page_checksum": True},
    "byte streams": {
        "use_dictionary": False,
        "column_encoding": {
            "t": "BYTE_STREAM_SPLIT",
            "force_x": "BYTE_STREAM_SPLIT",
            "note_remark": "DELTA_BYTE_ARRAY",
        },
    },
}


@pytest.mark.parametrize("way", WAYS)
def test_storage_options(recording: trundle.Recording, folder: Path, way: str) -> None:
    table = pa.Table.from_pandas(recording.frame("episode_00"), preserve_index=False)
    pq.write_table(table, folder / "episode_00.parquet", **WAYS[way])
    assert trundle.read(folder) == recording


def test_null_and_nan_are_missing_samples(recording: trundle.Recording, tables: Tables, folder: Path) -> None:
    columns = {name: pa.array(cells, from_pandas=False) for name, cells in tables["episode_00"].items()}
    pose = tables["episode_00"]["object_y"]
    columns["object_y"] = pa.array([None if np.isnan(y) else y for y in pose])
    pq.write_table(pa.table(columns), folder / "episode_00.parquet")
    assert trundle.read(folder) == recording


@pytest.mark.parametrize(
    "kind", ["float32", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64"]
)
def test_every_numeric_type(recording: trundle.Recording, folder: Path, kind: str) -> None:
    frame = recording.frame("episode_00")
    whole = np.arange(9) + (2**31 if kind in ("uint32", "uint64") else 100)
    frame["force_x"] = whole.astype(kind)
    frame.to_parquet(folder / "episode_00.parquet")
    np.testing.assert_array_equal(trundle.read(folder).episodes["episode_00"]["force_x"], whole)


def test_nullable_pandas_columns_and_categories(recording: trundle.Recording, folder: Path) -> None:
    frame = recording.frame("episode_00").convert_dtypes()
    frame["note_remark"] = frame["note_remark"].astype("category")
    frame.to_parquet(folder / "episode_00.parquet")
    assert trundle.read(folder) == recording


def test_a_stream_that_is_null_throughout(recording: trundle.Recording, folder: Path) -> None:
    frame = recording.frame("episode_00")
    for name in ["gripper_x", "gripper_y", "gripper_theta"]:
        frame[name] = None
    frame.to_parquet(folder / "episode_00.parquet")
    assert np.isnan(trundle.read(folder).episodes["episode_00"]["gripper_x"]).all()


def test_notes_of_other_types_become_text(recording: trundle.Recording, folder: Path) -> None:
    frame = recording.frame("episode_00")
    frame["note_number"] = np.arange(9)
    frame["note_truth"] = frame["note_number"] > 4
    frame.loc[3, "note_remark"] = None
    frame.to_parquet(folder / "episode_00.parquet")
    episode = trundle.read(folder).episodes["episode_00"]
    assert list(episode["note_number"][:3]) == ["0", "1", "2"]
    assert episode["note_truth"][8] == "true"
    assert episode["note_remark"][3] == ""


def test_pandas_reads_the_written_file(recording: trundle.Recording, tmp_path: Path) -> None:
    recording.write(tmp_path / "run", "parquet")
    frame = pd.read_parquet(tmp_path / "run" / "episode_00.parquet")
    pd.testing.assert_frame_equal(frame, recording.frame("episode_00"), check_exact=True, check_dtype=False)


REFUSED: dict[str, tuple[str, pa.Array, str]] = {
    "text": (
        "force_x",
        pa.array(["1"] * 9),
        "column force_x: the column contains String values; store it as float64",
    ),
    "dates": ("t", pa.array(range(9), pa.timestamp("ns")), "column t: the column contains Timestamp"),
    "decimals": (
        "force_x",
        pa.array([1] * 9).cast(pa.decimal128(30, 2)),
        "column force_x: the column contains Decimal",
    ),
    "truths": ("force_x", pa.array([True] * 9), "column force_x: the column contains BOOLEAN values"),
    "lists": ("force_x", pa.array([[1.0]] * 9), "column force_x.list.element: unknown column"),
    "another column": ("speed", pa.array([1.0] * 9), "column speed: unknown column; rename it to note_speed"),
    "infinite": (
        "force_x",
        pa.array([1.0] * 8 + [np.inf]),
        "row 9, column force_x: the value inf is infinite",
    ),
    "null time": ("t", pa.array([0.0, None, *range(2, 9)]), "row 2, column t: the cell is empty"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_invalid_columns_are_refused(recording: trundle.Recording, folder: Path, case: str) -> None:
    name, cells, message = REFUSED[case]
    table = pa.Table.from_pandas(recording.frame("episode_00"), preserve_index=False)
    if name in table.column_names:
        table = table.drop_columns(name)
    pq.write_table(table.append_column(name, cells), folder / "episode_00.parquet")
    with pytest.raises(trundle.TrundleError) as refusal:
        trundle.read(folder)
    assert f"episode_00.parquet, {message}" in str(refusal.value)


def test_an_unsupported_codec_is_refused(recording: trundle.Recording, folder: Path) -> None:
    recording.frame("episode_00").to_parquet(folder / "episode_00.parquet", compression="brotli")
    with pytest.raises(
        trundle.TrundleError, match=r"export it again \(uncompressed, snappy, gzip, lz4 or zstd\)"
    ):
        trundle.read(folder)


def test_a_text_file_is_refused(folder: Path) -> None:
    (folder / "episode_00.parquet").write_text("t,force_x\n0,1\n")
    with pytest.raises(trundle.TrundleError, match=r"episode_00\.parquet: not a readable Parquet file: "):
        trundle.read(folder)
