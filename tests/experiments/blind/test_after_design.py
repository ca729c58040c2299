"""`trundle prove --after-design` from command line to document, on a recording that leaves a tie."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from trundle.cli import main

TIED = """
format = "trundle-proof/1"
effects = ["floor_slope"]
foreign = []
singles = 1
foreigns = 0
pairs = 0
clean = 0
episodes = 3
alike = true
size = 0.5
[ranges]
tune = 900002
"""


@pytest.mark.slow
def test_a_tie_is_resolved_by_the_designed_push(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    config = tmp_path / "tied.toml"
    config.write_text(TIED)
    places = ["--work", str(tmp_path / "work"), "--out", str(tmp_path / "out"), "--quiet"]
    command = ["prove", "--config", str(config), "--range", "tune", *places]
    assert main([*command, "--after-design"]) == 0
    assert "1 answers request a push" in capsys.readouterr().err
    kept = tmp_path / "out/proof/tied_tune_after.jsonl"
    head, *rows = map(json.loads, kept.read_text().splitlines())
    assert head["settings"]["alike"] is True
    answers = {row["push"]: row["answer"] for row in rows}
    assert list(answers) == ["designed", "as the others", "any grasp and heading"]
    assert answers["designed"]["tied"] == []
    assert [one["effect"] for one in answers["designed"]["missing"]] == ["floor_slope"]
    document = (tmp_path / "out/tied_tune.md").read_text()
    assert "## Diagnosis after the requested push" in document
    assert "floor_slope = force_bias" in document
    # A folder contains neither the hidden effect nor the expected name.
    for folder in (tmp_path / "work/tied_tune/longer").iterdir():
        assert "slope" not in (folder / "recording.toml").read_text()

    # Only lost parts are made again, with the same result.
    first = (tmp_path / "out/proof/tied_tune.jsonl").read_bytes()
    kept.write_text("".join(json.dumps(line) + "\n" for line in [head, *rows[1:]]))
    assert main([*command, "--after-design"]) == 0
    again = {row["push"]: row["answer"] for row in map(json.loads, kept.read_text().splitlines()[1:])}
    assert again == answers
    assert (tmp_path / "out/proof/tied_tune.jsonl").read_bytes() == first

    capsys.readouterr()
    assert main([*command, "--redraw"]) == 0
    assert capsys.readouterr().out.strip() == document.strip()

    # With --fresh and without --after-design, all results are discarded.
    assert main([*command, "--fresh"]) == 0
    assert not kept.exists()
