"""Settings of a training: environment, hyperparameters with the names of RL Zoo, seeds, evaluations."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Annotated, Any, Final, Literal

from trundle._native import TrundleError
from trundle.envs.ids import task_of
from trundle.experiments.search.ranges import Search, check_split
from trundle.rules import Count, EnvOptions, Natural, Rule, Share, pattern
from trundle.settings import SettingsError, build_settings, parse_format

__all__ = [
    "PPO",
    "RMA",
    "SAC",
    "TQC",
    "CrossQ",
    "Dynamics",
    "Evaluation",
    "Network",
    "RecurrentPPO",
    "RewardShaping",
    "Settings",
    "build",
    "read",
]

FORMAT = "trundle-train/1"
ADAPTIVE: Final = "Adaptive"
"""The adaptive agent, whose settings a search tunes."""
SEED_STRIDE = 1_000_000
"""Difference of the seeds of two trainings, so that they have different worlds."""
NUMBER = r"\d+\.?\d*(e-?\d+)?"

Task = Annotated[
    str,
    Rule(
        lambda env: task_of(env) is not None,
        "an environment with arrays of observations, such as trundle/PushAroundHard-v1",
    ),
]
Seed = Annotated[int, Rule(lambda seed: 0 < seed < 1000, "a whole number from 1 to 999")]
Linear = Annotated[str, pattern(f"lin_{NUMBER}", '"lin_0.001" for a linear schedule to zero')]
"""A schedule as in RL Zoo."""
Entropy = Annotated[
    str, pattern(f"auto(_(?=.*[1-9]){NUMBER})?", '"auto", or "auto_0.1" for the initial value 0.1')
]


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
    touch_ramp : (float, float), optional
        Shares of the training between which the cost of contact rises from zero to that of the environment,
        so that the task is learnt first. For environments of version 1.
    """

    success_bonus: float = 0.0
    loss_cost: float = 100.0
    miss_cost: float = 0.0
    turn_cost: float = 0.0
    touch_ramp: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if self.touch_ramp is not None and not 0 <= self.touch_ramp[0] < self.touch_ramp[1] <= 1:
            raise SettingsError(
                f"touch_ramp = {list(self.touch_ramp)}: give two shares in order, from 0 to 1"
            )


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

    every: Count = 50_000
    episodes: Count = 100
    first: int = 500_000

    def __post_init__(self) -> None:
        last = SEED_STRIDE - self.episodes
        if not 0 <= self.first <= last:
            raise SettingsError(
                f"first = {self.first}: give 0 to {last}; training uses seeds from {SEED_STRIDE} on"
            )


