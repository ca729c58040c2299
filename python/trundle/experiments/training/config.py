"""Read the file of a training: environment, hyperparameters with the names of RL Zoo, seeds, evaluations."""

from __future__ import annotations

import hashlib
import json
import re
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any, Literal

from trundle._native import TrundleError
from trundle.experiments.training.frames import TASKS
from trundle.settings import build_settings, check_horizon, parse_format

__all__ = ["Evaluation", "RewardShaping", "Settings", "read"]

FORMAT = "trundle-train/1"
SEED_STRIDE = 1_000_000
"""Difference of the seeds of two trainings, so that they have different worlds."""
COUNT_KEYS = ("batch_size", "n_steps", "n_epochs", "buffer_size", "train_freq", "target_update_interval")
SHARE_KEYS = ("gamma", "gae_lambda", "tau")
SCHEDULE_KEYS = ("learning_rate", "clip_range")
"""Keys for which "lin_0.001" is a linear schedule to zero, as in RL Zoo."""
LINEAR_PATTERN = r"lin_(\d+\.?\d*(?:e-?\d+)?)"


@dataclass(frozen=True)
class RewardShaping:
    """Additional rewards during training, which evaluations do not use.

    Attributes
    ----------
    success_bonus : float
        Reward for reaching the goal.
    loss_cost : float
        Cost of losing the object, instead of the environment's 100.
    miss_cost : float
        Cost per second far from the goal; it falls to zero near it, as tanh(error / 0.2 m). The error is that
        of the environment's reward: the distance, and 0.3 m for each radian.
    turn_cost : float
        Cost per second and radian of heading error. Without it some trainings turn in the wrong direction.
    """

    success_bonus: float = 0.0
    loss_cost: float = 100.0
    miss_cost: float = 0.0
    turn_cost: float = 0.0


@dataclass(frozen=True)
class Evaluation:
    """Evaluations on fixed worlds that are not used for training.

    Attributes
    ----------
    every : int
        Steps between evaluations.
    episodes, first : int
        Number of worlds, and the seed of the first.
    """

    every: int = 50_000
    episodes: int = 100
    first: int = 500_000


@dataclass(frozen=True)
class Network:
    """Options of stable-baselines3's networks, by its own names; None selects its default."""

    net_arch: list[int] | None = None
    activation_fn: Literal["tanh", "relu"] | None = None
    log_std_init: float | None = None


@dataclass(frozen=True, kw_only=True)
class File:
    """Keys that both algorithms have; see `Settings`."""

    env: str
    n_timesteps: int
    seeds: list[int]
    env_kwargs: dict[str, Any] = field(default_factory=dict)
    n_envs: int = 1
    normalize: bool = True
    frame_stack: int = 1
    frame: Literal["world", "object"] = "world"
    checkpoint_every: int = 100_000
    policy_kwargs: Network = Network()
    aids: RewardShaping = RewardShaping()
    evaluation: Evaluation = Evaluation()
    policy: Literal["MlpPolicy"] = "MlpPolicy"
    learning_rate: float | str | None = None
    batch_size: int | None = None
    gamma: float | None = None


@dataclass(frozen=True, kw_only=True)
class PPO(File):
    """Keys of stable-baselines3's PPO."""

    algorithm: Literal["PPO"]
    n_steps: int | None = None
    n_epochs: int | None = None
    gae_lambda: float | None = None
    ent_coef: float | None = None
    vf_coef: float | None = None
    clip_range: float | str | None = None
    max_grad_norm: float | None = None
    target_kl: float | None = None


@dataclass(frozen=True, kw_only=True)
class SAC(File):
    """Keys of stable-baselines3's SAC."""

    algorithm: Literal["SAC"]
    buffer_size: int | None = None
    learning_starts: int | None = None
    train_freq: int | None = None
    gradient_steps: int | None = None
    tau: float | None = None
    ent_coef: float | str | None = None
    target_entropy: float | str | None = None
    target_update_interval: int | None = None
    n_steps: int | None = None


FILES: dict[str, type[File]] = {"PPO": PPO, "SAC": SAC}


