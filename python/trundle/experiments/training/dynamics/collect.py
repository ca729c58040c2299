"""Pushes from which a dynamics model learns: random ones, and ones towards the goal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from trundle.envs.observation import Observation
from trundle.experiments.sampling import Floats
from trundle.experiments.training.dynamics.motion import object_axes, wrapped

__all__ = ["Episodes", "collect"]


AMPLITUDES = (0.1, 1.0)
"""Standard deviation of random pushes, as a share of a full action; log-uniform in an episode."""
CORRELATION_TIMES_S = (0.1, 1.0)
"""Correlation time of random pushes; log-uniform in an episode."""
GAINS = (0.3, 3.0)
"""Full actions per metre and, times 0.3, per radian of the error of a push towards the goal; log-uniform."""
DAMPINGS = (0.2, 2.0)
"""Full actions per m/s and per rad/s of a push towards the goal; log-uniform."""
DIRECTED_NOISE = 0.2
"""Amplitude of the random part of a push towards the goal, relative to that of a random push."""
SPEED_LIMIT, SPIN_LIMIT = 1.5, 3.0
"""Speed (m/s) and spin (rad/s) above which a push brakes, so that few objects are lost."""


class Episodes(NamedTuple):
    """Observations of episodes of the same length.

    Attributes
    ----------
    observations : ndarray, shape (steps + 1, n, entries)
    valid : ndarray of bool, shape (steps, n)
        Steps of an episode without contact with an obstacle. After the end of an episode none is valid.
    """

    observations: Floats
    valid: NDArray[np.bool_]


def collect(
    env: str, env_kwargs: Mapping[str, Any], first: int, count: int, steps: int, random_share: float
) -> Episodes:
    """Push objects at random or towards the goal.

    Parameters
    ----------
    env : str
        The environment's id.
    env_kwargs : mapping
        Its arguments.
    first, count : int
        The seeds are `first` to `first + count - 1`. The first one also determines the pushes.
    steps : int
        Length of an episode.
    random_share : float
        Share of the episodes with random pushes.
    """
    worlds: Any = gym.make_vec(env, count, "vector_entry_point", **env_kwargs)
    period = 1.0 / worlds.metadata["render_fps"]
    pushes = Pushes(np.random.default_rng(first), count, random_share, period)
    seen, _ = worlds.reset(seed=first)
    observations, valid, under_way = [seen], [], np.ones(count, dtype=bool)
    for _ in range(steps):
        seen, _, terminated, truncated, infos = worlds.step(pushes.actions(Observation(seen)))
        observations.append(seen)
        valid.append(under_way & (infos["touched"] == 0))
        under_way = under_way & ~(terminated | truncated)
    worlds.close()
    return Episodes(np.stack(observations), np.stack(valid))


class Pushes:
    """Actions of all episodes: autoregressive noise, and a proportional controller with damping."""

    def __init__(self, random: np.random.Generator, count: int, random_share: float, period: float) -> None:
        def log_uniform(limits: tuple[float, float]) -> Floats:
            low, high = (float(one) for one in np.log(limits))
            return np.exp(random.uniform(low, high, (count, 1)))

        self._random = random
        self._directed = np.arange(count)[:, None] >= random_share * count
        self._amplitude = log_uniform(AMPLITUDES) * np.where(self._directed, DIRECTED_NOISE, 1.0)
        self._kept = np.exp(-period / log_uniform(CORRELATION_TIMES_S))
        self._gain, self._damping = log_uniform(GAINS), log_uniform(DAMPINGS)
        self._noise = random.standard_normal((count, 3))

    def actions(self, seen: Observation) -> NDArray[np.float32]:
        """Return the next actions, shape (n, 3)."""
        fresh = self._random.standard_normal(self._noise.shape)
        self._noise = self._kept * self._noise + np.sqrt(1.0 - self._kept**2) * fresh
        twist = object_axes(seen.twist, seen.heading)
        away = object_axes(seen.goal_pose - seen.pose, seen.heading)
        away[:, 2] = 0.3 * wrapped(away[:, 2])
        directed = self._gain * away - self._damping * twist
        action = self._amplitude * self._noise + np.where(self._directed, directed, 0.0)
        limits = np.array([SPEED_LIMIT, SPEED_LIMIT, SPIN_LIMIT])
        fast = (np.abs(twist) > limits).any(axis=1, keepdims=True)
        return np.clip(np.where(fast, -twist / limits, action), -1.0, 1.0).astype(np.float32)
