"""Wrappers that reveal hidden parameters, for upper bounds and privileged learning."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.utils import RecordConstructorArgs
from gymnasium.vector import VectorEnv, VectorObservationWrapper
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from trundle._native import TrundleError
from trundle.envs.push import Push
from trundle.envs.vector import PushVec

__all__ = ["Oracle", "VectorOracle"]

Array = NDArray[np.float64]

HIDDEN_VALUE_NAMES = (
    "mass (kg)",
    "mass centre x (m)",
    "mass centre y (m)",
    "radius of gyration (m)",
    "drag xx (N s/m)",
    "drag xy (N s/m)",
    "drag yy (N s/m)",
    "drag x, spin (N s)",
    "drag y, spin (N s)",
    "drag spin, spin (N m s)",
)


class Oracle(gym.ObservationWrapper[Array, Any, Array], RecordConstructorArgs):
    """Append ten hidden numbers to a flat observation: mass, mass centre, radius of gyration, wheel drag.

    The drag is the symmetric matrix of all viscous wheels together, about the object's origin in object axes;
    the motion determines nothing more about them. Other effects, such as casters, are not included;
    `info["hidden"]` of `reset` contains all hidden effects as tables of a `model.toml`.

    Pictures show the wheels with their friction along and across (N s/m).

    Parameters
    ----------
    env : gymnasium.Env
        A pushing environment of `trundle` with a flat observation, wrapped or not.

    Raises
    ------
    TrundleError
        If `env` is another environment.

    Examples
    --------
    >>> import gymnasium, trundle
    >>> env = trundle.envs.Oracle(gymnasium.make("trundle/LockedWheel-v0"))
    >>> observation, info = env.reset(seed=0)
    >>> observation.shape, env.NAMES[0]
    ((26,), 'mass (kg)')
    >>> info["hidden"]["effect"][0]["kind"]
    'viscous_wheel'
    """

    NAMES = HIDDEN_VALUE_NAMES
    """Names of the ten numbers."""

    def __init__(self, env: gym.Env[Array, Any]) -> None:
        RecordConstructorArgs.__init__(self)
        gym.ObservationWrapper.__init__(self, env)
        self._push = _require_pushing(env.unwrapped, Push)
        self._push.reveals = True
        self.observation_space = _extend_space(env.observation_space)  # type: ignore[assignment]

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begin an episode; `info["hidden"]` contains the hidden model."""
        observation, info = self.env.reset(seed=seed, options=options)
        return self.observation(observation), {**info, "hidden": self._push.hidden_model()}

    def observation(self, observation: Array) -> Array:
        """Return the observation with the hidden numbers."""
        return np.concatenate([observation, self._push.hidden_values()])


class VectorOracle(VectorObservationWrapper):
    """Append the same numbers to the observations of a batch.

    Like all observation wrappers, it does not support the autoreset mode "SameStep".

    Parameters
    ----------
    env : gymnasium.vector.VectorEnv
        A batch of pushing environments with flat observations.

    Raises
    ------
    TrundleError
        If `env` is another batch.

    Examples
    --------
    >>> import gymnasium, trundle
    >>> envs = trundle.envs.VectorOracle(gymnasium.make_vec("trundle/LockedWheel-v0", num_envs=4))
    >>> observations, infos = envs.reset(seed=0)
    >>> observations.shape
    (4, 26)
    """

    def __init__(self, env: VectorEnv[Any, Any, Any]) -> None:
        super().__init__(env)
        self._push = _require_pushing(env.unwrapped, PushVec)
        self.single_observation_space = _extend_space(env.single_observation_space)
        self.observation_space = batch_space(self.single_observation_space, env.num_envs)

    def observations(self, observations: Any) -> Any:
        """Return the observations with the hidden numbers."""
        return np.concatenate([observations, self._push.hidden_values()], axis=1)


def _require_pushing(env: Any, kind: Any) -> Any:
    if not isinstance(env, kind):
        raise TrundleError(f"{env}: is not a pushing environment of trundle")
    return env


def _extend_space(space: gym.Space[Any]) -> gym.spaces.Box:
    if not isinstance(space, gym.spaces.Box):
        raise TrundleError(f"an oracle needs a flat observation, not {space}: use FlattenObservation")
    unknown = np.full(len(HIDDEN_VALUE_NAMES), np.inf)
    return gym.spaces.Box(
        np.concatenate([space.low, -unknown]), np.concatenate([space.high, unknown]), dtype=np.float64
    )
