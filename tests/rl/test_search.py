"""`trundle train --search` for trainings. Needs the extra [rl]."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from trundle.cli import main
from trundle.experiments.training import train
from trundle.experiments.training.config import read
from trundle.experiments.training.evaluate import evaluate

TINY = """
format = "trundle-train/1"
algorithm = "PPO"
env = "trundle/PushPoseHard-v1"
seeds = [1]
n_timesteps = 20_480
n_envs = 4
n_steps = 32
batch_size = 32
policy_kwargs = { net_arch = [8] }

[env_kwargs]
horizon = 20

[evaluation]
every = 4096
episodes = 4

[search]
trials = 2
episodes = 5

[search.ranges]
learning_rate = { low = 1e-4, high = 1e-2, log = true, schedule = true }
"policy_kwargs.log_std_init" = { low = -1.5, high = 0.0 }
"""
DYNAMICS = """
format = "trundle-train/1"
algorithm = "Dynamics"
env = "trundle/PushPoseHard-v1"
seeds = [1]
n_timesteps = 81_920
n_steps = 32
n_envs = 8
n_updates = 60
networks = 1
units = 4
rollout = 4

[search]
trials = 1
episodes = 8

[search.ranges]
units = { choices = [2, 3] }
"""


def written(folder: Path, text: str = TINY) -> Path:
    path = folder / "tiny.toml"
    path.write_text(text)
    return path


def rows(out: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (out / "search/tiny.jsonl").read_text().splitlines()]


def one_file(out: Path, name: str) -> Path:
    """Return a file of the only version of the code."""
    (found,) = (out / "work/tiny_search").glob(f"*/{name}")
    return found


def test_each_trial_is_a_short_training_in_the_tuning_worlds(tmp_path: Path) -> None:
    path, out = written(tmp_path), tmp_path / "out"
    assert main(["train", str(path), "--search", "--out", str(out), "--quiet"]) == 0
    found = rows(out)
    assert [row["trial"] for row in found] == [0, 1, 2]
    assert len({row["return"] for row in found}) == 3
    for trial in range(3):
        curve = json.loads(one_file(out, f"curves/tiny_{trial}-999.json").read_text())
        # 1024 steps are 5 % of the training.
        assert curve["steps"] == 1024
        assert curve["curve"][-1]["return"] == found[trial]["return"]
    page = (out / "search/tiny.md").read_text()
    assert "A trial trains for 1,024 steps, 5% of the training." in page
    assert not (out / "policies").exists()


def test_an_interrupted_search_continues(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = written(tmp_path)
    line = ["train", str(path), "--search", "--quiet", "--out"]
    assert main([*line, str(tmp_path / "whole")]) == 0
    looks: list[Any] = []

    def look(*arguments: Any) -> Any:
        looks.append(arguments[3:])
        if len(looks) == 4:
            raise KeyboardInterrupt
        return evaluate(*arguments)

    monkeypatch.setattr(train, "evaluate", look)
    assert main([*line, str(tmp_path / "parts")]) != 0
    assert main([*line, str(tmp_path / "parts")]) == 0
    assert rows(tmp_path / "whole") == rows(tmp_path / "parts")
    # Each trial is evaluated at its start and its end, one of them again.
    assert set(looks) == {(700_000, 5)}
    assert len(looks) in (7, 8)


def test_a_search_tunes_dynamics_models(tmp_path: Path) -> None:
    path, out = written(tmp_path, DYNAMICS), tmp_path / "out"
    assert main(["train", str(path), "--search", "--out", str(out), "--quiet"]) == 0
    found = rows(out)
    assert found[0]["distance"] != found[1]["distance"]
    assert all(row["score"] == -row["distance"] for row in found)
    model = json.loads(one_file(out, "dynamics/tiny_1-999.json").read_text())
    assert model["updates"] == 3


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("learning_rate = {", "learning_rates = {", "unknown key `learning_rates`"),
        ("seeds = [1]", "seeds = [999]", "999 is that of a search"),
        ("every = 4096", "every = 4096\nfirst = 699_998", "worlds of the evaluations"),
        ("horizon = 20", 'split = "test"', "a search uses training objects"),
    ],
)
def test_invalid_searches_are_refused(
    old: str, new: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path, TINY.replace(old, new))
    assert main(["train", str(path), "--search", "--out", str(tmp_path / "out")]) == 2
    assert message in capsys.readouterr().err


def test_ranges_do_not_change_the_digest_of_a_training(tmp_path: Path) -> None:
    with_ranges = written(tmp_path)
    without = tmp_path / "without.toml"
    without.write_text(TINY[: TINY.index("[search]")])
    assert read(without).digest == read(with_ranges).digest
