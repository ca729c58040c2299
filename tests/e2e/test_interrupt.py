"""Ctrl-C ends a long verb immediately without partial output; damaged input is named."""

import shutil
import signal
from pathlib import Path

import pytest

from tests.command import COMMAND, at_work, interruptible, trundle

LONG = {
    "diagnose": ["diagnose", "recording", "--out", "out"],
    "fit": ["fit", "recording", "--starts", "1000", "--out", "out"],
}


@pytest.fixture
def place(recording: Path, tmp_path: Path) -> Path:
    shutil.copytree(recording, tmp_path / "recording")
    return tmp_path


@pytest.mark.parametrize("verb", sorted(LONG))
def test_ctrl_c_interrupts_a_diagnosis_immediately(place: Path, verb: str) -> None:
    with interruptible([*COMMAND, *LONG[verb]], place) as process:
        at_work(process, 3.0)  # past the imports, well before the answer
        assert process.poll() is None, "it ended before it could be interrupted"
        process.send_signal(signal.SIGINT)
        _, complaint = process.communicate(timeout=20)
    assert process.returncode == 130
    assert complaint == "trundle: interrupted\n"
    assert [path.name for path in place.iterdir()] == ["recording"]


def test_an_error_in_a_table_names_file_row_and_column(place: Path) -> None:
    table = place / "recording/episode_03.csv"
    lines = table.read_text().splitlines(keepends=True)
    column = lines[0].rstrip("\n").split(",").index("force_x")
    row = next(n for n, line in enumerate(lines[1:], 1) if line.split(",")[column])
    cells = lines[row].split(",")
    cells[column] = "twelve"
    lines[row] = ",".join(cells)
    table.write_text("".join(lines))
    ran = trundle(place, "diagnose", "recording", "--out", "out")
    assert ran.returncode == 2
    for word in ("episode_03.csv", f"row {row}", "force_x", "twelve"):
        assert word in ran.stderr
    assert not (place / "out").exists()
