"""What has been played is kept, known by all that it depends on."""

from pathlib import Path

import pytest

import trundle
from trundle.comparison import journal
from trundle.comparison.config import Agent, Worlds

WORLDS, AGENT = Worlds("", "trundle/PushAround-v0", 0, 3, ["a"]), Agent("A", "adaptive")


def test_another_version_plays_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    def key(seed: int) -> str:
        return journal.key(WORLDS, AGENT, 0, seed, {})

    now = key(5)
    assert key(5) == now != key(6)
    monkeypatch.setattr(journal, "__version__", "0.0.1")
    assert key(5) != now


@pytest.mark.parametrize("line", ["{", "3", '{"key": "k"}'])
def test_a_line_that_is_no_episode_is_named(line: str, tmp_path: Path) -> None:
    path = tmp_path / "kept.jsonl"
    journal.Journal(path).add("k", {"success": True}, {"total": 1.0})
    assert journal.Journal(path)["k"] == ({"success": True}, {"total": 1.0})
    path.write_text(path.read_text() + line + "\n")
    with pytest.raises(trundle.TrundleError, match=r"kept\.jsonl: line 2 holds no episode"):
        journal.Journal(path)
