"""Rapid motor adaptation (Kumar et al. 2021), second phase; needs `trundle[rl]`.

A teacher was trained with the hidden parameters as input. A memory now learns to estimate them from the past
observations, while the teacher acts on the estimates.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.utils import obs_as_tensor

from trundle._native import TrundleError
from trundle.experiments.training.network import Network
from trundle.experiments.training.policy import load
from trundle.experiments.training.torch_arrays import layer_of, memory_of

__all__ = ["RMA"]

N_EPOCHS = 4
"""Updates with each rollout."""
LEARNING_RATE = 1e-3
MAX_GRADIENT_NORM = 1.0

State = tuple[torch.Tensor, torch.Tensor]


class Adaptation(torch.nn.Module):  # type: ignore[misc]
    """A memory that estimates hidden parameters from observations."""

    def __init__(self, entries: int, units: int, hidden: int) -> None:
        super().__init__()
        self.memory = torch.nn.LSTM(entries, units)
        self.estimate = torch.nn.Linear(units, hidden)

    def forward(self, seen: torch.Tensor, starts: torch.Tensor, state: State) -> tuple[torch.Tensor, State]:
        """Return the estimates (n, hidden) after the observations (n, entries), and the next state."""
        kept = (1.0 - starts)[None, :, None]
        output, state = self.memory(seen[None], (state[0] * kept, state[1] * kept))
        return self.estimate(output[0]), state


class RMA(BaseAlgorithm):  # type: ignore[misc]
    """Learn to estimate hidden parameters while the teacher acts on the estimates.

    Errors of the estimates are weighted by the teacher's first layer, so a parameter counts as much as the
    teacher uses it. This layer takes the place of the encoder of the paper.

    Parameters
    ----------
    teacher : str
        File of the privileged policy.
    env : VecEnv
        Its observations end with the hidden parameters, and are not normalised.
    n_steps : int
        Steps of each environment between two updates.
    units : int
        Units of the memory.
    learning_rate : float or callable
    seed : int
    device : str

    Raises
    ------
    TrundleError
        If the teacher does not fit the environment.
    """

    def __init__(
        self,
        teacher: str,
        env: Any,
        n_steps: int = 64,
        units: int = 64,
        learning_rate: Any = LEARNING_RATE,
        seed: int | None = None,
        device: str = "cpu",
    ) -> None:
        super().__init__(
            ActorCriticPolicy, env, learning_rate, seed=seed, device=device, support_multi_env=True
        )
        self.teacher = load(teacher)
        self.hidden, self.n_steps, self.units = self.teacher.about.hidden, n_steps, units
        entries = len(self.teacher.mean)
        squashed = self.teacher.about.squashed
        if self.hidden == 0 or squashed or self.observation_space.shape != (entries,):
            raise TrundleError(
                f"teacher = {teacher}: give a policy of PPO with privileged = true, for observations of "
                f"shape {self.observation_space.shape}; it has {entries} inputs, {self.hidden} of them hidden"
            )
        self._setup_model()

    def _setup_model(self) -> None:
        self._setup_lr_schedule()
        self.set_random_seed(self.seed)
        self.policy = Adaptation(len(self.teacher.mean) - self.hidden, self.units, self.hidden).to(
            self.device
        )
        self.optimizer = torch.optim.Adam(self.policy.parameters(), lr=self.lr_schedule(1))
        first, _ = self.teacher.network.layers[0]
        self._weights = torch.as_tensor(first[:, -self.hidden :].T.copy(), device=self.device)
        self._scales = [
            torch.as_tensor(array, dtype=torch.float32, device=self.device)
            for array in (self.teacher.mean, self.teacher.deviation)
        ]
        zeros = torch.zeros(1, self.n_envs, self.units, device=self.device)
        self.memory_state: State = zeros, zeros.clone()
        self._last_obs: Any
        self._last_episode_starts: Any

    def network(self) -> Network:
        """Return the teacher's network behind the estimate."""
        teacher, own = self.teacher.network, self.policy
        return Network(teacher.layers, teacher.activation, memory_of(own.memory), layer_of(own.estimate))

    def normalisation(self) -> tuple[Any, Any, float]:
        """Return mean, deviation and limit of the inputs."""
        teacher = self.teacher
        return teacher.mean[: -self.hidden], teacher.deviation[: -self.hidden], teacher.about.clip_obs

    def learn(
        self,
        total_timesteps: int,
        callback: Any = None,
        log_interval: int = 1,
        tb_log_name: str = "RMA",
        reset_num_timesteps: bool = True,
        progress_bar: bool = False,
    ) -> RMA:
        """Collect rollouts and update until `total_timesteps` more steps are made."""
        total, callback = self._setup_learn(
            total_timesteps, callback, reset_num_timesteps, tb_log_name, progress_bar
        )
        callback.on_training_start(locals(), globals())
        while self.num_timesteps < total:
            callback.on_rollout_start()
            start = self.memory_state
            rollout = self._collect(callback)
            callback.on_rollout_end()
            self._update_current_progress_remaining(self.num_timesteps, total)
            self._train(rollout, start)
        callback.on_training_end()
        return self

    def _collect(self, callback: Any) -> tuple[torch.Tensor, torch.Tensor]:
        """Return normalised observations (steps, n, entries) and starts of episodes (steps, n)."""
        seen, starts = [], []
        for _ in range(self.n_steps):
            values = self._normalised(self._last_obs)
            begun = torch.as_tensor(self._last_episode_starts, dtype=torch.float32, device=self.device)
            with torch.no_grad():
                entries = values[:, : -self.hidden]
                estimate, self.memory_state = self.policy(entries, begun, self.memory_state)
            inputs = torch.cat([entries, estimate], dim=1).cpu().numpy()
            outputs, _ = self.teacher.network.run(inputs, None)
            self._last_obs, _, dones, infos = self.env.step(np.clip(outputs, -1, 1))
            self._last_episode_starts = dones
            self.num_timesteps += self.n_envs
            self._update_info_buffer(infos, dones)
            callback.on_step()
            seen.append(values)
            starts.append(begun)
        return torch.stack(seen), torch.stack(starts)

    def _normalised(self, observations: Any) -> torch.Tensor:
        mean, deviation = self._scales
        limit = self.teacher.about.clip_obs
        return torch.clip((obs_as_tensor(observations, self.device) - mean) / deviation, -limit, limit)

    def _train(self, rollout: tuple[torch.Tensor, torch.Tensor], start: State) -> None:
        """Update the memory, with the gradient through the whole rollout."""
        self._update_learning_rate(self.optimizer)
        seen, starts = rollout
        loss = torch.zeros(())
        for _ in range(N_EPOCHS):
            state, errors = start, []
            for values, begun in zip(seen, starts, strict=True):
                estimate, state = self.policy(values[:, : -self.hidden], begun, state)
                errors.append((estimate - values[:, -self.hidden :]) @ self._weights)
            loss = torch.stack(errors).square().mean()
            self.optimizer.zero_grad()
            loss.backward()
            torch.nn.utils.clip_grad_norm_(self.policy.parameters(), MAX_GRADIENT_NORM)
            self.optimizer.step()
        self._n_updates += N_EPOCHS
        self.logger.record("train/loss", float(loss.detach()))

    def _get_torch_save_params(self) -> tuple[list[str], list[str]]:
        return ["policy", "optimizer"], []
