"""Erroneous recordings are refused before a diagnosis and not explained by an effect."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

import trundle
from tests.record_prepare.conftest import Corrupt
from tests.record_prepare.table import TABLES, Table, metadata, recording, tables
from tests.record_prepare.test_check import CORRUPTIONS
from trundle.cli import main
from trundle.input_checks import require_usable

WORDS = {
    "millimetres": "millimetres",
    "degrees": "appears to be in degrees",
    "newton millimetres": "appear to be in N mm",
    "wrong sign": "the force appears to act in the wrong direction",
    "exchanged axes": "force_x and force_y appear swapped",
    "sensor turned by a quarter": "the force axes appear rotated",
    "another epoch": "do not overlap",
    "never moves": "the object hardly moves",
    "no force": "no force exceeds the noise",
}


def corrupted(corrupt: Corrupt, table: Table) -> trundle.Recording:
    described, episodes = metadata(table), deepcopy(tables(table))
    corrupt(described, episodes)
    return trundle.Recording(described, episodes)


@pytest.mark.parametrize("name", WORDS)
def test_erroneous_recordings_are_refused(name: str) -> None:
    with pytest.raises(trundle.TrundleError, match=WORDS[name]) as refusal:
        trundle.diagnose(corrupted(CORRUPTIONS[name][0], Table()))
    assert "(" in str(refusal.value)  # the remedy


def test_the_command_line_refuses_with_status_2(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    corrupted(CORRUPTIONS["wrong sign"][0], Table()).write(tmp_path / "wrong")
    status = main(["diagnose", str(tmp_path / "wrong"), "--out", str(tmp_path / "out"), "--quiet"])
    seen = capsys.readouterr()
    assert status == 2 and seen.out == ""
    assert "the force appears to act in the wrong direction" in seen.err
    assert not (tmp_path / "out").exists()


def backwards(_: dict[str, Any], episodes: TABLES) -> None:
    """Return a table whose clock jumps back by half a second."""
    t = episodes["episode_01"]["t"]
    t[len(t) // 2 :] -= 0.5


def test_decreasing_times_are_refused() -> None:
    with pytest.raises(trundle.TrundleError, match="episode_01"):
        corrupted(backwards, Table())


@pytest.mark.parametrize("name", ["wrench 100 ms late", "saturated", "tare in contact"])
def test_suspicious_recordings_cause_warnings(name: str) -> None:
    doubts = require_usable(corrupted(CORRUPTIONS[name][0], Table()))
    assert doubts and all("(" in doubt for doubt in doubts)


def test_a_clean_recording_causes_no_warning() -> None:
    assert require_usable(recording(Table())) == []


@pytest.mark.parametrize("seed", [1, 2])
def test_a_second_of_pushing_is_not_enough(seed: int) -> None:
    with pytest.raises(trundle.TrundleError, match="s of pushing; at least"):
        trundle.diagnose(recording(Table(episodes=2, seconds=1.6, seed=20 + seed)))
