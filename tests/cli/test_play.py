"""`trundle play`: episodes end, are drawn and saved; invalid input is refused without output."""

from pathlib import Path

import pytest
from PIL import Image

import trundle
from trundle.cli import main
from trundle.envs.ids import flat_id, flat_ids


def test_episodes_are_printed_drawn_and_saved(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    gif, folder = tmp_path / "door.gif", tmp_path / "door"
    line = f"play PushDoor --episodes 2 --set horizon=12 --set object=desk --gif {gif} --out {folder}"
    assert main(line.split()) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [words.split(":")[0] for words in lines[:2]] == ["episode 0", "episode 1"]
    with Image.open(gif) as film:
        assert film.size == (480, 480) and getattr(film, "n_frames", 1) > 8
    recording = trundle.read(folder)
    assert len(recording.episodes) == 2 and len(recording.metadata["scene"]["obstacle"]) == 2


def test_the_same_seed_plays_the_same_episode(capsys: pytest.CaptureFixture[str]) -> None:
    def played(seed: int) -> str:
        assert main(f"play PushPose --set action=push --set horizon=5 --seed {seed}".split()) == 0
        return capsys.readouterr().out

    assert played(1) == played(1) != played(2)


@pytest.mark.parametrize("task", ["PushDoorHard", "PushDoor-v1", "PushDoorEasy-v1"])
def test_levels_and_versions_are_played(task: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(f"play {task} --set horizon=5".split()) == 0
    assert "episode 0: time up after 0.2 s" in capsys.readouterr().out


def test_names_without_a_version_are_the_first_one() -> None:
    assert flat_id("PushDoor") == "trundle/PushDoor-v0"
    assert flat_id("PushDoorHard") == flat_id("PushDoorHard-v1") == "trundle/PushDoorHard-v1"
    assert [flat_id(name) for name in ("PushDoorGoal", "PushDoor-v9", "LockedWheelHard")] == [None] * 3
    assert len(flat_ids()) == 2 * 5 + 3 * 4


def test_the_adaptive_agent_is_better_than_random(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["play", "LockedWheel", "--agent", "adaptive", "--seed", "3"]) == 0
    assert "goal reached" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("play PushSofa", "PushDoor"),
        ("play PushPose --set noise", "NAME=VALUE"),
        ("play PushPose --set nois=1", "nois"),
        ("play PushPose --set object=piano", "kitchen_table"),
        ("play PushPose --gif film.mp4", ".gif"),
        ("play PushPose --episodes 0", "at least one"),
        ("play PushPose --agent adaptive --set action=push", "wrench"),
        ("play PushPose --gif missing/film.gif", "missing"),
    ],
)
def test_invalid_arguments_are_refused(
    line: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(line.split()) == 2
    assert words in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