@dataclass(frozen=True)
class Network:
    """Options of stable-baselines3's networks, by its own names; None selects its default."""

    net_arch: list[Count] | None = None
    activation_fn: Literal["tanh", "relu"] | None = None
    log_std_init: float | None = None
    lstm_hidden_size: Count | None = None


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Settings of a training that all algorithms have.

    Attributes
    ----------
    name : str
        Prefix of policies, curves and checkpoints; by default the name of the file without its suffix.
    algorithm : {"PPO", "RecurrentPPO", "RMA", "SAC", "TQC", "CrossQ", "Dynamics"}
        Of stable-baselines3 and sb3-contrib; RMA and Dynamics: `rma` and `dynamics` in this package.
    env : str
        The environment's id.
    n_timesteps : int
        Total number of steps.
    seeds : list of int
        One training each.
    env_kwargs : dict
        Arguments of the environment.
    n_envs : int
        Number of parallel environments.
    normalize : bool
        Whether observations and rewards are normalised by running statistics (`VecNormalize`).
    frame_stack : int
        Number of stacked observations.
    frame : {"world", "object"}
        Frame of the observations; see `trundle.experiments.training.frames`.
    privileged : bool
        Whether observations contain the hidden parameters, as `trundle.envs.Oracle` appends them: the bound
        of what adaptation can reach.
    checkpoint_every : int
        Steps between checkpoints.
    policy_kwargs : Network
    aids : RewardShaping
    evaluation : Evaluation
    search : Search, optional
        Ranges for `trundle train --search`. A training does not depend on them.
    policy, learning_rate, batch_size, gamma
        Hyperparameters of both algorithms. None selects the default of stable-baselines3.
    """

    name: str
    algorithm: str
    env: Task
    n_timesteps: Count
    seeds: Annotated[list[Seed], Rule(bool, "a list of at least one seed")]
    env_kwargs: EnvOptions = field(default_factory=dict)
    n_envs: Count = 1
    normalize: bool = True
    frame_stack: Count = 1
    frame: Literal["world", "object"] = "world"
    privileged: bool = False
    checkpoint_every: Count = 100_000
    policy_kwargs: Network = Network()
    aids: RewardShaping = RewardShaping()
    evaluation: Evaluation = Evaluation()
    search: Search | None = None
    policy: Literal["MlpPolicy"] = "MlpPolicy"
    learning_rate: float | Linear | None = None
    batch_size: Count | None = None
    gamma: Share | None = None

    def __post_init__(self) -> None:
        if self.aids.touch_ramp is not None and self.env.endswith("-v0"):
            raise SettingsError(
                f"aids.touch_ramp: {self.env} does not report contact times; choose version 1"
            )
        if self.search is not None:
            check_split(self.env_kwargs)
            evaluated = range(self.evaluation.first, self.evaluation.first + self.evaluation.episodes)
            if max(evaluated[0], self.search.first) <= min(evaluated[-1], self.search.worlds[-1]):
                raise SettingsError(
                    f"search: first = {self.search.first}: these are worlds of the evaluations, seeds "
                    f"{evaluated[0]} to {evaluated[-1]}"
                )

    @property
    def hyperparameters(self) -> dict[str, Any]:
        """Arguments of the algorithm that are given."""
        return {key: value for key, value in vars(self).items() if key not in COMMON and value is not None}

    @property
    def network(self) -> dict[str, Any]:
        """Arguments of the networks that are given."""
        return {key: value for key, value in asdict(self.policy_kwargs).items() if value is not None}

    def plain(self) -> dict[str, Any]:
        """Return everything except the seed that a training depends on, as plain values."""
        common = {
            key: value for key, value in asdict(self).items() if key in COMMON - {"name", "seeds", "search"}
        }
        # Settings without the fields of later versions keep their digest.
        if not self.privileged:
            del common["privileged"]
        if self.aids.touch_ramp is None:
            del common["aids"]["touch_ramp"]
        return {**common, "hyperparameters": self.hyperparameters, "policy_kwargs": self.network}

    @property
    def digest(self) -> str:
        """Digest of these settings: the first digits of a SHA-256."""
        text = json.dumps(self.plain(), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


@dataclass(frozen=True, kw_only=True)
class PPO(Settings):
    """Settings with the hyperparameters of stable-baselines3's PPO."""

    algorithm: Literal["PPO"] = "PPO"
    n_steps: Count | None = None
    n_epochs: Count | None = None
    gae_lambda: Share | None = None
    ent_coef: float | None = None
    vf_coef: float | None = None
    clip_range: float | Linear | None = None
    max_grad_norm: float | None = None
    target_kl: float | None = None
    use_sde: bool | None = None
    sde_sample_freq: Count | None = None


@dataclass(frozen=True, kw_only=True)
class RecurrentPPO(PPO):
    """Settings with the hyperparameters of sb3-contrib's PPO with a memory."""

    algorithm: Literal["RecurrentPPO"] = "RecurrentPPO"  # type: ignore[assignment]
    policy: Literal["MlpLstmPolicy"] = "MlpLstmPolicy"  # type: ignore[assignment]


@dataclass(frozen=True, kw_only=True)
class OffPolicy(Settings):
    """Settings with the hyperparameters of all algorithms with a replay buffer."""

    buffer_size: Count | None = None
    learning_starts: int | None = None
    train_freq: Count | None = None
    gradient_steps: int | None = None
    ent_coef: float | Entropy | None = None
    target_entropy: float | Literal["auto"] | None = None
    n_steps: Count | None = None


