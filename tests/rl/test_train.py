"""Training with stable-baselines3, with interruptions. Needs the extra [rl]."""

import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch

from trundle import TrundleError
from trundle.cli import main
from trundle.envs.oracle import VectorOracle
from trundle.experiments.training import policy, train
from trundle.experiments.training.config import read
from trundle.experiments.training.evaluate import evaluate
from trundle.experiments.training.networks import algorithm, exported
from trundle.experiments.training.settings import Settings
from trundle.experiments.training.train import Training, has_flattened
from trundle.experiments.training.worlds import Worlds, make_worlds

ROOT = Path(__file__).resolve().parents[2]
TASK = "trundle/PushAround-v0"
SHARED = f"""
format = "trundle-train/1"
env = "{TASK}"
env_kwargs = {{hidden = "locked", object = ["office_table", "random"], horizon = 30}}
seeds = [1, 2]
n_envs = 4
frame = "object"
checkpoint_every = 400
policy_kwargs = {{net_arch = [8]}}
aids = {{success_bonus = 10.0, loss_cost = 20.0, miss_cost = 2.0, turn_cost = 0.5}}
evaluation = {{every = 150, episodes = 3, first = 500000}}
"""
PPO = """
algorithm = "PPO"
n_timesteps = 1024
frame_stack = 3
n_steps = 16
batch_size = 64
n_epochs = 2
learning_rate = "lin_0.01"
"""
SAC = """
algorithm = "SAC"
n_timesteps = 1200
learning_starts = 500
buffer_size = 800
batch_size = 16
train_freq = 4
gradient_steps = 2
n_steps = 3
"""
PRIVILEGED = PPO.replace("frame_stack = 3", "privileged = true")
RECURRENT = (
    PPO.replace('"PPO"', '"RecurrentPPO"').replace("frame_stack = 3", 'policy = "MlpLstmPolicy"')
    + "policy_kwargs = {net_arch = [8], lstm_hidden_size = 6}\n"
)
TQC = SAC.replace('"SAC"', '"TQC"')
CROSSQ = SAC.replace('"SAC"', '"CrossQ"').replace("learning_starts = 500", "learning_starts = 100")
HER = """
algorithm = "HER"
n_timesteps = 2400
learning_starts = 500
buffer_size = 1600
batch_size = 16
train_freq = 4
gradient_steps = 2
"""
RMA = """
algorithm = "RMA"
n_timesteps = 1024
privileged = true
normalize = false
n_steps = 16
units = 5
"""
ALGORITHMS = pytest.mark.parametrize(
    "own",
    [PPO, PRIVILEGED, RECURRENT, RMA, SAC, TQC, CROSSQ, HER],
    ids=["PPO", "privileged", "recurrent", "RMA", "SAC", "TQC", "CrossQ", "HER"],
)


class KilledError(Exception):
    """Represents a kill."""


def written(folder: Path, own: str) -> Path:
    """Write a training's file, and for RMA a teacher."""
    path, shared = folder / "tiny.toml", SHARED
    if "policy_kwargs" in own:
        shared = SHARED.replace("policy_kwargs = {net_arch = [8]}\n", "")
    if own == HER:
        shared = "\n".join(line for line in SHARED.splitlines() if not line.startswith(("frame", "aids")))
    if own == RMA:
        shared = SHARED.replace("policy_kwargs = {net_arch = [8]}\n", "")
        settings, learner, worlds = learnt(folder, PRIVILEGED)
        exported(settings, 1, learner, worlds).save(folder / "teacher-1.npz")
        own += f'teacher = "{folder.as_posix()}/teacher-{{seed}}.npz"\n'
    path.write_text(own + shared)
    return path


def results(folder: Path) -> dict[str, bytes]:
    return {
        file.name: file.read_bytes() for kind in ("policies", "curves") for file in (folder / kind).iterdir()
    }


