"""Dynamics models: an ensemble of networks in NumPy, with a memory of the motion in an episode."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trundle.experiments.sampling import Floats
from trundle.experiments.training import array_file
from trundle.experiments.training.dynamics.motion import INPUTS, SHAPE, Motion, object_axes
from trundle.experiments.training.network import Network

__all__ = ["ACTIVATION", "About", "DynamicsModel", "Scales", "load"]

FORMAT = "trundle-dynamics/1"
ACTIVATION = "relu"
Values = NDArray[np.float32]
Context = list[Values | None]
"""State of the memory of each network, shape (n, 2, units); None without a memory."""


@dataclass(frozen=True)
class About:
    """Metadata of a dynamics model.

    Attributes
    ----------
    config, digest : str
        Name of the training's file, and digest of its settings.
    seed, steps, updates : int
        Seed, transitions and updates of each network of the training.
    env : str
        The environment's id.
    env_kwargs : dict
        Its arguments.
    period : float
        Duration of a step, s.
    """

    config: str
    digest: str
    seed: int
    steps: int
    updates: int
    env: str
    env_kwargs: dict[str, Any]
    period: float


@dataclass(frozen=True)
class Scales:
    """Scales of the values that the networks see and return.

    Attributes
    ----------
    mean, deviation : ndarray, shape (INPUTS + SHAPE + 3,)
        Of inputs, shapes, and changes of the twist.
    change : ndarray, shape (3,)
        Standard deviation of the change of the twist in a step. The outputs of a network are in this unit.
    """

    mean: Values
    deviation: Values
    change: Values

    def scaled(self, *parts: Floats) -> Values:
        """Return inputs, shapes and changes, or the first of these, as a network sees them: (n, entries)."""
        count = max(len(part) for part in parts)
        values = np.concatenate([np.broadcast_to(part, (count, part.shape[1])) for part in parts], axis=1)
        width = values.shape[1]
        return ((values - self.mean[:width]) / self.deviation[:width]).astype(np.float32)


class DynamicsModel:
    """An ensemble of networks, each of which predicts a step from its inputs, the shape and its memory.

    Parameters
    ----------
    about : About
    scales : Scales
    networks : sequence of Network
        Their layers see scaled inputs, the shape, and the output of the memory if there is one. They return
        the change of the twist, and the difference of the displacement from that at the mean twist.
    """

    def __init__(self, about: About, scales: Scales, networks: Sequence[Network]) -> None:
        self.about, self.scales, self.networks = about, scales, tuple(networks)

    @property
    def parameters(self) -> int:
        """Number of weights and biases."""
        return sum(network.parameters for network in self.networks)

    def start(self, count: int) -> Context:
        """Return the contexts at the start of `count` episodes."""
        return [
            None if network.memory is None else np.zeros((count, 2, network.memory.units), np.float32)
            for network in self.networks
        ]

    def remember(self, context: Context, motion: Motion, shape: Floats) -> Context:
        """Return the contexts after one step, with inputs (n, INPUTS) and targets (n, TARGETS)."""
        seen = self.scales.scaled(motion.inputs, shape, motion.targets[:, :3])
        return [
            None if network.memory is None or state is None else network.memory.step(seen, state)
            for network, state in zip(self.networks, context, strict=True)
        ]

    def rollout(
        self, context: Context, shape: Floats, start: tuple[Floats, Floats], wrenches: Floats
    ) -> Floats:
        """Return the motion under a sequence of wrenches, as each network predicts it.

        Parameters
        ----------
        context : list of ndarray
            Of one object or of n.
        shape : ndarray, shape (1 or n, SHAPE)
        start : pair of ndarray, shape (1 or n, 3)
            Pose and twist, world axes.
        wrenches : ndarray, shape (n, steps + 1, 3)
            Wrench at the start and at the end of each step about the object's origin, object axes.

        Returns
        -------
        ndarray, shape (networks, n, steps, 6)
            Pose and twist after each step, world axes.
        """
        motions = [
            self._rollout(fixed_context(network, state, self.scales, shape), start, wrenches)
            for network, state in zip(self.networks, context, strict=True)
        ]
        return np.stack(motions)

    def _rollout(self, network: Network, start: tuple[Floats, Floats], wrenches: Floats) -> Floats:
        """Return the motion that a network predicts whose layers see the inputs only."""
        mean, deviation = self.scales.mean[:INPUTS], self.scales.deviation[:INPUTS]
        count, steps = wrenches.shape[0], wrenches.shape[1] - 1
        pose, twist = (np.broadcast_to(one, (count, 3)) for one in start)
        twist = object_axes(twist, pose[:, 2])
        inputs = np.empty((steps, count, INPUTS), np.float32)
        pairs = np.concatenate([wrenches[:, :-1], wrenches[:, 1:]], axis=-1)
        inputs[..., 3:] = np.moveaxis((pairs - mean[3:]) / deviation[3:], 1, 0)
        states = np.empty((count, steps, 6))
        for step in range(steps):
            inputs[step, :, :3] = (twist - mean[:3]) / deviation[:3]
            outputs, _ = network.run(inputs[step], None)
            change, difference = outputs[:, :3] * self.scales.change, outputs[:, 3:] * self.scales.change
            moved = self.about.period * (twist + 0.5 * change + difference)
            pose = pose + object_axes(moved, -pose[:, 2])
            twist = object_axes(twist + change, moved[:, 2])
            states[:, step, :3] = pose
            states[:, step, 3:] = object_axes(twist, -pose[:, 2])
        return states

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the model atomically; the same model gives the same bytes."""
        arrays: dict[str, NDArray[Any]] = dict(vars(self.scales))
        for number, network in enumerate(self.networks):
            arrays |= {f"{number}_{key}": array for key, array in network.arrays().items()}
        array_file.save(path, FORMAT, {**asdict(self.about), "networks": len(self.networks)}, arrays)


def fixed_context(network: Network, state: Values | None, scales: Scales, shape: Floats) -> Network:
    """Return a network of the inputs alone: shape and memory become biases of the first layer."""
    (weight, bias), *others = network.layers
    seen = scales.scaled(np.zeros((len(shape), INPUTS)), shape)[:, INPUTS:]
    constant = bias + seen @ weight[:, INPUTS : INPUTS + SHAPE].T
    if state is not None:
        constant = constant + state[:, 0] @ weight[:, INPUTS + SHAPE :].T
    first = np.ascontiguousarray(weight[:, :INPUTS]), constant.astype(np.float32)
    return Network([first, *others], network.activation)


def load(path: str | os.PathLike[str]) -> DynamicsModel:
    """Read a dynamics model.

    Raises
    ------
    TrundleError
        If the file is not a dynamics model.
    FileNotFoundError
        If there is no such file.
    """

    def build(about: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> DynamicsModel:
        count = about.pop("networks")
        scales = Scales(*(arrays[key] for key in ("mean", "deviation", "change")))
        networks = [Network.from_arrays(numbered(arrays, number), ACTIVATION) for number in range(count)]
        return DynamicsModel(About(**about), scales, networks)

    return array_file.load(path, FORMAT, "dynamics model", build)


def numbered(arrays: Mapping[str, NDArray[Any]], number: int) -> dict[str, NDArray[Any]]:
    """Return the arrays of a network by their own names."""
    start = f"{number}_"
    return {key.removeprefix(start): one for key, one in arrays.items() if key.startswith(start)}