@dataclass(frozen=True, kw_only=True)
class SAC(OffPolicy):
    """Settings with the hyperparameters of stable-baselines3's SAC."""

    algorithm: Literal["SAC"] = "SAC"
    tau: Share | None = None
    target_update_interval: Count | None = None


@dataclass(frozen=True, kw_only=True)
class TQC(SAC):
    """Settings with the hyperparameters of sb3-contrib's TQC."""

    algorithm: Literal["TQC"] = "TQC"  # type: ignore[assignment]
    top_quantiles_to_drop_per_net: int | None = None


@dataclass(frozen=True, kw_only=True)
class CrossQ(OffPolicy):
    """Settings with the hyperparameters of sb3-contrib's CrossQ, which has no target networks."""

    algorithm: Literal["CrossQ"] = "CrossQ"
    policy_delay: Count | None = None


@dataclass(frozen=True, kw_only=True)
class RMA(Settings):
    """Settings of the second phase of rapid motor adaptation.

    Attributes
    ----------
    teacher : str
        Policy file of the first phase, which was trained with `privileged = true`; "{seed}" is replaced by
        the seed.
    n_steps : int
        Steps of each environment between two updates, which the gradient goes through.
    units : int
        Units of the memory.
    """

    algorithm: Literal["RMA"] = "RMA"
    teacher: str
    n_steps: Count = 64
    units: Count = 64

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.privileged or self.normalize or self.frame_stack > 1:
            raise SettingsError(
                "RMA needs privileged = true, normalize = false and no frame_stack: the teacher normalises"
            )


@dataclass(frozen=True, kw_only=True)
class Dynamics(Settings):
    """Settings of a dynamics model that `trundle.experiments.training.dynamics` trains.

    `n_timesteps` is the number of steps of the data, `batch_size` the number of episodes of an update, and
    `evaluation.every` counts updates.

    Attributes
    ----------
    n_steps : int
        Length of an episode of the data.
    random_share : float
        Share of the episodes with random pushes. The other ones push towards the goal.
    networks : int
        Number of networks of the ensemble.
    n_updates : int
        Number of updates of each network.
    units : int
        Units of the memory of past motion; 0: no memory, and therefore no adaptation.
    rollout : int
        Steps of the predictions whose errors an update reduces.
    """

    algorithm: Literal["Dynamics"] = "Dynamics"
    n_steps: Count = 160
    random_share: Share = 0.5
    networks: Count = 3
    n_updates: Count = 2000
    units: Natural = 64
    rollout: Count = 20

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.rollout >= self.n_steps:
            raise SettingsError(f"rollout = {self.rollout}: must be less than n_steps = {self.n_steps}")
        if self.privileged or self.frame_stack > 1 or self.aids != RewardShaping():
            raise SettingsError("Dynamics learns without privileged, frame_stack and aids: remove them")


COMMON = {one.name for one in fields(Settings)} - {"policy", "learning_rate", "batch_size", "gamma"}
"""Fields that are no hyperparameters."""
ALGORITHMS: dict[object, type[Settings]] = {
    kind.__name__: kind for kind in (PPO, RecurrentPPO, RMA, SAC, TQC, CrossQ, Dynamics)
}


def read(path: Path) -> Settings:
    """Read a training's file.

    Raises
    ------
    TrundleError
        If a key is missing, unknown or of another type, or a value is not allowed.
    """
    return build(path, parse_format(path, FORMAT))


def build(path: Path, table: Mapping[str, Any]) -> Settings:
    """Build the settings of a parsed file; errors as for `read`."""
    algorithm = table.get("algorithm")
    if algorithm == ADAPTIVE:
        raise TrundleError(f'{path}: algorithm = "{ADAPTIVE}" has no training: give --search')
    if algorithm not in ALGORITHMS:
        raise TrundleError(f"{path}: algorithm = {algorithm!r}: choose {', '.join(map(str, ALGORITHMS))}")
    return build_settings(path, ALGORITHMS[algorithm], {"name": path.stem, **table})
