"""A training's file: the environment, hyperparameters by RL Zoo's names, seeds, evaluations."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import MISSING, Field, asdict, dataclass, field, fields
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar, get_origin, get_type_hints

from trundle._native import TrundleError
from trundle.learning.frames import FRAMES, TASKS
from trundle.paper.config import parse

__all__ = ["Aids", "Evaluation", "Settings", "read"]

FORMAT = "trundle-train/1"
SHARED = {"policy": (str,), "learning_rate": (float, str), "batch_size": (int,), "gamma": (float,)}
HYPERPARAMETERS: dict[str, dict[str, tuple[type, ...]]] = {
    "PPO": {
        **SHARED,
        "n_steps": (int,),
        "n_epochs": (int,),
        "gae_lambda": (float,),
        "ent_coef": (float,),
        "vf_coef": (float,),
        "clip_range": (float, str),
        "max_grad_norm": (float,),
        "target_kl": (float,),
    },
    "SAC": {
        **SHARED,
        "buffer_size": (int,),
        "learning_starts": (int,),
        "train_freq": (int,),
        "gradient_steps": (int,),
        "tau": (float,),
        "ent_coef": (float, str),
        "target_entropy": (float, str),
        "target_update_interval": (int,),
    },
}
"""What an algorithm of stable-baselines3 can be told, by its own names, and of which type."""
SCHEDULED = ("learning_rate", "clip_range")
"""Where "lin_0.001" falls evenly to zero over the training, as in RL Zoo."""
NETWORK = {"net_arch": list, "activation_fn": str, "log_std_init": float}
ACTIVATIONS = ("tanh", "relu")
POLICY = "MlpPolicy"
LINEAR = r"lin_(\d+\.?\d*(?:e-?\d+)?)"
WORDS = {
    int: "a whole number",
    float: "a number",
    str: "text",
    bool: "true or false",
    list: "a list",
    dict: "a table",
}
T = TypeVar("T")


@dataclass(frozen=True)
class Aids:
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
        In which frame; see `trundle.learning.frames`.
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
    aids: Aids = Aids()
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
    found = parse(path)
    if found.pop("format", None) != FORMAT:
        raise TrundleError(f'{path}: must begin with format = "{FORMAT}"')
    algorithm = found.get("algorithm")
    if algorithm not in HYPERPARAMETERS:
        raise TrundleError(f"{path}: algorithm = {algorithm!r}: choose {', '.join(HYPERPARAMETERS)}")
    known = HYPERPARAMETERS[algorithm]
    told = {key: found.pop(key) for key in known if key in found}
    for key, value in told.items():
        check(path, key, value, known[key])
    for name, kind in (("aids", Aids), ("evaluation", Evaluation)):
        found[name] = table(path, f"[{name}] ", kind, found.get(name, {}))
    network(path, found.get("policy_kwargs", {}))
    own = {"name": path.stem, "hyperparameters": {"policy": POLICY, **told}}
    settings = table(path, "", Settings, found, own, ("format", *known))
    sensible(path, settings)
    return settings


def table(
    path: Path,
    where: str,
    kind: type[T],
    found: Any,
    own: Mapping[str, Any] = MappingProxyType({}),
    read_before: tuple[str, ...] = (),
) -> T:
    """Return a table as a dataclass whose fields are its keys, but for those of `own`."""
    if not isinstance(found, Mapping):
        raise TrundleError(f"{path}: {where.strip()} is no table")
    hints = {key: hint for key, hint in get_type_hints(kind).items() if key not in own}
    for key, value in found.items():
        if key not in hints:
            known = ", ".join([*hints, *read_before])
            raise TrundleError(f"{path}: unknown key '{where}{key}'; known are {known}")
        wanted = get_origin(hints[key]) or hints[key]
        if wanted in WORDS:
            check(path, f"{where}{key}", value, (wanted,))
    given = {**own, **found}
    missing = [one.name for one in fields(kind) if one.name not in given and required(one)]  # type: ignore[arg-type]
    if missing:
        raise TrundleError(f"{path}: the key '{where}{missing[0]}' is missing")
    return kind(**given)


def check(path: Path, key: str, value: Any, wanted: tuple[type, ...]) -> None:
    """Refuse a value of another type; a whole number is a number too, a truth value is none."""
    fits = isinstance(value, wanted) or (float in wanted and isinstance(value, int))
    if not fits or (isinstance(value, bool) and bool not in wanted):
        names = " or ".join(WORDS[kind] for kind in wanted)
        raise TrundleError(f"{path}: {key} = {value!r}: give {names}")


def network(path: Path, found: Any) -> None:
    """Refuse what no network can be made of."""
    if not isinstance(found, Mapping):
        raise TrundleError(f"{path}: policy_kwargs is no table")
    for key, value in found.items():
        if key not in NETWORK:
            raise TrundleError(f"{path}: unknown key '[policy_kwargs] {key}'; known are {', '.join(NETWORK)}")
        check(path, f"[policy_kwargs] {key}", value, (NETWORK[key],))
    layers = found.get("net_arch", [1])
    if not all(type(width) is int and width > 0 for width in layers):
        raise TrundleError(f"{path}: net_arch = {layers!r}: give the widths of the layers, [64, 64]")
    activation = found.get("activation_fn", "tanh")
    if activation not in ACTIVATIONS:
        raise TrundleError(f"{path}: activation_fn = {activation!r}: choose {', '.join(ACTIVATIONS)}")


def sensible(path: Path, settings: Settings) -> None:
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
    if settings.frame not in FRAMES:
        raise TrundleError(f"{path}: frame = {settings.frame!r}: choose {', '.join(FRAMES)}")
    seeds = settings.seeds
    if not seeds or not all(type(seed) is int and 0 < seed < 1000 for seed in seeds):
        raise TrundleError(f"{path}: seeds = {seeds!r}: give whole numbers from 1 to 999")
    if settings.hyperparameters["policy"] != POLICY:
        raise TrundleError(f"{path}: policy = {settings.hyperparameters['policy']!r}: choose {POLICY}")
    for key in SCHEDULED:
        rate = settings.hyperparameters.get(key)
        if isinstance(rate, str) and not re.fullmatch(LINEAR, rate):
            raise TrundleError(
                f'{path}: {key} = {rate!r}: give a number, or "lin_0.001" to let it fall to zero'
            )


def required(one: Field[Any]) -> bool:
    """Tell whether a field has no default."""
    return one.default is MISSING and one.default_factory is MISSING
