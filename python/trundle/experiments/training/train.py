"""Run a training from its file, with evaluations and checkpoints."""

from __future__ import annotations

import importlib.util
import json
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import torch
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import Logger, TensorBoardOutputFormat
from stable_baselines3.common.utils import get_device

from trundle._native import TrundleError
from trundle.atomic import read_json, write_text
from trundle.experiments.results import Row, rounded
from trundle.experiments.training import checkpoint, state_file
from trundle.experiments.training.card import model_card
from trundle.experiments.training.config import FORMAT, Dynamics, read
from trundle.experiments.training.dynamics import run as dynamics
from trundle.experiments.training.dynamics.errors import OPEN_LOOP_S
from trundle.experiments.training.evaluate import evaluate
from trundle.experiments.training.networks import Algorithm, algorithm, exported
from trundle.experiments.training.settings import Settings
from trundle.experiments.training.worlds import Worlds, action_period, make_worlds
from trundle.progress import Progress
from trundle.settings import parse_format

__all__ = ["Training", "has_flattened", "train_one"]

Show = Callable[[str], object]
CURVE_ABOUT = ("config", "digest", "seed", "algorithm", "env", "env_kwargs", "steps")
"""Metadata of the policy that a curve's file repeats."""
PLATEAU_SHARE = 0.25
"""Share of a curve that is compared with the share before it."""
MIN_IMPROVEMENT = 0.01
"""Increase of the success rate, or decrease of the distance in m, that counts as an improvement."""
LOG_INTERVAL = 20
"""Rollouts of PPO, or episodes of SAC, between entries in TensorBoard."""
MIN_SECONDS_BETWEEN_LINES = 0.2
"""Shortest time between two lines of progress."""


class Training:
    """One training run of a configuration.

    In `folder`, `policies/NAME-SEED.npz` with its model card `.md`, `curves/NAME-SEED.json` and
    `timing/NAME-SEED.json` are written at the end; `work/NAME-SEED/` holds the checkpoint until then, and the
    data of TensorBoard. The same settings and seed give the same policy and the same curve, however often the
    training is interrupted.

    Parameters
    ----------
    settings : Settings
    seed : int
    folder : Path
    device : str
        Device of PyTorch. Another device rounds otherwise, and gives another policy.
    """

    def __init__(self, settings: Settings, seed: int, folder: Path, device: str = "cpu") -> None:
        self.settings, self.seed, self._device = settings, seed, device
        self.name = f"{settings.name}-{seed}"
        self.policy_file = folder / "policies" / f"{self.name}.npz"
        self._curve_file = folder / "curves" / f"{self.name}.json"
        self._timing_file = folder / "timing" / f"{self.name}.json"
        self._work = folder / "work" / self.name
        self.checkpoint_file = self._work / "checkpoint.pickle"
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
        if self.policy_file.exists() and self._curve_file.exists():
            return self._check_digest(read_json(self._curve_file))
        torch.set_num_threads(1)
        worlds = make_worlds(self.settings)
        learner = algorithm(self.settings, self.seed, worlds, self._device)
        installed = importlib.util.find_spec("tensorboard") is not None
        writers = [TensorBoardOutputFormat(str(self._work))] if installed else []
        learner.set_logger(Logger(str(self._work), writers))
        if self.checkpoint_file.exists():
            found = self._check_digest(state_file.load(self.checkpoint_file))
            self.curve, self.seconds = found["curve"], found["seconds"]
            checkpoint.restore(learner, worlds, found)
        callback = TrainingCallback(self, worlds, show)
        steps = self.settings.n_timesteps - learner.num_timesteps
        learner.learn(steps, callback=callback, reset_num_timesteps=False, log_interval=LOG_INTERVAL)
        callback.evaluate()
        result = self._finish(learner, worlds, callback.seconds)
        worlds.top.close()
        return result

    def _check_digest(self, found: Row) -> Row:
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
        about = asdict(policy.about)
        result = {
            **{key: about[key] for key in CURVE_ABOUT},
            "simulated_seconds": round(policy.about.steps * action_period(self.settings), 3),
            "parameters": policy.parameters,
            "flattened": has_flattened(self.curve),
            "curve": self.curve,
        }
        timing = {"cpu_seconds": round(seconds, 1), "torch": torch.__version__, "device": self._device}
        write_text(self._timing_file, json.dumps(timing, indent=1) + "\n")
        card = model_card(self.settings, policy.about, result, f"{torch.__version__} on {self._device}")
        write_text(self.policy_file.with_suffix(".md"), card)
        write_text(self._curve_file, json.dumps(result, indent=1) + "\n")
        self.checkpoint_file.unlink(missing_ok=True)
        return result


