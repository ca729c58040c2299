"""`trundle paper` from the command line to the document."""

from pathlib import Path

import pytest

from trundle.cli import main

CONFIGS = Path(__file__).resolve().parents[3] / "configs"


def test_a_section_is_written_and_redrawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = ["paper", "fig8", "--quick", "--out", str(tmp_path), "--configs", str(CONFIGS)]
    assert main(line) == 0
    text = (tmp_path / "paper.md").read_text()
    picture = (tmp_path / "images/paper_fig8.png").read_bytes()
    assert "| σ | PBR | LR | LWR |" in text
    assert picture.startswith(b"\x89PNG")
    printed = capsys.readouterr().out
    assert printed.strip() in text
    # Redrawn from the results alone: the same bytes.
    results = tmp_path / "paper/fig8.jsonl"
    before = results.read_bytes()
    assert main([*line, "--redraw"]) == 0
    assert (tmp_path / "paper.md").read_text() == text
    assert (tmp_path / "images/paper_fig8.png").read_bytes() == picture
    assert results.read_bytes() == before


@pytest.mark.parametrize(
    ("more", "words"),
    [(["--redraw"], "no results"), (["--configs", "nowhere"], "--configs")],
)
def test_invalid_experiments_are_reported(
    more: list[str], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    line = ["paper", "fig8", "--quick", "--out", str(tmp_path / "out"), "--configs", str(CONFIGS), *more]
    assert main(line) == 2
    assert words in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_run_needs_at_least_one_seed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["paper", "fig8", "--quick", "--out", str(tmp_path / "out"), "--seeds", "0"])
    assert "--seeds: '0' is not a positive integer" in capsys.readouterr().err
