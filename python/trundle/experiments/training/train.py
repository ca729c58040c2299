"""Run a training from its file, with evaluations and checkpoints."""

from __future__ import annotations

import importlib.util
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import torch
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import KVWriter, Logger, TensorBoardOutputFormat

from trundle._native import TrundleError
from trundle.atomic import read_json, write_text
from trundle.cli.progress import Progress
from trundle.experiments.results import rounded
from trundle.experiments.training import checkpoint
from trundle.experiments.training.config import Settings, read
from trundle.experiments.training.evaluate import evaluate
from trundle.experiments.training.networks import Algorithm, algorithm, exported
from trundle.experiments.training.worlds import Worlds, action_period, make_worlds

__all__ = ["Training", "train_one"]

Show = Callable[[str], object]
Row = dict[str, Any]
PLATEAU_SHARE = 0.2
"""Share of a curve that is compared with the share before it."""
MIN_IMPROVEMENT = 0.02
"""Increase of the success rate, or decrease of the distance in m, that counts as an improvement."""
LOG_INTERVAL = 20
"""Rollouts of PPO, or episodes of SAC, between entries in TensorBoard."""


class Training:
    """One training run of a configuration.

    In `folder`, `policies/NAME-SEED.npz`, `curves/NAME-SEED.json` and `timing/NAME-SEED.json` are written at
    the end; `work/NAME-SEED/` holds the checkpoint until then, and the data of TensorBoard. The same settings
    and seed give the same policy and the same curve, however often the training is interrupted.

    Parameters
    ----------
    settings : Settings
    seed : int
    folder : Path
    """

    def __init__(self, settings: Settings, seed: int, folder: Path) -> None:
        self.settings, self.seed = settings, seed
        self.name = f"{settings.name}-{seed}"
        self.policy_file = folder / "policies" / f"{self.name}.npz"
        self._curve_file = folder / "curves" / f"{self.name}.json"
        self._timing_file = folder / "timing" / f"{self.name}.json"
        self._work = folder / "work" / self.name
        self.checkpoint_file = self._work / "checkpoint.npz"
        self.curve: list[Row] = []
        self.seconds = 0.0

    def run(self, show: Show = lambda _: None) -> Row:
        """Train to the end, from the last checkpoint if there is one; return the curve's file.

        Parameters
        ----------
        show : callable
            Called with a line between rollouts.

        Raises
        ------
        TrundleError
            If the folder holds a training of this name with other settings.
        """
        done = self._done()
        return self._train(show) if done is None else self._own(done)

    def _train(self, show: Show) -> Row:
        torch.set_num_threads(1)
        worlds = make_worlds(self.settings)
        learner = algorithm(self.settings, self.seed, worlds)
        learner.set_logger(Logger(str(self._work), log_writers(self._work)))
        kept = checkpoint.read(self.checkpoint_file)
        if kept is not None:
            self.curve, self.seconds = self._own(kept)["curve"], kept["seconds"]
            checkpoint.restore(learner, worlds, kept)
        watch = TrainingCallback(self, worlds, show)
        rest = self.settings.n_timesteps - learner.num_timesteps
        learner.learn(rest, callback=watch, reset_num_timesteps=False, log_interval=LOG_INTERVAL)
        watch.look()
        told = self._finish(learner, worlds, self.seconds + watch.seconds)
        worlds.top.close()
        return told

    def _done(self) -> Row | None:
        if not (self.policy_file.exists() and self._curve_file.exists()):
            return None
        found: Row = read_json(self._curve_file)
        return found

    def _own(self, found: Row) -> Row:
        """Return results from the folder, or raise an error if they have other settings."""
        if found.get("digest") != self.settings.digest:
            raise TrundleError(
                f"{self._work} holds a training with other settings: choose another --out, "
                f"or remove {self.name}"
            )
        return found

    def _finish(self, learner: Algorithm, worlds: Worlds, seconds: float) -> Row:
        """Write the results and delete the checkpoint."""
        policy = exported(self.settings, self.seed, learner, worlds)
        policy.save(self.policy_file)
        steps = int(learner.num_timesteps)
        told = {
            "config": self.settings.name,
            "digest": self.settings.digest,
            "seed": self.seed,
            "algorithm": self.settings.algorithm,
            "env": self.settings.env,
            "env_kwargs": self.settings.env_kwargs,
            "steps": steps,
            "simulated_seconds": round(steps * action_period(self.settings), 3),
            "parameters": policy.parameters,
            "flattened": has_flattened(self.curve),
            "curve": self.curve,
        }
        write_text(self._timing_file, to_json({"cpu_seconds": round(seconds, 1)}))
        write_text(self._curve_file, to_json(told))
        self.checkpoint_file.unlink(missing_ok=True)
        return told


