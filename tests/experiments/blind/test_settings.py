"""Settings of a blind benchmark: errors name the key."""

from __future__ import annotations

from pathlib import Path

import pytest

from trundle import TrundleError
from trundle.experiments.blind.families import CATALOGUE, LATER_EFFECTS
from trundle.experiments.blind.result_files import ResultFiles
from trundle.experiments.blind.settings import read

ROOT = Path(__file__).parents[3]

FILE = """
format = "trundle-proof/1"
singles = 1
foreigns = 0
pairs = 0
clean = 1
sizes = [1, 0.5]
[ranges]
tune = 42
"""


def test_settings_are_those_of_committed_results(tmp_path: Path) -> None:
    first = read(ROOT / "configs/experiments/wide.toml", "report").parts()[0]
    assert ResultFiles(ROOT / "docs/wide", "wide_00").read().head["settings"] == first.plain()


@pytest.mark.parametrize("part", ["", "_without"])
def test_results_of_the_first_benchmarks_are_read(part: str) -> None:
    found = ResultFiles(ROOT / "docs/proof", "proof_further").read(part)
    assert found.head.keys() == {"settings", "sha256"}
    assert len(found.truths) == 61
    for row in found.rows:
        assert row.keys() >= {"case", "answer", "truth", "cost"}
        assert row["truth"].keys() >= {"outside", "attempts", "digest"}


def test_omitted_lists_mean_all_effects_of_the_first_benchmarks(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_text(FILE)
    settings = read(path, "tune")
    assert (*settings.effects, *LATER_EFFECTS) == tuple(CATALOGUE)
    assert (settings.first, settings.sizes) == (42, (1.0, 0.5))


@pytest.mark.parametrize("name", LATER_EFFECTS)
def test_later_effects_are_chosen_by_name(tmp_path: Path, name: str) -> None:
    path = tmp_path / "a.toml"
    path.write_text(FILE.replace("clean = 1", f'clean = 1\neffects = ["{name}"]'))
    assert read(path, "tune").effects == (name,)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("singles = 1", 'singles = "many"', "`singles` = 'many'; it is a whole number"),
        ("pairs = 0", "pairs = [1]", "`pairs`"),
        ("clean = 1", "clean = 1.5", "`clean` = 1.5"),
        ("sizes = [1, 0.5]", "sizes = 1.0", "`sizes` = 1.0; it is a list"),
        ("sizes = [1, 0.5]", 'sizes = ["big"]', "`sizes[0]`"),
        ("clean = 1", "clean = 1\neffects = 3", "`effects` = 3; it is a list"),
        ("clean = 1", "clean = 1\nforeign = [4]", "`foreign[0]` = 4"),
        ("clean = 1", 'clean = 1\neffects = ["none"]', "unknown family 'none'"),
        ("clean = 1", 'clean = 1\nmatters = "much"', "`matters`"),
        ("clean = 1", "clean = 1\nfirst = 3", "unknown key `first`"),
        ("clean = 1", "clean = 1\nother = 3", "unknown key `other`"),
        ("clean = 1", "", "`clean` is missing"),
        ("[ranges]\ntune = 42", "ranges = 5", "`ranges` = 5; it is a table"),
        ("tune = 42", 'tune = "here"', "`ranges.tune` = 'here'; it is a whole number"),
        ("tune = 42", "tune = [1, 2]", "`ranges.tune`"),
        ("tune = 42", "other = 42", "[ranges] has no 'tune'; it has other"),
    ],
)
def test_a_wrong_value_is_named(tmp_path: Path, old: str, new: str, words: str) -> None:
    path = tmp_path / "a.toml"
    assert old in FILE
    path.write_text(FILE.replace(old, new))
    with pytest.raises(TrundleError) as refused:
        read(path, "tune")
    assert str(path) in str(refused.value)
    assert words in str(refused.value)
