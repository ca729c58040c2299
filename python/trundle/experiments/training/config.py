"""Settings of the trainings of all algorithms: hyperparameters with the names of RL Zoo."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal

from trundle._native import TrundleError
from trundle.experiments.training.hindsight import goal_id
from trundle.experiments.training.settings import Entropy, Linear, RewardShaping, Settings
from trundle.rules import Count, Natural, Share
from trundle.settings import SettingsError, build_settings, parse_format

__all__ = [
    "ADAPTIVE",
    "FORMAT",
    "HER",
    "PPO",
    "RMA",
    "SAC",
    "TQC",
    "CrossQ",
    "Dynamics",
    "RecurrentPPO",
    "build",
    "read",
]

FORMAT = "trundle-train/1"
ADAPTIVE: Final = "Adaptive"
"""The adaptive agent, whose settings a search tunes."""


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
class HER(SAC):
    """Settings of SAC with hindsight experience replay (Andrychowicz et al. 2017) on a sparse reward.

    `env` is a task with arrays of observations, on which evaluations run. The training uses its
    goal-conditioned version, such as "trundle/PushPoseGoal-v1" of "trundle/PushPose-v1".

    Attributes
    ----------
    n_sampled_goal : int
        Number of replayed goals for each real one.
    goal_selection_strategy : {"future", "final", "episode"}
    """

    algorithm: Literal["HER"] = "HER"  # type: ignore[assignment]
    policy: Literal["MultiInputPolicy"] = "MultiInputPolicy"  # type: ignore[assignment]
    n_sampled_goal: Count = 4
    goal_selection_strategy: Literal["future", "final", "episode"] = "future"

    def __post_init__(self) -> None:
        super().__post_init__()
        if goal_id(self.env) is None:
            raise SettingsError(
                f"env = {self.env}: has no goal-conditioned version; give one without a level, such as "
                'trundle/PushPose-v1, and the level in env_kwargs, as level = "hard"'
            )
        if self.privileged or self.frame != "world" or self.frame_stack > 1 or self.aids != RewardShaping():
            raise SettingsError("HER learns without privileged, frame, frame_stack and aids: remove them")
        if self.n_steps not in (None, 1):
            raise SettingsError(f"n_steps = {self.n_steps}: HER has no n-step returns")


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


ALGORITHMS: dict[object, type[Settings]] = {
    kind.__name__: kind for kind in (PPO, RecurrentPPO, RMA, SAC, TQC, CrossQ, HER, Dynamics)
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
