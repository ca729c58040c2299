"""Malicious recordings."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trundle
from trundle.cli import main

Tables = dict[str, dict[str, Any]]
NAMES = {
    "an escape sequence": "red\x1b[31m",
    "a line break": "one\ntwo",
    "a carriage return": "one\rtwo",
    "another direction": "a\u202eb",
    "nothing that is seen": "a\u200bb",
    "a C1 control character": "a\x9bb",
}


@pytest.mark.parametrize("name", NAMES.values(), ids=list(NAMES))
def test_control_characters_in_names_are_refused_and_escaped(
    recording: trundle.Recording, tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "run"
    recording.write(folder)
    (folder / "episode_00.csv").rename(folder / f"{name}.csv")
    for verb in ("check", "info"):
        assert main([verb, str(folder)]) == 2
        said = capsys.readouterr()
        assert said.err.isprintable() or said.err[:-1].isprintable()
        assert "is not a valid episode name" in said.err
        assert said.out == ""


@pytest.mark.parametrize("name", NAMES.values(), ids=list(NAMES))
def test_control_characters_are_refused_in_memory(
    metadata: dict[str, Any], tables: Tables, name: str
) -> None:
    with pytest.raises(trundle.TrundleError, match="is not a valid episode name") as refused:
        trundle.Recording(metadata, {name: tables["episode_00"]})
    assert "\x1b" not in str(refused.value)
    assert "\n" not in str(refused.value)
    with pytest.raises(trundle.TrundleError, match="contains control or invisible characters"):
        trundle.Recording(metadata | {"name": name}, tables)


def test_column_names_are_escaped_in_messages(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "episode_00.csv").write_text("t,b\x1b[3m\n0,1\n")
    assert main(["check", str(folder)]) == 2
    said = capsys.readouterr().err
    assert "unknown column" in said
    assert "\x1b" not in said


def test_names_may_use_any_script(metadata: dict[str, Any], tables: Tables) -> None:
    for name in ("Übung 3", "推す_01", "push-1.a"):
        trundle.Recording(metadata, {name: tables["episode_00"]})


def test_the_time_is_linear_in_the_number_of_columns(folder: Path) -> None:
    """A comparison of every pair of titles would take more than a minute."""
    names = [f"note_{k}" for k in range(100_000)]
    columns = ["t", "object_x", "object_y", "object_theta", "force_x", "force_y", "torque_z"]
    rows = [f"{k},{k},0,0,1,0,0" + "," * len(names) for k in range(3)]
    (folder / "episode_00.csv").write_text("\n".join([",".join([*columns, *names]), *rows]))
    begun = time.process_time()
    table = trundle.read(folder).episodes["episode_00"]
    assert len(table) == len(columns) + len(names)
    trundle.check(folder)
    assert time.process_time() - begun < 10


def test_a_small_parquet_file_does_not_take_gigabytes(folder: Path) -> None:
    """A text of 300 characters in each of a million rows is stored once."""
    pa = pytest.importorskip("pyarrow", reason="pyarrow makes the file")
    pq = pytest.importorskip("pyarrow.parquet")
    rows = 1_000_000
    words = pa.DictionaryArray.from_arrays(pa.array(np.zeros(rows, np.int32)), pa.array(["x" * 300]))
    file = folder / "episode_00.parquet"
    pq.write_table(pa.table({"t": np.zeros(rows), "note_said": words}), file, compression="zstd")
    assert file.stat().st_size < 300_000
    with pytest.raises(
        trundle.TrundleError, match=r"column note_said: the table unpacks to more than \d+ MiB"
    ):
        trundle.read(folder)
