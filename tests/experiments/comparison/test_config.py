"""The file of a comparison: errors name the place."""

from pathlib import Path

import pytest

import trundle
from tests.experiments.comparison.files import TINY, written
from trundle.experiments.comparison.config import read


def test_a_file_is_read_in_its_order(tmp_path: Path) -> None:
    settings = read(written(tmp_path))
    assert list(settings.worlds) == ["table", "rubbing"]
    assert list(settings.worlds["table"].seeds) == [70, 71, 72]
    assert settings.worlds["rubbing"].agents == ["fixed", "oracle"]
    assert settings.agents["oracle"].settings == {"planner": {"samples": 8}}


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("trundle-compare/1", "trundle-compare/2", "trundle-compare/1"),
        ("count = 3", "cuont = 3", "unknown key `worlds.table.cuont`"),
        ("count = 3", "count = 2.5", "`worlds.table.count` = 2.5; it is a whole number"),
        ("count = 3", "count = true", "`worlds.table.count` = True"),
        ("count = 3", "count = 0", "`worlds.table.count` = 0; it is a whole number of at least 1"),
        ("first = 70\n", "", "`worlds.table.first` is missing"),
        ("main =", "push = 0.0\nmain =", "`push` = 0.0; it is a number above 0"),
        ('name = "tiny"', 'name = "../tiny"', "../tiny"),
        ('main = "adaptive"', 'main = "adaptve"', "main: unknown agent 'adaptve'; choose from oracle"),
        ('["fixed", "oracle"]', '["fixed", 3]', "`worlds.rubbing.agents[1]` = 3; it is a string"),
        ('["fixed", "oracle"]', '["fixed", "ppo"]', "[worlds.rubbing] agents: unknown agent 'ppo'"),
        ('kind = "oracle"', 'kind = "orcale"', "`agents.oracle.kind` = 'orcale'; it is one of"),
        ('kind = "oracle"', 'kind = "oracle"\nfiles = ["a.npz"]', "[agents.oracle] files"),
        ('kind = "oracle"', 'kind = "policy"\nfiles = ["a.npz"]', "[agents.oracle] settings"),
        (
            "planner = { samples = 8 }",
            'adapt = "no"',
            "`agents.oracle.settings.adapt` = 'no'; it is true or false",
        ),
        ("starts = 1", "strats = 1", "unknown key `agents.adaptive.settings.strats`; did you mean `starts`?"),
        ('[["adaptive", "fixed"]]', '[["adaptive"]]', "it needs 2"),
        ("horizon = 12 }\nfirst = 70", "horizon = 0 }\nfirst = 70", "an episode must end"),
        ("planner = { samples = 8 }", 'model = "a.toml"', "unknown key `agents.oracle.settings.model`"),
        (
            "samples = 8 } }",
            "samples = 8 } }\noptions = { horizon = 0 }",
            "`agents.oracle.options` = {'horizon': 0}",
        ),
        ('worlds = "table",', "", "`targets[0].worlds` is missing"),
        ('figure = "regret"', 'figure = "regert"', "one of 'success', 'success without touching'"),
        (", most = 9.0", "", "give least or most"),
        ("most = 9.0", "most = 9.0, least = 1.0", "give least or most"),
        ("most = 9.0", 'most = "9"', "`targets[0].most` = '9'; it is a number"),
    ],
)
def test_invalid_settings_are_reported(old: str, new: str, words: str, tmp_path: Path) -> None:
    assert old in TINY
    with pytest.raises(trundle.TrundleError) as refused:
        read(written(tmp_path, TINY.replace(old, new, 1)))
    assert words in str(refused.value)
    assert "tiny.toml" in str(refused.value)
