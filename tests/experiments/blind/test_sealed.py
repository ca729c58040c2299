"""Sealed answers cannot change."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

from trundle import TrundleError
from trundle.experiments.blind.sealed import open_sealed, seal

ANSWERS = {"case_0001": {"names": ["latency"], "seed": 8}, "case_0000": {"names": [], "seed": 7}}


def test_a_sealed_file_opens_with_its_hash(tmp_path: Path) -> None:
    path = tmp_path / "answers.json"
    sha = seal(path, {"range": "tune"}, ANSWERS)
    assert sha == hashlib.sha256(path.read_bytes()).hexdigest()
    assert open_sealed(path, sha) == ANSWERS
    again = seal(tmp_path / "again.json", {"range": "tune"}, dict(reversed(ANSWERS.items())))
    assert again == sha


def test_a_changed_answer_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "answers.json"
    sha = seal(path, {}, ANSWERS)
    path.write_text(path.read_text().replace("latency", "tether"))
    with pytest.raises(TrundleError, match="not " + sha):
        open_sealed(path, sha)
