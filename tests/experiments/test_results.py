"""Files of results."""

from __future__ import annotations

from pathlib import Path

import pytest

from trundle import TrundleError
from trundle.experiments.results import read_lines, read_trials, rounded, write_lines, write_trials


def test_lines_are_written_and_read(tmp_path: Path) -> None:
    write_lines(tmp_path / "lines.jsonl", [{"b": 1, "a": [1.5]}, {}])
    assert (tmp_path / "lines.jsonl").read_text() == '{"a": [1.5], "b": 1}\n{}\n'
    assert read_lines(tmp_path / "lines.jsonl") == [{"a": [1.5], "b": 1}, {}]


def test_trials_are_written_and_read(tmp_path: Path) -> None:
    path = tmp_path / "trials.jsonl"
    write_trials(path, {"seeds": 2}, [({"seed": k}, {"value": 0.5 * k}, 1.234) for k in range(2)])
    assert read_trials(path) == (
        {"seeds": 2},
        [{"seed": 0, "value": 0.0, "seconds": 1.23}, {"seed": 1, "value": 0.5, "seconds": 1.23}],
    )


@pytest.mark.parametrize("text", ["[1, 2]\n", "", '{"settings": {}}\n{"trial": {}}\n', "{"])
def test_a_file_without_results_is_named(text: str, tmp_path: Path) -> None:
    path = tmp_path / "trials.jsonl"
    path.write_text(text)
    with pytest.raises(TrundleError, match=r"trials\.jsonl: not results"):
        read_trials(path)


def test_results_have_six_digits_and_no_infinities() -> None:
    assert rounded({"a": (1 / 3, float("inf")), "b": [True, 7, "x"]}) == {
        "a": [0.333333, None],
        "b": [True, 7, "x"],
    }
