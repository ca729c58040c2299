"""`trundle prove` with the file of a wide benchmark and an invented diagnosis."""

from __future__ import annotations

import hashlib
import json
import signal
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("mujoco")

import trundle
from trundle.cli import main
from trundle.experiments.blind import benchmark
from trundle.experiments.blind.diagnose import diagnose_case, parse_answer
from trundle.experiments.blind.sealed import folder_digest

TINY = """
format = "trundle-wide/1"
effects = ["all"]
outside = ["all"]
[ranges.tune]
first = 42
clean = 2
"""


def command(tmp_path: Path, *more: str, text: str = TINY) -> int:
    config = tmp_path / "tiny.toml"
    config.write_text(text)
    places = ["--work", str(tmp_path / "work"), "--out", str(tmp_path / "out")]
    return main(["prove", "--config", str(config), "--range", "tune", *places, *more])


def made_up(digest: str, limit: float, folder: Path, without: list[str], experiments: bool) -> dict[str, Any]:
    """Return an invented answer that depends on the name and content of the folder only."""
    assert folder_digest(folder) == digest
    assert (without, experiments) == ([], False)
    trundle.read(folder)
    with (folder.parents[1] / "asked").open("a") as file:
        file.write(f"{folder.name}\n")
    answer: dict[str, Any] = {
        "verdict": "consistent",
        "missing": [],
        "tied": [],
        "tied_sets": [],
        "held_out": {},
    }
    if folder.name == "case_0001":
        answer = {"verdict": "refused", "reason": "made up"}
    return {**answer, "cost": {"seconds": 1.0, "cpu": 1.0, "memory": 50.0}}


def test_drawn_sealed_diagnosed_and_continued(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(benchmark, "diagnose_case", made_up)
    assert command(tmp_path) == 0
    found = capsys.readouterr()
    page, kept = (tmp_path / "out/tiny_tune.md").read_text(), tmp_path / "out/wide"
    assert page.strip() == found.out.strip()
    sha = hashlib.sha256((kept / "tiny_tune.answers.json").read_bytes()).hexdigest()
    assert f"SHA-256 {sha}" in found.err
    assert sha in page
    assert "| clean | ≥ 99 % | 50.0 % [9.5 to 90.5], 1 of 2 |" in page
    results = (kept / "tiny_tune.jsonl").read_bytes()
    rows = [json.loads(line) for line in results.splitlines()[1:]]
    assert [row["answer"]["verdict"] for row in rows] == ["consistent", "refused"]
    assert "cost" not in rows[0]["answer"]

    # Nothing is repeated, and lost output is made again with the same bytes.
    recording = tmp_path / "work/tiny_tune/recordings/case_0000"
    before = folder_digest(recording)
    for path in recording.iterdir():
        path.unlink()
    recording.rmdir()
    assert command(tmp_path, "--quiet") == 0
    assert folder_digest(recording) == before
    assert (kept / "tiny_tune.jsonl").read_bytes() == results
    asked = (tmp_path / "work/tiny_tune/asked").read_text().split()
    assert sorted(asked) == ["case_0000", "case_0001"]

    assert command(tmp_path, "--redraw") == 0
    sealed = kept / "tiny_tune.answers.json"
    sealed.write_text(sealed.read_text().replace("grasp", "point"))
    assert command(tmp_path, "--redraw") == 2


@pytest.mark.slow
def test_another_machine_continues_the_shares_of_a_range(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(benchmark, "diagnose_case", made_up)
    text = TINY.replace("clean = 2", "clean = 3\nshares = 2")
    assert command(tmp_path, "--shares", "1", text=text) == 0
    assert "1 of 2 shares: 2 recordings" in capsys.readouterr().out
    kept = tmp_path / "out/wide"
    first = (kept / "tiny_tune_00.jsonl").read_bytes()
    assert [json.loads(line)["case"] for line in first.splitlines()[1:]] == ["case_0000", "case_0002"]

    # The second machine has the saved results, but neither recordings nor finished units.
    (tmp_path / "work").rename(tmp_path / "lost")
    assert command(tmp_path, text=text) == 0
    assert "2 of 2 shares: 3 recordings" in capsys.readouterr().out
    assert (tmp_path / "work/tiny_tune/asked").read_text().split() == ["case_0001"]
    assert (kept / "tiny_tune_00.jsonl").read_bytes() == first

    # Another version of the code repeats every share.
    newer = {"generator": "1", "diagnosis": "2-3"}
    for module in ("benchmark", "run"):
        monkeypatch.setattr(f"trundle.experiments.blind.{module}.code_versions", lambda settings: newer)
    assert command(tmp_path, "--shares", "1", text=text) == 0
    page = capsys.readouterr().out
    assert "`2`" in page
    assert "3 recordings" in page
    assert json.loads((kept / "tiny_tune_00.jsonl").read_text().splitlines()[0])["code"] == newer
    assert json.loads((kept / "tiny_tune_01.jsonl").read_text().splitlines()[0])["code"] != newer


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (TINY.replace("clean = 2", "shares = 0"), "shares = 0 must be at least 1"),
        (TINY.replace('"all"]\noutside', '"ghost"]\noutside'), "unknown family 'ghost'"),
        (TINY.replace("ranges.tune", "ranges.other"), "[ranges] has no 'tune'"),
        (TINY.replace("clean = 2", "celan = 2"), "celan"),
        (TINY.replace("first = 42", ""), "first"),
    ],
)
def test_an_unusable_file_is_reported(
    text: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command(tmp_path, text=text) == 2
    assert words in capsys.readouterr().err.replace("\n", " ")
    assert not (tmp_path / "out").exists()


def test_options_of_the_first_benchmark_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command(tmp_path, "--limits") == 2
    assert "--limits" in capsys.readouterr().err
    assert command(tmp_path, "--shares", "0") == 2
    assert "--shares 0" in capsys.readouterr().err


def test_a_refused_diagnosis_counts_as_an_answer(tmp_path: Path) -> None:
    answer = diagnose_case("", 60.0, tmp_path / "case_0003")
    assert answer["verdict"] == "refused"
    assert "case_0003" in answer["reason"]
    assert str(tmp_path) not in answer["reason"]
    assert answer["cost"]["seconds"] > 0.0


def test_missing_answers_are_timeouts_or_crashes() -> None:
    assert parse_answer(-signal.SIGXCPU, b"", b"")["verdict"] == "timeout"
    assert parse_answer(-signal.SIGSEGV, b"", b"first\nlast\n") == {
        "verdict": "crashed",
        "reason": "exit -11: last",
    }
    assert parse_answer(0, b'{"verdict": "consistent"}', b"") == {"verdict": "consistent"}
