"""Trained policies: small files that NumPy alone can read and run."""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trundle._native import TrundleError
from trundle.atomic import atomic_file
from trundle.experiments.training.frames import entry_count, to_frame

__all__ = ["About", "Policy", "load"]

FORMAT = "trundle-policy/1"
ABOUT = "about"
Array = NDArray[np.float64]
Past = NDArray[np.float32]
Layer = tuple[NDArray[np.float32], NDArray[np.float32]]


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


class Policy:
    """A network that maps the last observations to the mean action.

    It has the `predict` of stable-baselines3's algorithms, for unwrapped observations of the environment: it
    converts the frame, stacks and normalises by itself.

    Parameters
    ----------
    about : About
    mean, deviation : ndarray, shape (frame_stack * entry_count,)
        Normalisation of the inputs, oldest observation first. `frames.entry_count` returns the number of
        entries of each.
    layers : list of (weight, bias)
        Shapes (outputs, inputs) and (outputs,).
    """

    def __init__(self, about: About, mean: Array, deviation: Array, layers: list[Layer]) -> None:
        self.about = about
        self._mean, self._deviation, self._layers = mean, deviation, layers

    @property
    def parameters(self) -> int:
        """Number of weights and biases."""
        return sum(weight.size + bias.size for weight, bias in self._layers)

    def predict(
        self,
        observation: Any,
        state: Past | None = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.float32], Past]:
        """Return the next action of each environment.

        Parameters
        ----------
        observation : ndarray, shape (entries,) or (n, entries)
            Of one environment, or of n.
        state : ndarray, shape (n, frame_stack, width), optional
            The state returned by the previous call; None at the start of episodes.
        episode_start : bool or ndarray of bool, shape (n,), optional
            Where it is True the state is reset.
        deterministic : bool
            Ignored: a policy always returns its mean action.

        Returns
        -------
        actions : ndarray, shape (3,) or (n, 3)
            In the action space.
        state : ndarray, shape (n, frame_stack, width)
            The last observations as network inputs, zeros before the start of an episode.

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
        past = self._past(state, episode_start, len(many))
        past = np.concatenate(
            [past[:, 1:], to_frame(many, self.about.env, self.about.frame)[:, None]], axis=1
        )
        actions = self._network(past.reshape(len(many), -1))
        return actions.reshape((*rows.shape[:-1], actions.shape[1])), past

    def _past(self, state: Past | None, episode_start: Any, count: int) -> Past:
        shape = (count, self.about.frame_stack, entry_count(self.about.entries, self.about.frame))
        if state is None or state.shape != shape:
            return np.zeros(shape, dtype=np.float32)
        begun = np.broadcast_to(np.asarray(False if episode_start is None else episode_start), count)
        return np.where(begun[:, None, None], np.float32(0), state)

    def _network(self, inputs: Past) -> NDArray[np.float32]:
        limit = self.about.clip_obs
        values = np.clip((inputs - self._mean) / self._deviation, -limit, limit).astype(np.float32)
        *hidden, last = self._layers
        for weight, bias in hidden:
            values = values @ weight.T + bias
            values = np.tanh(values) if self.about.activation == "tanh" else np.maximum(values, 0)
        values = values @ last[0].T + last[1]
        return np.tanh(values) if self.about.squashed else np.clip(values, -1, 1)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the policy atomically; the same policy gives the same bytes."""
        arrays: dict[str, Any] = {"mean": self._mean, "deviation": self._deviation}
        for k, (weight, bias) in enumerate(self._layers):
            arrays |= {f"weight_{k}": weight, f"bias_{k}": bias}
        arrays[ABOUT] = np.array(json.dumps({"format": FORMAT, **asdict(self.about)}))
        with atomic_file(Path(path)) as part, part.open("wb") as file:
            np.savez_compressed(file, **arrays)


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
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = dict(file)
        about = json.loads(str(arrays.pop(ABOUT)))
        if about.pop("format") != FORMAT:
            raise ValueError("another format")
        count = sum(key.startswith("weight_") for key in arrays)
        layers = [(arrays[f"weight_{k}"], arrays[f"bias_{k}"]) for k in range(count)]
        return Policy(About(**about), arrays["mean"], arrays["deviation"], layers)
    except OSError:
        raise
    except Exception as error:  # damaged files raise various errors
        raise TrundleError(f"{path}: not a policy of `trundle train` ({error})") from error
