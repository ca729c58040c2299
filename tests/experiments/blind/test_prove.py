"""`trundle prove` from command line to document, on a minimal benchmark."""

from __future__ import annotations

import hashlib
import json
import shutil
import sys
from pathlib import Path

import pytest

from trundle.cli import main

TINY = """
format = "trundle-proof/1"
effects = ["floor_slope", "force_bias"]
foreign = ["magnet"]
singles = 1
foreigns = 0
pairs = 0
clean = 1
episodes = 3
matters = 2.0
[ranges]
tune = 42
"""


def command(tmp_path: Path, *more: str, text: str = TINY) -> int:
    config = tmp_path / "tiny.toml"
    config.write_text(text)
    places = ["--work", str(tmp_path / "work"), "--out", str(tmp_path / "out")]
    return main(["prove", "--config", str(config), "--range", "tune", *places, *more])


def test_cases_are_drawn_sealed_diagnosed_scored_and_resumed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command(tmp_path) == 0
    said = capsys.readouterr()
    kept = tmp_path / "out/proof"
    sealed = kept / "tiny_tune.answers.json"
    sha = hashlib.sha256(sealed.read_bytes()).hexdigest()
    assert f"SHA-256 {sha}" in said.err
    document = (tmp_path / "out/tiny_tune.md").read_text()
    assert document.strip() == said.out.strip()
    assert sha in document
    assert (
        "3 recordings (2 one effect, 0 two effects, 0 three effects, 0 four effects, 1 clean, 0 out of"
        in document
    )
    assert (tmp_path / "out/images/tiny_tune_confusion.png").exists()
    head, *rows = map(json.loads, (kept / "tiny_tune.jsonl").read_text().splitlines())
    assert head["sha256"] == sha
    assert sorted(row["case"] for row in rows) == ["case_0000", "case_0001", "case_0002"]
    # No case names its hidden effect.
    for folder in (tmp_path / "work/tiny_tune/recordings").iterdir():
        text = (folder / "recording.toml").read_text()
        assert "slope" not in text
        assert "bias" not in text

    # If one result and one recording are lost, only these are made again, with the same bytes.
    rows.sort(key=lambda row: bool(row["answer"]["missing"]))  # a consistent case is the fastest
    lost = rows[0]["case"]
    before = {row["case"]: row["answer"] for row in rows}
    units = {path: json.loads(path.read_text()) for path in (tmp_path / "work/tiny_tune/units").iterdir()}
    mine = [path for path, content in units.items() if content["unit"] == lost]
    assert len(mine) == 2
    for path in mine:
        path.unlink()
    shutil.rmtree(tmp_path / "work/tiny_tune/recordings" / lost)
    assert command(tmp_path, "--quiet") == 0
    again = list(map(json.loads, (kept / "tiny_tune.jsonl").read_text().splitlines()))[1:]
    assert {row["case"]: row["answer"] for row in again} == before
    assert hashlib.sha256(sealed.read_bytes()).hexdigest() == sha

    # The page is redrawn from saved results, and only from sealed answers.
    capsys.readouterr()
    assert command(tmp_path, "--redraw") == 0
    assert sha in capsys.readouterr().out
    sealed.write_text(sealed.read_text().replace("force_bias", "tether"))
    assert command(tmp_path, "--redraw") == 2
    assert "was printed before the first diagnosis" in capsys.readouterr().err.replace("\n", " ")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (TINY.replace("floor_slope", "ghost"), "unknown family 'ghost'"),
        (TINY.replace("tune = 42", "other = 42"), "[ranges] has no 'tune'"),
        (TINY.replace("clean = 1", "celan = 1"), "celan"),
        (TINY.replace("trundle-proof/1", "trundle-proof/2"), "trundle-proof/1"),
    ],
)
def test_an_unusable_file_is_reported(
    text: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command(tmp_path, text=text) == 2
    assert words in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_missing_mujoco_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    assert command(tmp_path) == 2
    assert "need mujoco: pip install 'trundle[experiments]'" in capsys.readouterr().err