def train_one(config: Path, seed: int, out: Path, quiet: bool, device: str) -> str:
    """Train one seed of a configuration, and return its result as a sentence.

    Raises
    ------
    TrundleError
        If PyTorch has no such device, or the settings are invalid.
    """
    settings = read(config)
    if isinstance(settings, Dynamics):
        return train_dynamics(config, seed, out, quiet, device)
    try:
        get_device(device)
    except RuntimeError:
        raise TrundleError(f"--device {device}: give cpu, cuda or auto") from None
    training = Training(settings, seed, out, device)
    with Progress("training", quiet=quiet) as progress:
        result = training.run(progress.show)
    last, rises = result["curve"][-1], "" if result["flattened"] else "; the curve still improves"
    return (
        f"{training.policy_file}: success {last['success']:.0%}, {last['distance']:.2f} m from the goal "
        f"after {result['steps']:,} steps, {result['simulated_seconds']:,.0f} s of pushing{rises}"
    )


def train_dynamics(config: Path, seed: int, out: Path, quiet: bool, device: str) -> str:
    """Train one seed of a dynamics model, and return its result as a sentence."""
    if device != "cpu":
        raise TrundleError(f"--device {device}: dynamics models are trained on the cpu")
    result = dynamics.train(config, parse_format(config, FORMAT), seed, out, quiet=quiet)
    last = result["errors"][-1]
    return (
        f"{out / 'dynamics' / result['config']}-{seed}.npz: predictions of {OPEN_LOOP_S:g} s after "
        f"{last['history']:g} s of motion are off by {100 * last['distance']:.1f} cm and "
        f"{last['turn']:.3f} rad (medians of {last['episodes']:.0f} episodes)"
    )


class TrainingCallback(BaseCallback):  # type: ignore[misc]
    """Evaluates and saves a training between rollouts, when its state is complete."""

    def __init__(self, training: Training, worlds: Worlds, show: Show) -> None:
        super().__init__()
        self._training, self._worlds, self._show = training, worlds, show
        self._began, self._shown = time.process_time(), 0.0

    @property
    def seconds(self) -> float:
        """CPU time of the training, also before an interruption, s."""
        return self._training.seconds + time.process_time() - self._began

    def _on_training_start(self) -> None:
        self._saved = self.model.num_timesteps

    def _on_rollout_start(self) -> None:
        settings, steps, curve = self._training.settings, self.model.num_timesteps, self._training.curve
        evaluated = curve[-1]["step"] if curve else -settings.evaluation.every
        if steps // settings.evaluation.every > evaluated // settings.evaluation.every:
            self.evaluate()
        if steps // settings.checkpoint_every > self._saved // settings.checkpoint_every:
            self._save()
        if time.monotonic() - self._shown > MIN_SECONDS_BETWEEN_LINES:
            self._shown, last = time.monotonic(), curve[-1]
            self._show(
                f"{self._training.name} · {steps / settings.n_timesteps:.0%} of {settings.n_timesteps:,} "
                f"steps · success {last['success']:.0%}, {last['distance']:.2f} m from the goal after "
                f"{last['step']:,}"
            )

    def _on_step(self) -> bool:
        return True

    def evaluate(self) -> None:
        """Evaluate the current policy, and add a point to the curve."""
        settings, steps = self._training.settings, int(self.model.num_timesteps)
        policy = exported(settings, self._training.seed, self.model, self._worlds)
        worlds = settings.evaluation
        found = evaluate(policy, settings.env, settings.env_kwargs, worlds.first, worlds.episodes)
        self._training.curve.append({"step": steps, **rounded(found)})
        for name, value in found.items():
            self.logger.record(f"eval/{name}", value)
        self.logger.dump(steps)

    def _save(self) -> None:
        self._saved = self.model.num_timesteps
        training = {
            "digest": self._training.settings.digest,
            "curve": self._training.curve,
            "seconds": self.seconds,
        }
        content = training | checkpoint.state(self.model, self._worlds)
        state_file.save(self._training.checkpoint_file, content)


def has_flattened(curve: list[Row]) -> bool:
    """Return whether the last share of a curve is no better than the one before, by success and distance."""
    count = max(1, round(PLATEAU_SHARE * len(curve)))
    if len(curve) <= count:
        return False

    def rise(key: str) -> float:
        late, before = (
            [float(row[key]) for row in part] for part in (curve[-count:], curve[-2 * count : -count])
        )
        return sum(late) / len(late) - sum(before) / len(before)

    return rise("success") <= MIN_IMPROVEMENT and -rise("distance") <= MIN_IMPROVEMENT
