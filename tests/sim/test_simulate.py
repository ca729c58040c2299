"""`trundle simulate`: recordings from scenarios."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import trundle
from trundle.cli import main

CONFIGS = Path(__file__).parents[2] / "configs"
DEMO = CONFIGS / "experiments" / "demo.toml"


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def changed(tmp_path: Path, old: str, new: str) -> Path:
    """Return the demo's scenario with a change, next to its object."""
    for folder in ("experiments", "objects"):
        (tmp_path / folder).mkdir()
    table = CONFIGS / "objects" / "office_table.toml"
    (tmp_path / "objects" / "office_table.toml").write_text(table.read_text())
    scenario = tmp_path / "experiments" / "scenario.toml"
    assert old in DEMO.read_text()
    scenario.write_text(DEMO.read_text().replace(old, new))
    return scenario


@pytest.mark.parametrize("table", ["csv", "parquet"])
def test_the_same_seed_gives_the_same_bytes(
    tmp_path: Path, table: str, capsys: pytest.CaptureFixture[str]
) -> None:
    def simulate(name: str, seed: int) -> dict[str, bytes]:
        out = tmp_path / name
        assert main(["simulate", str(DEMO), "--out", str(out), "--seed", str(seed), "--table", table]) == 0
        return contents(out)

    once = simulate("a", 3)
    assert once == simulate("b", 3)
    assert once != simulate("c", 4)
    assert "8 episodes, 2 held out" in capsys.readouterr().out
    assert trundle.read(tmp_path / "a") == trundle.simulate(DEMO, seed=3)


def test_the_recording_does_not_contain_the_hidden_effect() -> None:
    recording = trundle.simulate(DEMO)
    text = repr(recording.metadata)
    for effect in trundle.effects():
        assert effect["kind"] not in text and effect["effect"] not in text
    assert "mass" not in recording.metadata["object"]


def test_the_demo_has_enough_motion() -> None:
    recording = trundle.simulate(DEMO)
    errors = [finding for finding in trundle.check(recording) if finding.severity == "error"]
    assert errors == []
    for columns in recording.episodes.values():
        poses = np.column_stack([columns["object_x"], columns["object_y"]])
        poses = poses[np.isfinite(poses[:, 0])]
        assert np.linalg.norm(np.ptp(poses, axis=0)) > 0.1


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("held_out = 2", "hold_out = 2", ["scenario.toml", "hold_out", "held_out"]),
        ("force = 14.0", "farce = 14.0", ["scenario.toml", "farce", "static_force"]),
        ("rate = 125.0", "rate = 0.0", ["scenario.toml", "sensor.rate = 0", "positive"]),
        ("office_table", "no_table", ["no_table.toml", "cannot be read"]),
        ("count = 8", "count = -8", ["scenario.toml", "-8"]),
    ],
)
def test_an_invalid_scenario_is_refused(
    tmp_path: Path, old: str, new: str, words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    scenario = changed(tmp_path, old, new)
    assert main(["simulate", str(scenario), "--out", str(tmp_path / "out")]) == 2
    message = capsys.readouterr().err
    for word in words:
        assert word in message
    assert not (tmp_path / "out").exists()


def test_pushes_can_be_listed_in_a_scenario(tmp_path: Path) -> None:
    push = """
[[push]]
grasp = [-0.6, 0.0, 0.0]
drive = "force"
knots = [[0.0, 0.0, 0.0, 0.0], [0.5, 30.0, 0.0, 0.0], [2.0, 30.0, 0.0, 0.0]]
[sensor]
"""
    recording = trundle.simulate(changed(tmp_path, "[sensor]", push))
    assert len(recording.episodes) == 9
    force = recording.episodes["episode_00"]["force_x"]
    late = force[recording.episodes["episode_00"]["t"] > 1.0]
    assert np.nanmean(late) == pytest.approx(30.0 + 1.7, abs=0.2)
