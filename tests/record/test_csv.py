"""CSV files of other programs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import trundle

WAYS: dict[str, Callable[[str], bytes]] = {
    "as pandas writes it": lambda text: text.encode(),
    "byte order mark": lambda text: text.encode("utf-8-sig"),
    "carriage returns": lambda text: text.replace("\r", "").replace("\n", "\r\n").encode(),
    "blank lines at the end": lambda text: (text + "\n\n").encode(),
    "no line break at the end": lambda text: text.rstrip("\n").encode(),
    "spaces in the header": lambda text: text.replace(",force_x,", " , force_x ,").encode(),
    "spaces in cells": lambda text: text.replace("0.1,", " 0.1 ,").encode(),
    "nan written out": lambda text: text.replace("0.3,,,,", "0.3,nan, NaN,,").encode(),
    "plus signs": lambda text: text.replace("\n0.1,", "\n+0.1,").encode(),
    "exponents": lambda text: text.replace("\n0.1,", "\n1.0E-01,").encode(),
    "quoted numbers": lambda text: text.replace("\n0.1,", '\n"0.1",').encode(),
}


@pytest.mark.parametrize("way", WAYS)
def test_csv_dialects(recording: trundle.Recording, folder: Path, way: str) -> None:
    frame = recording.frame("episode_00")
    frame.loc[2, "note_remark"] = "one line"
    text = frame.to_csv(index=False, lineterminator="\n")
    plain, changed = text.encode(), WAYS[way](text)
    assert changed != plain or way == "as pandas writes it"
    (folder / "episode_00.csv").write_bytes(changed)
    read = trundle.read(folder).frame("episode_00")
    np.testing.assert_array_equal(read.drop(columns="note_remark"), frame.drop(columns="note_remark"))
    assert list(read["note_remark"]) == list(frame["note_remark"])


def test_numbers_have_the_shortest_exact_form(recording: trundle.Recording, tmp_path: Path) -> None:
    recording.write(tmp_path / "run")
    lines = (tmp_path / "run" / "episode_00.csv").read_text().splitlines()
    assert lines[0] == "t,object_x,object_y,object_theta,force_x,force_y,torque_z,note_remark"
    force = np.sqrt(0.1)
    assert lines[2] == f'0.1,,,,{force},{-force},{force / 7},"a, ""b"""'
