"""Trained policies: small files that NumPy alone can read and run."""

from __future__ import annotations

import os
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trundle._native import TrundleError
from trundle.experiments.sampling import Floats
from trundle.experiments.training import array_file
from trundle.experiments.training.frames import entry_count, to_frame
from trundle.experiments.training.network import Network

__all__ = ["About", "Policy", "load"]

FORMAT = "trundle-policy/1"
State = NDArray[np.float32]


@dataclass(frozen=True)
class About:
    """Metadata of a policy.

    Attributes
    ----------
    config, digest : str
        Name of the training's file, and digest of its settings.
    algorithm : str
    seed, steps : int
        Of the training.
    env : str
        The environment's id.
    env_kwargs : dict
        Its arguments.
    entries : int
        Number of entries of the environment's observations.
    frame : str
        Frame of the network's observations.
    frame_stack : int
        Number of stacked observations.
    activation : {"tanh", "relu"}
    squashed : bool
        Whether actions are the hyperbolic tangent of the last layer; otherwise they are clipped.
    clip_obs : float
        Limit of an input, in standard deviations.
    hidden : int
        Number of hidden parameters that `trundle.envs.Oracle` appends to the observations; `entries` counts
        them too.
    """

    config: str
    digest: str
    algorithm: str
    seed: int
    steps: int
    env: str
    env_kwargs: dict[str, Any]
    entries: int
    frame: str
    frame_stack: int
    activation: str
    squashed: bool
    clip_obs: float
    hidden: int = 0


class Policy:
    """A network that maps the last observations to the mean action.

    It has the `predict` of stable-baselines3's algorithms, for unwrapped observations of the environment, or
    of `trundle.envs.Oracle` if `about.hidden` is not 0. It converts the frame, stacks and normalises itself.

    Parameters
    ----------
    about : About
    mean, deviation : ndarray, shape (frame_stack * entry_count,)
        Normalisation of the inputs, oldest observation first. `frames.entry_count` returns the number of
        entries of each.
    network : Network
    """

    def __init__(self, about: About, mean: Floats, deviation: Floats, network: Network) -> None:
        self.about = about
        self.mean, self.deviation, self.network = mean, deviation, network

    @property
    def parameters(self) -> int:
        """Number of weights and biases."""
        return self.network.parameters

    def predict(
        self,
        observation: Any,
        state: State | None = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.float32], State]:
        """Return the next action of each environment.

        Parameters
        ----------
        observation : ndarray, shape (entries,) or (n, entries)
            Of one environment, or of n.
        state : ndarray, shape (n, frame_stack, width) or (n, 2, units), optional
            The state returned by the previous call; None at the start of episodes.
        episode_start : bool or ndarray of bool, shape (n,), optional
            Where it is True the state is reset.
        deterministic : bool
            Ignored: a policy always returns its mean action.

        Returns
        -------
        actions : ndarray, shape (3,) or (n, 3)
            In the action space.
        state : ndarray, shape (n, frame_stack, width) or (n, 2, units)
            The last observations as network inputs, zeros before the start of an episode; or the state of the
            network's memory.

        Raises
        ------
        TrundleError
            If the observations have another number of entries than those of the training's environment.
        """
        rows = np.asarray(observation, dtype=np.float64)
        many, entries = np.atleast_2d(rows), self.about.entries
        if rows.ndim not in (1, 2) or many.shape[1] != entries:
            raise TrundleError(
                f"an observation of shape {rows.shape} does not fit this policy: "
                f"{self.about.env} with {self.about.env_kwargs} has {entries} entries"
            )
        state = self._begun(state, episode_start, len(many))
        seen = to_frame(many, self.about.env, self.about.frame, self.about.hidden)
        if self.network.memory is None:
            state = np.concatenate([state[:, 1:], seen[:, None]], axis=1)
            values, _ = self.network.run(self._normalised(state.reshape(len(many), -1)), None)
        else:
            values, after = self.network.run(self._normalised(seen), state)
            state = state if after is None else after
        actions = np.tanh(values) if self.about.squashed else np.clip(values, -1, 1)
        return actions.reshape((*rows.shape[:-1], actions.shape[1])), state

    def _begun(self, state: State | None, episode_start: Any, count: int) -> State:
        """Return the state before an observation, zeros where an episode starts."""
        memory, about = self.network.memory, self.about
        width = entry_count(about.entries, about.frame)
        shape = (count, about.frame_stack, width) if memory is None else (count, 2, memory.units)
        if state is None or state.shape != shape:
            return np.zeros(shape, dtype=np.float32)
        begun = np.broadcast_to(np.asarray(False if episode_start is None else episode_start), count)
        return np.where(begun[:, None, None], np.float32(0), state)

    def _normalised(self, inputs: State) -> State:
        limit = self.about.clip_obs
        return np.clip((inputs - self.mean) / self.deviation, -limit, limit).astype(np.float32)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the policy atomically; the same policy gives the same bytes."""
        arrays = {"mean": self.mean, "deviation": self.deviation, **self.network.arrays()}
        array_file.save(path, FORMAT, asdict(self.about), arrays)


def load(path: str | os.PathLike[str]) -> Policy:
    """Read a trained policy.

    Parameters
    ----------
    path : path-like
        A `.npz` that `trundle train` wrote.

    Raises
    ------
    TrundleError
        If the file is not a policy.
    FileNotFoundError
        If there is no such file.
    """

    def build(about: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> Policy:
        network = Network.from_arrays(arrays, about["activation"])
        return Policy(About(**about), arrays["mean"], arrays["deviation"], network)

    return array_file.load(path, FORMAT, "policy", build)
