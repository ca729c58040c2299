"""Diagnosis without the true effect."""

import json
from pathlib import Path

import pytest

import trundle as package
from tests.command import trundle


@pytest.mark.slow
def test_an_excluded_effect_is_not_replaced_by_a_wrong_one(recording: Path, tmp_path: Path) -> None:
    ran = trundle(
        tmp_path, "diagnose", recording, "--without", "coulomb_friction", "--out", "without", "--quiet"
    )
    assert ran.returncode == 0, ran.stderr
    answer = json.loads((tmp_path / "without" / "diagnosis.json").read_text())
    assert answer["verdict"] == "unexplained"
    assert answer["missing"] == []
    assert answer["mismatch"]["windows"]


def test_an_unknown_effect_is_refused_with_the_known_ones(recording: Path, tmp_path: Path) -> None:
    with pytest.raises(
        package.TrundleError,
        match=r"unknown effect `coulomb`; did you mean `coulomb_friction`\? The catalogue has .*dead_band",
    ):
        package.diagnose(recording, without=["coulomb"])
    ran = trundle(tmp_path, "diagnose", recording, "--without", "coulomb", "--out", "none")
    assert ran.returncode == 2 and "unknown effect" in ran.stderr
    assert not (tmp_path / "none").exists()
