"""`trundle compare` from file to document, with interruptions."""

from __future__ import annotations

import json
import shutil
import signal
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

import trundle
from tests.command import COMMAND, interruptible
from tests.experiments.comparison.files import TINY, written
from trundle.cli import main
from trundle.experiments.comparison.config import Agent, Worlds
from trundle.experiments.comparison.episode import play

EPISODES = 3 * 3 + 2 * 2


def compare(folder: Path, *more: str, text: str = TINY) -> int:
    places = ["--work", str(folder / "work"), "--out", str(folder / "out")]
    return main(["compare", str(written(folder, text)), *places, "--quiet", *more])


def results(folder: Path) -> bytes:
    return (folder / "out/tiny/results.jsonl").read_bytes()


def episodes(folder: Path) -> list[dict[str, Any]]:
    """Return the results of all episodes."""
    head, *lines = map(json.loads, results(folder).splitlines())
    assert set(head) == {"settings", "policies", "trundle"}
    frames = [pd.DataFrame(line) for line in lines]
    return [{str(key): value for key, value in row.items()} for row in pd.concat(frames).to_dict("records")]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("whole")
    assert compare(folder) == 0
    return folder


def test_each_agent_plays_each_world_once(whole: Path) -> None:
    rows = episodes(whole)
    played = [(row["worlds"], row["agent"], row["run"], row["seed"]) for row in rows]
    table = [("table", agent, 0, seed) for agent in ("oracle", "adaptive", "fixed") for seed in (70, 71, 72)]
    rubbing = [("rubbing", agent, 0, seed) for agent in ("fixed", "oracle") for seed in (5, 6)]
    assert played == table + rubbing
    for row in rows:
        assert row["limit"] == pytest.approx(0.6)
        assert 0 < row["seconds"] <= 0.6 + 1e-9
        assert row["return"] < 0
        assert 0.3 < row["radius"] < 1.0
    assert {row["fits"] for row in rows if row["agent"] != "adaptive"} == {0}
    assert min(row["fits"] for row in rows if row["agent"] == "adaptive") >= 1
    assert {row["learning"] for row in rows if row["agent"] == "adaptive"} <= {0.5, 0.55}