@dataclass(frozen=True)
class Settings:
    """Settings of a training.

    Attributes
    ----------
    name : str
        The file's name without its ending; prefix of policies, curves and checkpoints.
    algorithm : {"PPO", "SAC"}
        Of stable-baselines3.
    env : str
        The environment's id.
    env_kwargs : dict
        Its arguments.
    n_envs, n_timesteps : int
        Number of parallel environments; total number of steps.
    seeds : list of int
        One training each.
    normalize : bool
        Whether observations and rewards are normalised by running statistics (`VecNormalize`).
    frame_stack : int
        Number of stacked observations.
    frame : {"world", "object"}
        Frame of the observations; see `trundle.experiments.training.frames`.
    checkpoint_every : int
        Steps between checkpoints.
    hyperparameters, policy_kwargs : dict
        Of the algorithm, and of its networks.
    aids : RewardShaping
    evaluation : Evaluation
    """

    name: str
    algorithm: str
    env: str
    n_timesteps: int
    seeds: list[int]
    env_kwargs: dict[str, Any] = field(default_factory=dict)
    n_envs: int = 1
    normalize: bool = True
    frame_stack: int = 1
    frame: str = "world"
    checkpoint_every: int = 100_000
    hyperparameters: dict[str, Any] = field(default_factory=dict)
    policy_kwargs: dict[str, Any] = field(default_factory=dict)
    aids: RewardShaping = RewardShaping()
    evaluation: Evaluation = Evaluation()

    def plain(self) -> dict[str, Any]:
        """Return everything except the seeds that a training depends on, as plain values."""
        return {key: value for key, value in asdict(self).items() if key not in ("name", "seeds")}

    @property
    def digest(self) -> str:
        """Digest of these settings: the first digits of a SHA-256."""
        text = json.dumps(self.plain(), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


def read(path: Path) -> Settings:
    """Read a training's file.

    Raises
    ------
    TrundleError
        If a key is missing, unknown or of another type, or a value is out of range.
    """
    found = parse_format(path, FORMAT)
    algorithm = found.get("algorithm")
    if algorithm not in FILES:
        raise TrundleError(f"{path}: algorithm = {algorithm!r}: choose {', '.join(FILES)}")
    file = build_settings(path, FILES[algorithm], found)
    told = {one.name: getattr(file, one.name) for one in fields(file)}
    own = {one.name for one in fields(Settings)}
    settings = Settings(
        **{
            **{key: value for key, value in told.items() if key in own},
            "name": path.stem,
            "hyperparameters": {
                key: value for key, value in told.items() if key not in own and value is not None
            },
            "policy_kwargs": {k: v for k, v in asdict(file.policy_kwargs).items() if v is not None},
        }
    )
    check_values(path, settings)
    return settings


def check_values(path: Path, settings: Settings) -> None:
    """Raise an error for values that are out of range."""
    counts = {
        "n_envs": settings.n_envs,
        "n_timesteps": settings.n_timesteps,
        "frame_stack": settings.frame_stack,
        "checkpoint_every": settings.checkpoint_every,
        "[evaluation] every": settings.evaluation.every,
        "[evaluation] episodes": settings.evaluation.episodes,
    }
    for key, value in counts.items():
        if value < 1:
            raise TrundleError(f"{path}: {key} = {value}: give an integer of at least 1")
    if settings.env not in TASKS:
        raise TrundleError(f"{path}: env = {settings.env!r}: choose {', '.join(TASKS)}")
    check_horizon(path, settings.env_kwargs, "env_kwargs")
    first, last = settings.evaluation.first, SEED_STRIDE - settings.evaluation.episodes
    if not 0 <= first <= last:
        raise TrundleError(
            f"{path}: [evaluation] first = {first}: give 0 to {last}; "
            f"training uses seeds from {SEED_STRIDE} on"
        )
    seeds = settings.seeds
    if not seeds or not all(0 < seed < 1000 for seed in seeds):
        raise TrundleError(f"{path}: seeds = {seeds!r}: give integers from 1 to 999")
    layers = settings.policy_kwargs.get("net_arch", [1])
    if not all(width > 0 for width in layers):
        raise TrundleError(f"{path}: net_arch = {layers!r}: give the widths of the layers, [64, 64]")
    told = settings.hyperparameters
    for key in COUNT_KEYS:
        if told.get(key, 1) < 1:
            raise TrundleError(f"{path}: {key} = {told[key]}: give an integer of at least 1")
    for key in SHARE_KEYS:
        if not 0 <= told.get(key, 0) <= 1:
            raise TrundleError(f"{path}: {key} = {told[key]}: give a number from 0 to 1")
    entropy = told.get("ent_coef", "auto")
    if isinstance(entropy, str) and entropy != "auto" and not is_positive(entropy.removeprefix("auto_")):
        raise TrundleError(
            f'{path}: ent_coef = {entropy!r}: give a number, "auto", or "auto_0.1" for the initial value 0.1'
        )
    target = told.get("target_entropy", "auto")
    if isinstance(target, str) and target != "auto":
        raise TrundleError(f'{path}: target_entropy = {target!r}: give a number, or "auto"')
    for key in SCHEDULE_KEYS:
        rate = settings.hyperparameters.get(key)
        if isinstance(rate, str) and not re.fullmatch(LINEAR_PATTERN, rate):
            raise TrundleError(
                f'{path}: {key} = {rate!r}: give a number, or "lin_0.001" for a linear schedule to zero'
            )


def is_positive(text: str) -> bool:
    """Return whether a text is a number above zero."""
    try:
        return float(text) > 0.0
    except ValueError:
        return False
