"""`trundle train`: an invalid file is refused before training. Does not require torch."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import trundle
from trundle.cli import main
from trundle.envs import Observation
from trundle.experiments.training import policy
from trundle.experiments.training.card import model_card
from trundle.experiments.training.config import Dynamics, read
from trundle.experiments.training.frames import to_object_frame
from trundle.experiments.training.network import Network
from trundle.experiments.training.policy import About, Policy

FILES = sorted((Path(__file__).resolve().parents[2] / "configs" / "rl").glob("*.toml"))
CONFIGS = [file for file in FILES if file.stem != "hard_planner" and "dynamics" not in file.stem]
"""Trainings of policies."""
GOOD = """
format = "trundle-train/1"
algorithm = "PPO"
env = "trundle/PushAround-v0"
n_timesteps = 1000
seeds = [1, 2]
learning_rate = "lin_0.001"
gamma = 1
"""


@pytest.mark.parametrize("file", CONFIGS, ids=lambda file: file.stem)
def test_training_budgets_and_seed_ranges(file: Path) -> None:
    settings = read(file)
    on_policy = settings.algorithm in ("PPO", "RecurrentPPO", "RMA")
    assert settings.n_timesteps >= (2_000_000 if on_policy else 300_000) and len(settings.seeds) >= 2
    # Comparisons use seeds below 200000, trainings those from a million on.
    assert 200_000 <= settings.evaluation.first < 1_000_000 - settings.evaluation.episodes


def test_dynamics_models_differ_in_their_memory_only() -> None:
    with_memory, without = (read(file) for file in FILES if "dynamics" in file.stem)
    assert isinstance(with_memory, Dynamics)
    assert with_memory.units > 0
    assert replace(with_memory, name=without.name, units=0) == without


@pytest.mark.parametrize("level", ["", "hard_"])
def test_compared_policies_have_the_same_task(level: str) -> None:
    # Hindsight replay has a sparse reward on the goal-conditioned task.
    files = [file for file in CONFIGS if file.stem != "hard_her"]
    around = [read(file) for file in files if file.stem.startswith("hard_") == bool(level)]
    assert len(around) >= 3
    # The reward of the training may have another cost of contact than the comparison.
    tasks = [{key: value for key, value in one.env_kwargs.items() if key != "touch_cost"} for one in around]
    assert len({(one.env, str(task), one.frame) for one, task in zip(around, tasks, strict=True)}) == 1
    # Only the shaping costs of losing the object and of detours differ between algorithms.
    shaped = [one for one in around if one.algorithm != "RMA"]  # it learns from no reward
    assert len({replace(one.aids, loss_cost=0.0, detour_cost=0.0) for one in shaped}) == 1


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("gamma = 1", "gama = 1", "unknown key `gama`; did you mean `gamma`"),
        ("gamma = 1", "tau = 0.1", "unknown key `tau`"),
        ("gamma = 1", "hyperparameters = {gamma = 1}", "unknown key `hyperparameters`"),
        ("gamma = 1", 'gamma = "high"', "`gamma` = 'high'; it is a number"),
        ("gamma = 1", "n_envs = 0", "`n_envs` = 0; it is a whole number of at least 1"),
        ("gamma = 1", "n_steps = true", "`n_steps` = True; it is a whole number"),
        ("gamma = 1", 'frame = "gripper"', "it is one of 'world', 'object'"),
        ("gamma = 1", 'policy_kwargs = {net_arch = ["wide"]}', "`policy_kwargs.net_arch[0]` = 'wide'"),
        ("gamma = 1", "policy_kwargs = {width = 3}", "unknown key `policy_kwargs.width`"),
        ("gamma = 1", "aids = {bonus = 3}", "unknown key `aids.bonus`; known are `success_bonus`"),
        ("gamma = 1", "evaluation = {episodes = 2.5}", "`evaluation.episodes` = 2.5; it is a whole number"),
        ("gamma = 1", 'policy = "CnnPolicy"', "`policy` = 'CnnPolicy'; it is 'MlpPolicy'"),
        ("gamma = 1", "gamma = 5.0", "`gamma` = 5.0; it is a number from 0 to 1"),
        ('"PPO"', '"SAC"\nent_coef = "atuo"', "`ent_coef` = 'atuo'; it is a number or \"auto\""),
        (
            '"PPO"',
            '"SAC"\ntarget_entropy = "auto_1"',
            "`target_entropy` = 'auto_1'; it is a number or 'auto'",
        ),
        ("gamma = 1", "batch_size = 0", "`batch_size` = 0; it is a whole number of at least 1"),
        ("gamma = 1", "env_kwargs = {horizon = 0}", "horizon is not 0: an episode must end"),
        ("gamma = 1", "evaluation = {first = 999_950}", "first = 999950: give 0 to 999900"),
        ("n_timesteps = 1000", "", "`n_timesteps` is missing"),
        (
            "gamma = 1",
            "aids = {touch_ramp = [0.5, 0.2]}",
            "touch_ramp = [0.5, 0.2]: give two shares in order",
        ),
        (
            "gamma = 1",
            "aids = {touch_ramp = [0.2, 0.5]}",
            "touch_ramp: trundle/PushAround-v0 does not report",
        ),
        (
            "gamma = 1",
            "aids = {detour_cost = 1.0}",
            "detour_cost: trundle/PushAround-v0 does not observe",
        ),
        (
            'PushAround-v0"',
            'PushPose-v1"\naids = {detour_cost = 1.0}',
            "detour_cost: trundle/PushPose-v1 does not observe",
        ),
        ('"PPO"', '"RMA"\nteacher = "a.npz"', "RMA needs privileged = true"),
        ('"lin_0.001"', '"cos_0.001"', "`learning_rate` = 'cos_0.001'; it is a number or \"lin_0.001\""),
        ('"PPO"', '"TD3"', "algorithm = 'TD3': choose PPO, RecurrentPPO, RMA, SAC, TQC"),
        ("PushAround-v0", "PushSofa-v0", "such as trundle/PushAroundHard-v1"),
        ("[1, 2]", "[0]", "`seeds[0]` = 0; it is a whole number from 1 to 999"),
        ("trundle-train/1", "trundle-train/9", 'must begin with format = "trundle-train/1"'),
    ],
)
def test_invalid_settings_are_named(
    old: str, new: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "bad.toml"
    file.write_text(GOOD.replace(old, new))
    assert main(["train", str(file), "--out", str(tmp_path / "out")]) == 2
    complaint = capsys.readouterr().err
    assert str(file) in complaint and words in complaint
    assert list(tmp_path.iterdir()) == [file]


def test_an_unknown_device_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("sb3_contrib", reason="sb3-contrib is not installed")
    file = tmp_path / "good.toml"
    file.write_text(GOOD)
    assert main(["train", str(file), "--out", str(tmp_path / "out"), "--device", "gpu"]) == 2
    assert "--device gpu: give cpu, cuda or auto" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [file]


def test_a_card_states_what_a_policy_sees_and_whether_it_converged(tmp_path: Path) -> None:
    file = tmp_path / "good.toml"
    file.write_text(GOOD)
    about = invented(frame_stack=4, hidden=10, squashed=True).about
    last = {"success": 0.9, "untouched": 0.625, "lost": 0.0}
    result = {"curve": [last], "parameters": 1234, "simulated_seconds": 7200.0, "flattened": False}
    card = model_card(read(file), about, result, "2.15.0 on cpu")
    assert "the last 4 observations with 10 hidden parameters" in card
    assert "hyperbolic tangent" in card and "no: the curve still improved" in card
    assert "reached the goal in 90.0 %, without\ntouching an obstacle in 62.5 %" in card


def test_a_missing_extra_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "good.toml"
    file.write_text(GOOD)
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    assert main(["train", str(file), "--out", str(tmp_path / "out")]) == 2
    assert "pip install 'trundle[rl]'" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [file]


def test_a_seed_outside_the_settings_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "good.toml"
    file.write_text(GOOD)
    assert main(["train", str(file), "--out", str(tmp_path / "out"), "--seed", "3"]) == 2
    assert "--seed 3: the seeds in CONFIG are 1, 2" in capsys.readouterr().err


def test_observations_are_invariant_to_the_frame_of_the_world() -> None:
    """In the frame of the object, a rotated and translated world differs in its pose only."""
    env = gym.make("trundle/PushAround-v0", object="random")
    seen = np.array([env.reset(seed=seed)[0] for seed in range(6)])
    turn, shift = 0.7, np.array([0.3, -0.2])
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    here, moved = Observation(seen), Observation(seen.copy())
    for point in (moved.position, moved.goal_position, moved.box_position):
        point[:] = point @ rotation.T + shift
    for vector in (moved.direction, moved.velocity, moved.goal_direction, moved.box_direction):
        vector[:] = vector @ rotation.T
    one, other = (to_object_frame(rows.vector, "trundle/PushAround-v0") for rows in (here, moved))
    assert np.allclose(one[:, 4:], other[:, 4:])
    assert not np.allclose(Observation(one).position, Observation(other).position)
    # The goal in the frame of the object, and its saturated entries.
    way = here.goal_position - here.position
    ahead = np.sum(way * here.direction, axis=1)
    assert np.allclose(Observation(one).goal_position[:, 0], ahead)
    assert np.allclose(one[:, -3], ahead / (np.linalg.norm(way, axis=1) + 0.1))


def invented(**changed: Any) -> Policy:
    """Return an untrained policy of the pose task with two stacked observations."""
    random = np.random.default_rng(0)
    about: dict[str, Any] = {
        "config": "invented", "digest": "0", "algorithm": "PPO", "seed": 1, "steps": 0,
        "env": "trundle/PushPose-v0", "env_kwargs": {"horizon": 10}, "entries": 16, "frame": "world",
        "frame_stack": 2, "activation": "tanh", "squashed": False, "clip_obs": 10.0,
    }  # fmt: skip
    layers = [
        (random.normal(size=(rows, columns)).astype(np.float32), np.zeros(rows, dtype=np.float32))
        for rows, columns in ((5, 32), (3, 5))
    ]
    return Policy(About(**{**about, **changed}), np.zeros(32), np.ones(32), Network(layers, "tanh"))


def test_a_policy_is_restored_from_its_file(tmp_path: Path) -> None:
    seen = np.random.default_rng(1).normal(size=(4, 16))
    invented().save(tmp_path / "one.npz")
    read_again = policy.load(tmp_path / "one.npz")
    read_again.save(tmp_path / "two.npz")
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "two.npz").read_bytes()
    assert read_again.about == invented().about
    assert np.array_equal(read_again.predict(seen)[0], invented().predict(seen)[0])
    assert sorted(file.name for file in tmp_path.iterdir()) == ["one.npz", "two.npz"]


def test_a_policy_keeps_observations_until_the_next_episode() -> None:
    player, random = invented(), np.random.default_rng(2)
    first, second = random.normal(size=(2, 3, 16))
    anew, state = player.predict(first)
    assert anew.shape == (3, 3) and state.shape == (3, 2, 16)
    with_past, _ = player.predict(second, state)
    alone, _ = player.predict(second)
    some, _ = player.predict(second, state, episode_start=np.array([True, False, True]))
    assert not np.allclose(with_past, alone)
    assert np.array_equal(some[[0, 2]], alone[[0, 2]]) and np.array_equal(some[1], with_past[1])
    # A single environment gives the same as a row of a batch.
    one, state = player.predict(second[1])
    assert one.shape == (3,) and np.allclose(one, alone[1])


def test_actions_are_within_bounds() -> None:
    seen = 100 * np.random.default_rng(3).normal(size=(50, 16))
    cut, squashed = (invented(squashed=way).predict(seen)[0] for way in (False, True))
    assert np.abs(cut).max() == 1 and np.allclose(squashed[np.abs(cut) < 1], np.tanh(cut[np.abs(cut) < 1]))


def test_observations_of_other_environments_are_refused() -> None:
    with pytest.raises(trundle.TrundleError, match=r"shape \(22,\).*trundle/PushPose-v0.*16 entries"):
        invented().predict(np.zeros(22))


def test_a_file_without_a_policy_is_named(tmp_path: Path) -> None:
    file = tmp_path / "policy.npz"
    for content in (b"", b"no policy", b"PK\x03\x04 damaged"):
        file.write_bytes(content)
        with pytest.raises(trundle.TrundleError, match="not a policy"):
            policy.load(file)
    np.savez(file, about="{}")
    with pytest.raises(trundle.TrundleError, match="not a policy"):
        policy.load(file)


def test_play_runs_a_policy(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = str(tmp_path / "policy.npz")
    invented().save(Path(file))
    assert main(["play", "PushPose", "--agent", file, "--episodes", "2"]) == 0
    assert capsys.readouterr().out.count(" after 0.5 s") == 2
    assert main(["play", "PushPose", "--agent", file, "--set", "horizon=20"]) == 0
    assert " after 1.0 s" in capsys.readouterr().out
    assert main(["play", "PushAround", "--agent", file]) == 2
    assert "was trained in trundle/PushPose-v0" in capsys.readouterr().err
    assert main(["play", "PushAround", "--agent", "clever"]) == 2
    assert "choose random, adaptive or the .npz file of a policy" in capsys.readouterr().err