def train_one(config: Path, seed: int, out: Path, quiet: bool) -> str:
    """Train one seed of a configuration, and return its result as a sentence."""
    training = Training(read(config), seed, out)
    with Progress("training", quiet=quiet) as progress:
        told = training.run(progress.show)
    last, rises = told["curve"][-1], "" if told["flattened"] else "; the curve still improves"
    return (
        f"{training.policy_file}: success {last['success']:.0%}, {last['distance']:.2f} m from the goal "
        f"after {told['steps']:,} steps, {told['simulated_seconds']:,.0f} s of pushing{rises}"
    )


class TrainingCallback(BaseCallback):  # type: ignore[misc]
    """Evaluates and saves a training between rollouts, when its state is complete."""

    def __init__(self, training: Training, worlds: Worlds, show: Show) -> None:
        super().__init__()
        self._training, self._worlds, self._show = training, worlds, show
        self._began = time.process_time()
        self._shown = 0.0

    @property
    def seconds(self) -> float:
        """CPU time since this call began, s."""
        return time.process_time() - self._began

    def _on_rollout_start(self) -> None:
        settings, steps = self._training.settings, self.model.num_timesteps
        looked = self._training.curve[-1]["step"] if self._training.curve else -settings.evaluation.every
        if steps // settings.evaluation.every > looked // settings.evaluation.every:
            self.look()
        if steps // settings.checkpoint_every > self._kept // settings.checkpoint_every:
            self.keep()
        self._tell()

    def _on_training_start(self) -> None:
        self._kept = self.model.num_timesteps

    def _on_step(self) -> bool:
        return True

    def look(self) -> None:
        """Evaluate the current policy, and add a point to the curve."""
        training, told = self._training, self._training.settings
        policy = exported(told, training.seed, self.model, self._worlds)
        evaluation = told.evaluation
        found = evaluate(policy, told.env, told.env_kwargs, evaluation.first, evaluation.episodes)
        training.curve.append({"step": int(self.model.num_timesteps), **rounded(found)})
        for name, value in found.items():
            self.logger.record(f"eval/{name}", value)
        self.logger.dump(self.model.num_timesteps)

    def keep(self) -> None:
        """Write a checkpoint."""
        training = self._training
        self._kept = self.model.num_timesteps
        kept = {
            "digest": training.settings.digest,
            "curve": training.curve,
            "seconds": training.seconds + self.seconds,
            **checkpoint.state(self.model, self._worlds),
        }
        checkpoint.write(training.checkpoint_file, kept)

    def _tell(self) -> None:
        """Show the progress, at most five times per second."""
        if time.monotonic() - self._shown < 0.2:
            return
        self._shown = time.monotonic()
        last = self._training.curve[-1]
        share = self.model.num_timesteps / self._training.settings.n_timesteps
        self._show(
            f"{self._training.name} · {share:.0%} of {self._training.settings.n_timesteps:,} steps · "
            f"success {last['success']:.0%}, {last['distance']:.2f} m from the goal after {last['step']:,}"
        )


def has_flattened(curve: list[Row]) -> bool:
    """Return whether the last share of a curve is no better than the one before, by success and distance."""
    count = max(1, round(PLATEAU_SHARE * len(curve)))
    late, before = curve[-count:], curve[-2 * count : -count]
    if not before:
        return False
    more = mean(late, "success") - mean(before, "success")
    nearer = mean(before, "distance") - mean(late, "distance")
    return more <= MIN_IMPROVEMENT and nearer <= MIN_IMPROVEMENT


def mean(rows: list[Row], key: str) -> float:
    """Return the mean of a column."""
    return sum(float(row[key]) for row in rows) / len(rows)


def log_writers(folder: Path) -> list[KVWriter]:
    """Return the writers for TensorBoard, if it is installed."""
    if importlib.util.find_spec("tensorboard") is None:
        return []
    return [TensorBoardOutputFormat(str(folder))]


def to_json(told: Row) -> str:
    """Return indented JSON."""
    return json.dumps(told, indent=1) + "\n"
