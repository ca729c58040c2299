"""`trundle import` on the command line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import trundle
from tests.importers.bagwriter import Push, write_bag
from trundle.cli import main

MAP = """
[object]
topic = "/table"
[wrench]
topic = "/ft"
[gripper]
topic = "/tf"
frame = "hand"
[recording.object]
footprint = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]
[recording.wrench]
frame = "sensor"
sign = "on_object"
raw = false
"""


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    (tmp_path / "map.toml").write_text(MAP)
    return write_bag(tmp_path / "run_3", Push().messages())


def call(bag: Path, *more: str) -> int:
    there = bag.parent
    return main(["import", str(bag), "--from", "rosbag2", "--map", str(there / "map.toml"), *more])


@pytest.mark.parametrize("table", ["csv", "parquet"])
def test_a_bag_becomes_a_recording(bag: Path, capsys: pytest.CaptureFixture[str], table: str) -> None:
    out = bag.parent / "recording"
    assert call(bag, "--out", str(out), "--table", table) == 0
    assert f"{out}: 1 episode, 300 rows" in capsys.readouterr().out
    recording = trundle.read(out)
    assert recording.name == "run_3"
    assert (out / f"episode_00.{table}").is_file()
    pose = recording.episodes["episode_00"]["object_x"]
    np.testing.assert_allclose(pose[~np.isnan(pose)], Push().object[:, 0], atol=1e-9)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"/ft"', '"/wrist"', "run_3: no topic '/wrist' for wrench; the topics are"),
        ('"/ft"', '"/ft" oops', "map.toml: not a TOML file"),
        ("[object]", "[objekt]", "map.toml: unknown key `objekt`; did you mean `object`?"),
        ('"sensor"\n', '"senser"\n', "senser"),
        ("raw = false", "raw = true", "precontact"),
    ],
)
def test_unusable_input_is_reported_without_output(
    bag: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, message: str
) -> None:
    (bag.parent / "map.toml").write_text(MAP.replace(old, new, 1))
    before = sorted(bag.parent.iterdir())
    assert call(bag, "--out", str(bag.parent / "recording")) == 2
    assert message in capsys.readouterr().err
    assert sorted(bag.parent.iterdir()) == before


def test_a_missing_map_is_reported(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bare = next(bag.glob("*.mcap"))
    for source, *layout in ((bag, "--from", "rosbag2"), (bag, "--from", "csv"), (bare,)):
        assert main(["import", str(source), *layout, "--out", str(bag.parent / "recording")]) == 2
        complaint = capsys.readouterr().err
        assert str(source) in complaint and "needs --map" in complaint


def test_an_unknown_suffix_requires_a_layout(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", str(bag), "--out", str(bag.parent / "recording")]) == 2
    assert f"{bag}: unknown layout; give --from with one of cmu-planar-push, csv" in capsys.readouterr().err


def test_a_missing_source_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", str(tmp_path / "none"), "--from", "emps", "--out", str(tmp_path / "out")]) == 2
    assert "none: no such file or folder" in capsys.readouterr().err
