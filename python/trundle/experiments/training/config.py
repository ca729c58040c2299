"""A training's file: the environment, hyperparameters by RL Zoo's names, seeds, evaluations."""

from __future__ import annotations

import hashlib
import json
import re
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any, Literal

from trundle._native import TrundleError
from trundle.experiments.training.frames import TASKS
from trundle.settings import checked, ending, headed

__all__ = ["Evaluation", "RewardShaping", "Settings", "read"]

FORMAT = "trundle-train/1"
SEED_STRIDE = 1_000_000
"""Between the seeds of two trainings, so that no two of them begin in the same worlds."""
COUNT_KEYS = ("batch_size", "n_steps", "n_epochs", "buffer_size", "train_freq", "target_update_interval")
SHARE_KEYS = ("gamma", "gae_lambda", "tau")
SCHEDULE_KEYS = ("learning_rate", "clip_range")
"""Where "lin_0.001" falls evenly to zero over the training, as in RL Zoo."""
LINEAR_PATTERN = r"lin_(\d+\.?\d*(?:e-?\d+)?)"


@dataclass(frozen=True)
class RewardShaping:
    """Rewards that are there to learn from, not to be judged by.

    Attributes
    ----------
    success_bonus : float
        Added where the goal is reached.
    loss_cost : float
        What losing the object costs, instead of the environment's 100.
    miss_cost : float
        What a second far from the goal costs more; near it that falls to nothing, as tanh(error / 0.2 m). The
        error is that of the environment's reward: the distance, and 0.3 m for each radian.
    turn_cost : float
        What a second at a radian of heading error costs more; without it some trainings turn the wrong way.
    """

    success_bonus: float = 0.0
    loss_cost: float = 100.0
    miss_cost: float = 0.0
    turn_cost: float = 0.0


@dataclass(frozen=True)
class Evaluation:
    """How learning is watched: on worlds that are always the same and never trained on.

    Attributes
    ----------
    every : int
        Steps from one evaluation to the next.
    episodes, first : int
        How many worlds, and the seed of the first.
    """

    every: int = 50_000
    episodes: int = 100
    first: int = 500_000


@dataclass(frozen=True)
class Network:
    """What stable-baselines3's networks can be told, by its own names; what is left out it chooses."""

    net_arch: list[int] | None = None
    activation_fn: Literal["tanh", "relu"] | None = None
    log_std_init: float | None = None


@dataclass(frozen=True, kw_only=True)
class File:
    """What a file holds, whatever the algorithm; `Settings` says what it means."""

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
    """With what stable-baselines3's PPO can be told."""

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
    """With what its SAC can be told."""

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
    """All of it.

    Attributes
    ----------
    name : str
        The file's name without its ending: of policies, curves and checkpoints.
    algorithm : {"PPO", "SAC"}
        Of stable-baselines3.
    env : str
        The environment's id.
    env_kwargs : dict
        Its arguments.
    n_envs, n_timesteps : int
        Environments side by side; steps of all of them together.
    seeds : list of int
        One training each.
    normalize : bool
        Whether observations and rewards are scaled by what has been seen (`VecNormalize`).
    frame_stack : int
        How many of the last observations a policy is shown.
    frame : {"world", "object"}
        In which frame; see `trundle.experiments.training.frames`.
    checkpoint_every : int
        Steps from one checkpoint to the next.
    hyperparameters, policy_kwargs : dict
        The algorithm's, and those of its networks.
    aids : Aids
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
        """Return all that a training depends on, as plain values; not which seeds there are."""
        return {key: value for key, value in asdict(self).items() if key not in ("name", "seeds")}

    @property
    def digest(self) -> str:
        """A name for these settings: the beginning of a SHA-256."""
        text = json.dumps(self.plain(), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


def read(path: Path) -> Settings:
    """Read a training's file.

    Raises
    ------
    TrundleError
        If a key is missing, unknown or of another type, or a value makes no sense.
    """
    found = headed(path, FORMAT)
    algorithm = found.get("algorithm")
    if algorithm not in FILES:
        raise TrundleError(f"{path}: algorithm = {algorithm!r}: choose {', '.join(FILES)}")
    file = checked(path, FILES[algorithm], found)
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
    """Refuse values that make no sense."""
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
            raise TrundleError(f"{path}: {key} = {value}: give a whole number from 1 on")
    if settings.env not in TASKS:
        raise TrundleError(f"{path}: env = {settings.env!r}: choose {', '.join(TASKS)}")
    ending(path, settings.env_kwargs, "env_kwargs")
    first, last = settings.evaluation.first, SEED_STRIDE - settings.evaluation.episodes
    if not 0 <= first <= last:
        raise TrundleError(
            f"{path}: [evaluation] first = {first}: give 0 to {last}; those from {SEED_STRIDE} on are trained on"
        )
    seeds = settings.seeds
    if not seeds or not all(0 < seed < 1000 for seed in seeds):
        raise TrundleError(f"{path}: seeds = {seeds!r}: give whole numbers from 1 to 999")
    layers = settings.policy_kwargs.get("net_arch", [1])
    if not all(width > 0 for width in layers):
        raise TrundleError(f"{path}: net_arch = {layers!r}: give the widths of the layers, [64, 64]")
    told = settings.hyperparameters
    for key in COUNT_KEYS:
        if told.get(key, 1) < 1:
            raise TrundleError(f"{path}: {key} = {told[key]}: give a whole number from 1 on")
    for key in SHARE_KEYS:
        if not 0 <= told.get(key, 0) <= 1:
            raise TrundleError(f"{path}: {key} = {told[key]}: give a number from 0 to 1")
    entropy = told.get("ent_coef", "auto")
    if isinstance(entropy, str) and entropy != "auto" and not is_positive(entropy.removeprefix("auto_")):
        raise TrundleError(
            f'{path}: ent_coef = {entropy!r}: give a number, "auto", or "auto_0.1" to begin with 0.1'
        )
    target = told.get("target_entropy", "auto")
    if isinstance(target, str) and target != "auto":
        raise TrundleError(f'{path}: target_entropy = {target!r}: give a number, or "auto"')
    for key in SCHEDULE_KEYS:
        rate = settings.hyperparameters.get(key)
        if isinstance(rate, str) and not re.fullmatch(LINEAR_PATTERN, rate):
            raise TrundleError(
                f'{path}: {key} = {rate!r}: give a number, or "lin_0.001" to let it fall to zero'
            )


def is_positive(text: str) -> bool:
    """Tell whether a text is a number above zero."""
    try:
        return float(text) > 0.0
    except ValueError:
        return False
