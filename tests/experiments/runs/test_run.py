"""Runs continue after a kill at any time, with the same bytes in the end."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import trundle
from tests.command import interruptible
from trundle.cli import main
from trundle.experiments.runs import run_closed_loop

CONFIG = """format = "trundle-run/1"
environment = "trundle/PushAround-v0"
seed = {seed}
episodes = {episodes}
[arguments]
hidden = "locked"
horizon = {horizon}
[agent]
push = 0.3
"""


@pytest.fixture
def config(tmp_path: Path) -> Path:
    return written(tmp_path, episodes=2)


def written(folder: Path, episodes: int = 1, seed: int = 3, horizon: int = 14) -> Path:
    path = folder / "run.toml"
    path.write_text(CONFIG.format(episodes=episodes, seed=seed, horizon=horizon), encoding="utf-8")
    return path


def contents(folder: Path) -> dict[str, bytes]:
    """Return every file below a folder, including hidden ones."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def run(config: Path, out: Path, *more: str) -> int:
    return main(["run", str(config), "--out", str(out), *more])


def test_a_run_prints_saves_and_shows(
    config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert run(config, out) == 0
    reported = capsys.readouterr()
    assert [line.split(":")[0] for line in reported.out.splitlines()] == [
        "episode 0",
        "episode 1",
        f"{out}/page.html",
    ]
    lines = len([line for line in reported.err.splitlines() if "m to go" in line])
    kept = json.loads((out / "episode_00" / "history.json").read_text(encoding="utf-8"))
    other = json.loads((out / "episode_01" / "history.json").read_text(encoding="utf-8"))
    assert len(kept["steps"]) == 14 and len(kept["updates"]) >= 2
    # A line every 0.25 s.
    assert 2 <= lines < len(kept["updates"]) + len(other["updates"])
    assert kept["truth"]["effect"][0]["kind"] == "viscous_wheel"
    recording = trundle.read(out / "episode_01" / "recording")
    assert list(recording.episodes) == ["episode_00"]
    assert recording.episodes["episode_00"]["t"][-1] == pytest.approx(0.4 + 0.7, abs=0.02)


@pytest.mark.slow
def test_a_random_object_can_be_run(tmp_path: Path) -> None:
    config = written(tmp_path, episodes=2)
    text = config.read_text(encoding="utf-8").replace("[agent]", 'object = "household"\n[agent]')
    config.write_text(text.replace("PushAround", "PushDoor"), encoding="utf-8")
    assert run(config, tmp_path / "out", "--quiet") == 0
    kept = [json.loads(path.read_text()) for path in sorted((tmp_path / "out").rglob("history.json"))]
    assert [each["seed"] for each in kept] == [3, 4]
    assert kept[0]["object"] != kept[1]["object"]
    assert len(kept[0]["scene"]["obstacle"]) == 2


def test_quiet_prints_only_the_answer(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(written(tmp_path), tmp_path / "out", "--quiet") == 0
    assert capsys.readouterr().err == ""


def test_an_episode_depends_on_its_seed_only(tmp_path: Path) -> None:
    assert run(written(tmp_path, episodes=2, seed=3), tmp_path / "two", "--quiet") == 0
    assert run(written(tmp_path, episodes=1, seed=4), tmp_path / "one", "--quiet") == 0
    second, alone = contents(tmp_path / "two" / "episode_01"), contents(tmp_path / "one" / "episode_00")
    assert second == alone


@pytest.mark.slow
def test_an_interrupted_episode_is_repeated(config: Path, tmp_path: Path) -> None:
    whole, torn = tmp_path / "whole", tmp_path / "torn"
    assert run(config, whole, "--quiet") == 0
    assert run(config, torn, "--quiet") == 0
    (torn / "page.html").unlink()
    (torn / ".page.html.123.part").write_text("half a pa")
    (torn / "episode_01" / "history.json").rename(torn / "episode_01" / ".history.json.123.part")
    (torn / "episode_01" / "recording" / "episode_00.csv").write_text("t,obj")
    assert run(config, torn, "--quiet") == 0
    assert contents(torn) == contents(whole)


def test_a_killed_run_continues_with_the_same_result(tmp_path: Path) -> None:
    config = written(tmp_path, episodes=3, horizon=24)
    torn, whole = tmp_path / "torn", tmp_path / "whole"
    line = [sys.executable, "-m", "trundle", "run", str(config), "--quiet", "--out"]
    first = torn / "episode_00" / "history.json"
    with subprocess.Popen([*line, str(torn)], stdout=subprocess.DEVNULL) as process:
        until(first.exists, process)
        process.send_signal(signal.SIGKILL)
    assert not (torn / "page.html").exists()
    before = os.stat(first).st_mtime_ns
    assert run(config, torn, "--quiet") == 0
    assert os.stat(first).st_mtime_ns == before
    assert run(config, whole, "--quiet") == 0
    assert contents(torn) == contents(whole)


def until(there: object, process: subprocess.Popen[bytes]) -> None:
    """Wait until a path exists, while a process runs."""
    assert callable(there)
    ends = time.monotonic() + 60
    while not there():
        assert process.poll() is None and time.monotonic() < ends
        time.sleep(0.002)


def test_ctrl_c_prints_interrupted(tmp_path: Path) -> None:
    config = written(tmp_path, episodes=50, horizon=60)
    out = tmp_path / "out"
    with interruptible([sys.executable, "-m", "trundle", "run", str(config), "--out", str(out)]) as process:
        assert process.stderr is not None
        process.stderr.readline()
        process.send_signal(signal.SIGINT)
        _, complaint = process.communicate(timeout=20)
    assert process.returncode == 130
    assert complaint.splitlines()[-1] == "trundle: interrupted"
    assert "Traceback" not in complaint
    assert not (out / "page.html").exists()


def test_the_folder_of_another_run_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    assert run(written(tmp_path), out, "--quiet") == 0
    before = contents(out)
    capsys.readouterr()
    assert run(written(tmp_path, seed=4), out, "--quiet") == 2
    assert "other settings" in capsys.readouterr().err
    assert contents(out) == before


def test_an_unrelated_folder_is_not_changed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    (out / "episode_00").mkdir(parents=True)
    (out / "episode_00" / "thesis.tex").write_text("dear")
    assert run(written(tmp_path), out, "--quiet") == 2
    assert "holds no run" in capsys.readouterr().err
    assert contents(out) == {"episode_00/thesis.tex": b"dear"}


def test_a_damaged_history_is_named(tmp_path: Path) -> None:
    config, out = written(tmp_path), tmp_path / "out"
    assert run(config, out, "--quiet") == 0
    (out / "episode_00" / "history.json").write_text("{", encoding="utf-8")
    with pytest.raises(trundle.TrundleError, match=r"history\.json: is damaged"):
        run_closed_loop(config, out, quiet=True)
