"""Settings that all trainings have: environment, networks, seeds, evaluations."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, field, fields
from typing import Annotated, Any, Literal

from trundle.envs.ids import has_obstacles, task_of
from trundle.experiments.search.ranges import Search, check_split
from trundle.rules import Count, EnvOptions, Rule, Share, pattern
from trundle.settings import SettingsError

__all__ = ["SEED_STRIDE", "Entropy", "Evaluation", "Linear", "Network", "RewardShaping", "Settings", "Task"]

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
    detour_cost : float
        Cost per second and metre of a detour: by how much the shortest path to the goal around obstacles is
        longer than without them, for the bounding box of the object. With 1 the reward contains the length
        of that path instead of the straight distance, so that pushing against an obstacle that is on the
        straight way is no local optimum. Paths are computed on a grid at the beginning of each episode, which
        takes some 15 ms. For tasks of version 1 with obstacles.
    """

    success_bonus: float = 0.0
    loss_cost: float = 100.0
    miss_cost: float = 0.0
    turn_cost: float = 0.0
    touch_ramp: tuple[float, float] | None = None
    detour_cost: float = 0.0

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
    algorithm : {"PPO", "RecurrentPPO", "RMA", "SAC", "TQC", "CrossQ", "HER", "Dynamics"}
        Of stable-baselines3 and sb3-contrib; RMA, HER and Dynamics: `rma`, `hindsight` and `dynamics` here.
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
        if self.aids.detour_cost and (self.env.endswith("-v0") or not has_obstacles(self.env)):
            raise SettingsError(
                f"aids.detour_cost: {self.env} does not observe obstacles and the middle of the object; "
                "choose version 1 of PushAround or PushDoor"
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
        if not self.aids.detour_cost:
            del common["aids"]["detour_cost"]
        return {**common, "hyperparameters": self.hyperparameters, "policy_kwargs": self.network}

    @property
    def digest(self) -> str:
        """Digest of these settings: the first digits of a SHA-256."""
        text = json.dumps(self.plain(), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


COMMON = {one.name for one in fields(Settings)} - {"policy", "learning_rate", "batch_size", "gamma"}
"""Fields that are no hyperparameters."""