def test_the_document_contains_the_results(whole: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = (whole / "out/tiny.md").read_text()
    assert "**A table** (`table`, 3 worlds): Adaptive succeeds without touching in" in page
    assert "seeds 70 to 72" in page
    assert "`coulomb_friction` (at foot, force [10.0, 30.0])" in page
    assert "| `table` | Adaptive | regret | ≤ 900 % |" in page
    assert "Adaptive over Fixed" in page
    assert "{" not in page
    for picture in ("successes", "profiles"):
        assert f"images/tiny_{picture}.png" in page
        assert (whole / f"out/images/tiny_{picture}.png").exists()
    assert compare(whole, "--redraw") == 0
    assert capsys.readouterr().out.strip() == page.strip()


def kept(folder: Path) -> list[Path]:
    """Return the files of the finished episodes."""
    return sorted((folder / "work/tiny").glob("*.json"))


def test_a_lost_episode_is_repeated_with_the_same_bytes(whole: Path, tmp_path: Path) -> None:
    shutil.copytree(whole / "work", tmp_path / "work")
    assert len(kept(tmp_path)) == EPISODES
    before = {path: path.stat().st_mtime_ns for path in kept(tmp_path)}
    lost = kept(tmp_path)[4]
    lost.unlink()
    assert compare(tmp_path) == 0
    assert results(tmp_path) == results(whole)
    after = {path: path.stat().st_mtime_ns for path in kept(tmp_path)}
    assert [path for path in after if after[path] != before[path]] == [lost]


def test_several_processes_give_the_same_bytes(whole: Path, tmp_path: Path) -> None:
    assert compare(tmp_path, "--jobs", "2") == 0
    assert results(tmp_path) == results(whole)


def test_the_next_call_continues_after_ctrl_c(whole: Path, tmp_path: Path) -> None:
    written(tmp_path, TINY.replace("samples = 8", "samples = 500").replace("horizon = 12", "horizon = 40"))
    line = [*COMMAND, "compare", "tiny.toml", "--work", "work", "--out", "out", "--jobs", "2"]
    with interruptible(line, tmp_path) as process:
        given_up = time.monotonic() + 300
        while not kept(tmp_path) and time.monotonic() < given_up:
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        _, complaint = process.communicate(timeout=120)
    assert process.returncode == 130
    assert complaint == "trundle: interrupted\n"
    assert not (tmp_path / "out").exists()
    assert 0 < len(kept(tmp_path)) < EPISODES


def test_more_worlds_are_added_to_existing_results(whole: Path, tmp_path: Path) -> None:
    assert compare(tmp_path, "--worlds", "1") == 0
    assert len(episodes(tmp_path)) == 3 + 2
    before = {path: path.stat().st_mtime_ns for path in kept(tmp_path)}
    assert compare(tmp_path, "--worlds", "9") == 0
    assert results(tmp_path) == results(whole)
    assert {path: path.stat().st_mtime_ns for path in before} == before


def test_only_a_changed_agent_is_played_again(whole: Path, tmp_path: Path) -> None:
    shutil.copytree(whole / "work", tmp_path / "work")
    changed = TINY.replace("samples = 8 }, adapt = false", "samples = 9 }, adapt = false")
    assert compare(tmp_path, text=changed.replace('title = "Fixed"', 'title = "No adaptation"')) == 0
    assert len(kept(tmp_path)) == EPISODES + 5
    # The page cannot be redrawn from results of another agent with the same name.
    assert compare(tmp_path, "--redraw") == 2
    assert compare(tmp_path, "--fresh") == 0
    assert len(kept(tmp_path)) == EPISODES


class Still:
    """A policy that does nothing and counts its steps."""

    def __init__(self, file: str) -> None:
        self.push = 1.0 if "b" in Path(file).stem else 0.0
        self.about = SimpleNamespace(env_kwargs={"action": "velocity"} if "v" in Path(file).stem else {})

    def predict(
        self,
        observation: Any,
        state: int | None = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[Any, int]:
        assert deterministic
        assert episode_start == (state is None)
        return np.array([self.push, 0, 0], dtype=np.float32), 1 + (state or 0)


def test_each_policy_file_is_a_run_identified_by_its_bytes(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("trundle.experiments.training.policy.load", Still)
    monkeypatch.chdir(tmp_path)
    for name in ("a", "b"):
        (tmp_path / f"{name}.npz").write_text(name)
    curves = tmp_path / "out/tiny/curves"
    curves.mkdir(parents=True)
    points = [{"step": 100.0 * k, "success": k / 10, "distance": 1.0, "return": -2.0} for k in range(1, 7)]
    training = {
        "config": "still",
        "seed": 1,
        "simulated_seconds": 7200,
        "parameters": 1234,
        "flattened": False,
    }
    (curves / "still_1.json").write_text(json.dumps({**training, "curve": points}))
    policy = '[agents.still]\ntitle = "Still"\nkind = "policy"\nfiles = ["a.npz", "b.npz"]\ncurve = "still"\n'
    text = TINY.replace('"adaptive", "fixed"]\n\n[worlds.r', '"adaptive", "still"]\n\n[worlds.r') + policy
    assert compare(tmp_path, text=text) == 0
    mine = [
        (one["run"], one["seed"], one["distance"]) for one in episodes(tmp_path) if one["agent"] == "still"
    ]
    assert [one[:2] for one in mine] == [(run, seed) for run in (0, 1) for seed in (70, 71, 72)]
    assert all(a[2] != b[2] for a, b in zip(mine[:3], mine[3:], strict=True))
    page = (tmp_path / "out/tiny.md").read_text()
    assert "| Still | 1 | 1,234 | 600 | 2.0 h | – | 60 | **no** |" in page
    assert (tmp_path / "out/images/tiny_curves.png").exists()

    before = len(kept(tmp_path))
    (tmp_path / "a.npz").write_text("another")
    assert compare(tmp_path, text=text) == 0
    assert len(kept(tmp_path)) == before + 3

    (tmp_path / "v.npz").write_text("v")
    assert compare(tmp_path, text=text.replace("b.npz", "v.npz")) == 2
    assert 'still in [worlds.table]: v.npz was trained with action = "velocity"' in capsys.readouterr().err
    (tmp_path / "b.npz").unlink()
    assert compare(tmp_path, text=text) == 2


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("samples = 8 }, starts = 1", "samplse = 8 }, starts = 1", "adaptive in [worlds.table]"),
        ('"coulomb_friction"', '"coulomb_fiction"', "fixed in [worlds.rubbing]"),
        ('hidden = "locked"', 'hidden = "lokced"', "lokced"),
    ],
)
def test_unplayable_settings_are_reported_first(
    old: str, new: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert compare(tmp_path, text=TINY.replace(old, new)) == 2
    assert words in capsys.readouterr().err
    assert not (tmp_path / "work").exists()
    assert not (tmp_path / "out").exists()


def test_a_failed_episode_is_reported_and_others_are_kept(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fails_once(worlds: Worlds, agent: Agent, run: int, seed: int) -> Any:
        if (agent.kind, agent.learns, seed) == ("adaptive", True, 71):
            raise trundle.TrundleError("no plan")
        return play(worlds, agent, run, seed)

    with monkeypatch.context() as patched:
        patched.setattr("trundle.experiments.comparison.episode.play", fails_once)
        assert compare(tmp_path) == 2
    reported = capsys.readouterr().err
    assert reported.count("adaptive in table, seed 71, run 0: no plan") == 2  # at once, and at the end
    assert not (tmp_path / "out").exists()
    assert len(kept(tmp_path)) == EPISODES - 1
    assert compare(tmp_path) == 0
    assert results(tmp_path) == results(whole)


def test_missing_results_cannot_be_drawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert compare(tmp_path, "--redraw") == 2
    assert "run without --redraw" in capsys.readouterr().err