@ALGORITHMS
def test_an_interrupted_training_ends_with_the_same_bytes(
    own: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    interrupt_twice(read(written(tmp_path, own)), tmp_path, monkeypatch)


def test_an_interrupted_training_with_detours_ends_with_the_same_bytes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    interrupt_twice(read(with_detours(tmp_path, PPO)), tmp_path, monkeypatch)


def interrupt_twice(settings: Settings, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Compare a training with one that is killed in two evaluations and continued."""
    Training(settings, 1, folder / "whole").run()
    looks = 0

    def look(*arguments: Any) -> dict[str, float]:
        nonlocal looks
        looks += 1
        if looks in (5, 9):
            raise KilledError
        return evaluate(*arguments)

    monkeypatch.setattr(train, "evaluate", look)
    for _ in range(2):
        training = Training(settings, 1, folder / "parts")
        with pytest.raises(KilledError):
            training.run()
        assert training.checkpoint_file.exists()
    Training(settings, 1, folder / "parts").run()
    assert looks > 10
    assert results(folder / "whole") == results(folder / "parts")
    assert not training.checkpoint_file.exists()


def test_a_killed_training_continues(tmp_path: Path) -> None:
    file = written(tmp_path, PPO.replace("1024", "4096"))
    line = [sys.executable, "-m", "trundle", "train", str(file), "--seed", "2", "--quiet", "--out"]
    checkpoint = tmp_path / "killed" / "work" / "tiny-2" / "checkpoint.pickle"
    killed = subprocess.Popen([*line, str(tmp_path / "killed")], cwd=ROOT)
    while killed.poll() is None and not checkpoint.exists():
        time.sleep(0.005)
    killed.kill()
    assert killed.wait() == -signal.SIGKILL
    assert checkpoint.exists(), "it had ended"
    subprocess.run([*line, str(tmp_path / "killed")], cwd=ROOT, check=True)
    Training(read(file), 2, tmp_path / "whole").run()
    assert results(tmp_path / "whole") == results(tmp_path / "killed")


def test_a_finished_training_is_not_repeated(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = written(tmp_path, PPO)
    line = ["train", str(file), "--out", str(tmp_path / "out"), "--seed", "1"]
    assert main(line) == 0
    first, kept = capsys.readouterr().out, {p: p.stat().st_mtime_ns for p in tmp_path.rglob("*")}
    report = r"tiny-1\.npz: success \d+%, \d\.\d\d m from the goal after 1,024 steps, 51 s of pushing"
    assert re.search(report, first)
    assert main(line) == 0
    assert capsys.readouterr().out == first
    assert {p: p.stat().st_mtime_ns for p in tmp_path.rglob("*")} == kept
    file.write_text(file.read_text().replace("n_epochs = 2", "n_epochs = 3"))
    assert main(line) == 2
    assert "other settings" in capsys.readouterr().err


def test_tensorboard_files_are_written(tmp_path: Path) -> None:
    pytest.importorskip("tensorboard", reason="TensorBoard is not installed")
    Training(read(written(tmp_path, PPO)), 1, tmp_path / "out").run()
    assert list((tmp_path / "out" / "work" / "tiny-1").glob("events.out.tfevents.*"))


def learnt(tmp_path: Path, own: str) -> tuple[Settings, Any, Worlds]:
    settings = read(written(tmp_path, own))
    worlds = make_worlds(settings)
    learner = algorithm(settings, 1, worlds)
    learner.learn(512)
    return settings, learner, worlds


@pytest.mark.parametrize(
    "own",
    [PPO, PRIVILEGED, RECURRENT, SAC, TQC, CROSSQ, HER],
    ids=["PPO", "privileged", "recurrent", "SAC", "TQC", "CrossQ", "HER"],
)
def test_a_policy_acts_like_its_network(own: str, tmp_path: Path) -> None:
    settings, learner, worlds = learnt(tmp_path, own)
    exported(settings, 1, learner, worlds).save(tmp_path / "policy.npz")
    acting = policy.load(tmp_path / "policy.npz")
    # The network is shown what went through every layer of the training, the policy what the world tells.
    assert worlds.normalize is not None
    worlds.normalize.training = False
    worlds.batch.seed(7)
    shown = worlds.top.reset()
    plain: Any = gym.make_vec(TASK, 4, "vector_entry_point", autoreset_mode="Disabled", **settings.env_kwargs)
    plain = VectorOracle(plain) if settings.privileged else plain
    bare, state, begun, memory = plain.reset(seed=7)[0], None, np.ones(4, dtype=bool), None
    for _ in range(65):
        expected, memory = learner.predict(shown, memory, episode_start=begun, deterministic=True)
        actions, state = acting.predict(bare, state, begun)
        assert np.allclose(actions, expected, atol=1e-5)
        shown, _, begun, _ = worlds.top.step(expected)
        bare, *_ = plain.step(expected)
        if begun.any():
            bare = plain.reset(options={"reset_mask": begun.copy()})[0]


def test_rapid_motor_adaptation_acts_on_its_estimates(tmp_path: Path) -> None:
    settings, learner, worlds = learnt(tmp_path, RMA)
    acting = exported(settings, 1, learner, worlds)
    assert (acting.about.hidden, acting.about.entries) == (0, worlds.batch.observation_space.shape[0] - 10)
    teacher = policy.load(tmp_path / "teacher-1.npz")
    plain: Any = gym.make_vec(TASK, 4, "vector_entry_point", autoreset_mode="Disabled", **settings.env_kwargs)
    bare, _ = plain.reset(seed=7)
    values = torch.as_tensor(worlds.monitor.venv._convert(VectorOracle(plain).observations(bare)))
    seen = learner._normalised(values.numpy())[:, :-10]
    zeros = torch.zeros(1, 4, 5)
    with torch.no_grad():
        estimate, _ = learner.policy(seen, torch.ones(4), (zeros, zeros))
    estimated = estimate.numpy() * teacher.deviation[-10:] + teacher.mean[-10:]
    expected, _ = teacher.predict(np.concatenate([bare, estimated], axis=1))
    assert np.allclose(acting.predict(bare)[0], expected, atol=1e-5)


def test_the_memory_learns_the_hidden_parameters(tmp_path: Path) -> None:
    file = written(tmp_path, RMA)
    file.write_text("learning_rate = 0.01\n" + file.read_text().replace("n_envs = 4", "n_envs = 64"))
    settings = read(file)
    learner: Any = algorithm(settings, 1, make_worlds(settings))
    logged: dict[str, list[float]] = {}
    learner.set_logger(SimpleNamespace(record=lambda key, value: logged.setdefault(key, []).append(value)))
    learner.learn(32_768)
    losses = logged["train/loss"]
    assert np.mean(losses[-8:]) < 0.7 * np.mean(losses[:2])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("PushAround-v0", "PushAroundHard-v1", r"env = .*: has no goal-conditioned version"),
        ("batch_size = 16", "n_steps = 3", "n_steps = 3: HER has no n-step returns"),
        ("batch_size = 16", 'frame = "object"', "remove them"),
    ],
)
def test_invalid_settings_of_hindsight_replay_are_refused(
    old: str, new: str, message: str, tmp_path: Path
) -> None:
    file = written(tmp_path, HER)
    file.write_text(file.read_text().replace(old, new))
    with pytest.raises(TrundleError, match=message):
        read(file)


def test_contact_costs_nothing_before_the_ramp(tmp_path: Path) -> None:
    file = written(tmp_path, PPO)
    file.write_text(
        file.read_text()
        .replace("-v0", "-v1")
        .replace('hidden = "locked", object = ["office_table", "random"], ', 'hidden = "none", ')
        .replace("turn_cost = 0.5", "turn_cost = 0.5, touch_ramp = [0.5, 1.0]")
    )
    settings = read(file)
    worlds = make_worlds(settings)
    worlds.top.reset()
    refunds = {}
    for step in (0, settings.n_timesteps):
        worlds.shaped.n_steps = step
        worlds.shaped.contact[:] = 0.0
        refunds[step] = worlds.shaped._touch_refund(np.zeros(4, bool), [{"contact_time": 0.03}] * 4)
    assert np.allclose(refunds[0], 10.0 * 0.03)
    assert np.allclose(refunds[settings.n_timesteps], 0.0)


def with_detours(folder: Path, own: str) -> Path:
    """Write the file of a training among obstacles, with a cost of detours."""
    file = written(folder, own)
    replaced = file.read_text().replace("PushAround-v0", "PushAroundHard-v1")
    replaced = replaced.replace('hidden = "locked", object = ["office_table", "random"], ', "")
    file.write_text(replaced.replace("turn_cost = 0.5", "turn_cost = 0.5, detour_cost = 3.0"))
    return file


def test_the_cost_of_detours_is_that_of_the_shortest_path(tmp_path: Path) -> None:
    settings = read(with_detours(tmp_path, PPO))
    assert settings.digest != read(written(tmp_path, PPO)).digest
    worlds = make_worlds(settings)
    assert worlds.normalize is not None
    worlds.top.reset()
    for step in range(1, 33):
        _, _, dones, infos = worlds.top.step(np.zeros((4, 3)))
        detours = np.array([info["detour"] for info in infos])
        assert (detours > 0.05).all(), "all objects are still behind their obstacles"
        assert dones.all() == (step == 30)
        turns = np.array([abs(info["heading_error"]) for info in infos])
        errors = np.array([info["distance"] for info in infos]) + 0.3 * turns
        # Time costs 0.05 per second in version 1.
        costs = errors + 0.05 + 2.0 * np.tanh(errors / 0.2) + 0.5 * turns + 3.0 * detours
        assert worlds.normalize.get_original_reward() == pytest.approx(-0.05 * costs, rel=1e-4)


def test_reward_shaping_does_not_change_the_return(tmp_path: Path) -> None:
    settings = read(written(tmp_path, PPO))
    worlds = make_worlds(settings)
    worlds.batch.set_options([{"start": [-1.5, 0.0, 0.0], "goal": [-1.5, 0.0, 0.0]}] + [{}] * 3)
    worlds.top.reset()
    _, _, dones, infos = worlds.top.step(np.zeros((4, 3)))
    assert worlds.normalize is not None
    learnt_from = worlds.normalize.get_original_reward()
    assert dones.tolist() == [True, False, False, False]
    assert learnt_from[0] == pytest.approx(10.0, abs=0.1)
    assert infos[0]["episode"]["r"] == pytest.approx(0.0, abs=0.1)
    turn = abs(infos[1]["heading_error"])
    error = infos[1]["distance"] + 0.3 * turn
    # 50 ms at some distance and angle; 2 a second for not being near, 0.5 for each radian.
    assert learnt_from[1] == pytest.approx(
        -0.05 * (error + 2.0 * np.tanh(error / 0.2) + 0.5 * turn), rel=1e-4
    )


def test_an_evaluation_has_one_episode_per_world(tmp_path: Path) -> None:
    settings, learner, worlds = learnt(tmp_path, PPO)
    acting = exported(settings, 1, learner, worlds)
    found = evaluate(acting, TASK, settings.env_kwargs, 40, 5)
    env, returns = gym.make(TASK, **settings.env_kwargs), []
    for seed in range(40, 45):
        (observation, _), state, over = env.reset(seed=seed), None, False
        returns.append(0.0)
        while not over:
            action, state = acting.predict(observation, state)
            observation, reward, terminated, truncated, _ = env.step(action)
            returns[-1] += float(reward)
            over = terminated or truncated
    assert found["return"] == pytest.approx(np.mean(returns), rel=1e-3)


def test_play_accepts_a_policy(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    settings, learner, worlds = learnt(tmp_path, PPO)
    file = tmp_path / "policy.npz"
    exported(settings, 1, learner, worlds).save(file)
    assert main(["play", "PushAround", "--agent", str(file), "--episodes", "2"]) == 0
    assert "episode 1: time up after 1.5 s" in capsys.readouterr().out
    assert main(["play", "PushPose", "--agent", str(file)]) == 2
    assert TASK in capsys.readouterr().err


def test_a_curve_that_rises_has_not_flattened() -> None:
    def curve(*success: float) -> list[dict[str, float]]:
        return [{"success": share, "distance": 0.1} for share in success]

    assert not has_flattened(curve(0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0))
    assert has_flattened(curve(0.1, 0.2, 0.3, 0.4, 0.5, 0.9, 0.9, 0.9, 0.9, 0.9))
    assert not has_flattened(curve(0.5))
    assert not has_flattened([{"success": 0.0, "distance": 1.0 / k} for k in range(1, 11)])


def test_the_example_trains(tmp_path: Path) -> None:
    script = [sys.executable, "examples/train_ppo.py", "--steps", "20000", "--episodes", "10"]
    printed = subprocess.run(script, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert re.search(r"before: \d+ of 10 .*\n(.*\n)*after .*: \d+ of 10", printed)
