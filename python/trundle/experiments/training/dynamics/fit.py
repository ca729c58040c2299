"""Fit a network of a dynamics model to observed motion; needs `trundle[rl]`."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray

from trundle.experiments.training.config import Dynamics
from trundle.experiments.training.dynamics.collect import Episodes
from trundle.experiments.training.dynamics.model import ACTIVATION, Scales
from trundle.experiments.training.dynamics.motion import INPUTS, SHAPE, TARGETS, motion_of, shape_of
from trundle.experiments.training.network import Network
from trundle.experiments.training.torch_arrays import layer_of, memory_of

__all__ = ["Data", "Predictor", "fit", "scales_of"]

Show = Callable[[int, "Predictor"], object]

NET_ARCH = [64, 64]
LEARNING_RATE = 2e-3
BATCH_SIZE = 32
ROLLOUTS_PER_EPISODE = 12
"""Predictions from each episode of a batch, at random times."""
MAX_GRADIENT_NORM = 1.0
MIN_DEVIATION = 1e-3
"""Smallest standard deviation of an input, so that a constant one keeps its value."""


class Data(NamedTuple):
    """Motion of episodes as arrays (steps, n, entries), float32, and the shapes of the objects (n, SHAPE)."""

    inputs: NDArray[np.float32]
    targets: NDArray[np.float32]
    shapes: NDArray[np.float32]
    valid: NDArray[np.bool_]

    @classmethod
    def of(cls, episodes: Episodes) -> Data:
        """Return the motion of episodes."""
        motion, shapes = motion_of(episodes.observations), shape_of(episodes.observations[0])
        inputs, targets, seen = (one.astype(np.float32) for one in (*motion, shapes))
        return cls(inputs, targets, seen, episodes.valid)


def scales_of(data: Data) -> Scales:
    """Return the scales of the valid steps."""
    steps = data.valid
    change = data.targets[steps][:, :3]
    parts = (data.inputs[steps], data.shapes, change)
    mean = np.concatenate([part.mean(axis=0) for part in parts])
    deviation = np.concatenate([part.std(axis=0) for part in parts])
    return Scales(mean, np.maximum(deviation, MIN_DEVIATION), change.std(axis=0))


class Predictor(torch.nn.Module):  # type: ignore[misc]
    """A memory (LSTM) of past steps, and dense layers that predict the next one."""

    def __init__(self, settings: Dynamics) -> None:
        super().__init__()
        units, widths = settings.units, settings.policy_kwargs.net_arch or NET_ARCH
        self.memory = torch.nn.LSTM(INPUTS + SHAPE + 3, units) if units else None
        sizes = [INPUTS + SHAPE + units, *widths, TARGETS]
        self.layers = torch.nn.ModuleList(torch.nn.Linear(before, after) for before, after in pairwise(sizes))

    def contexts(self, seen: torch.Tensor) -> torch.Tensor:
        """Return the output of the memory before each step, shape (steps, n, units)."""
        if self.memory is None:
            return seen[..., :0]
        outputs, _ = self.memory(seen[:-1])
        return torch.cat([torch.zeros_like(outputs[:1]), outputs])

    def forward(self, values: torch.Tensor) -> torch.Tensor:
        """Return the outputs, shape (n, TARGETS)."""
        *hidden, last = self.layers
        for layer in hidden:
            values = torch.relu(layer(values))
        return last(values)

    def network(self) -> Network:
        """Return the network in NumPy."""
        memory = None if self.memory is None else memory_of(self.memory)
        return Network([layer_of(layer) for layer in self.layers], ACTIVATION, memory)


def fit(
    settings: Dynamics,
    data: Data,
    scales: Scales,
    period: float,
    seed: int,
    show: Show,
) -> Network:
    """Fit a network with the gradient through predictions of several steps and through its memory.

    Parameters
    ----------
    settings : Dynamics
    data : Data
    scales : Scales
    period : float
        Duration of a step, s.
    seed : int
    show : callable
        Called with the number of updates and the network, at the start, every `evaluation.every` updates and
        at the end.
    """
    torch.manual_seed(seed)
    random = np.random.default_rng(seed)
    predictor = Predictor(settings)
    rate = settings.learning_rate or LEARNING_RATE
    linear = isinstance(rate, str)
    most = float(str(rate).removeprefix("lin_"))
    optimizer = torch.optim.Adam(predictor.parameters(), lr=most)
    loss_of = Loss(settings, data, scales, period, random)
    for update in range(settings.n_updates):
        if update % settings.evaluation.every == 0:
            show(update, predictor)
        for group in optimizer.param_groups:
            group["lr"] = most * (1.0 - update / settings.n_updates) if linear else most
        optimizer.zero_grad()
        loss_of(predictor).backward()
        torch.nn.utils.clip_grad_norm_(predictor.parameters(), MAX_GRADIENT_NORM)
        optimizer.step()
    show(settings.n_updates, predictor)
    return predictor.network()


class Loss:
    """Mean Huber error of predicted motions from random times of random episodes.

    Errors are relative to the standard deviation of the change of the twist in a step, and of the
    displacement that it causes. Steps in contact and all later ones of a prediction have no weight.
    """

    def __init__(
        self, settings: Dynamics, data: Data, scales: Scales, period: float, random: np.random.Generator
    ) -> None:
        self._data, self._random, self._period = data, random, period
        self._count, self._rollout = settings.batch_size or BATCH_SIZE, settings.rollout
        self._mean, self._deviation, self._change = (
            torch.as_tensor(one, dtype=torch.float32)
            for one in (scales.mean, scales.deviation, scales.change)
        )

    def __call__(self, predictor: Predictor) -> torch.Tensor:
        """Return the loss on a new batch."""
        steps, episodes = self._data.valid.shape
        rows = self._random.integers(episodes, size=self._count)
        inputs, targets = (torch.from_numpy(one[:, rows]) for one in self._data[:2])
        shapes = torch.from_numpy(self._data.shapes[rows]).expand(steps, -1, -1)
        seen = (torch.cat([inputs, shapes, targets[..., :3]], dim=2) - self._mean) / self._deviation
        contexts = predictor.contexts(seen)
        times = self._random.integers(steps - self._rollout, size=(ROLLOUTS_PER_EPISODE, self._count))
        columns = np.broadcast_to(np.arange(self._count), times.shape)
        at, of = torch.from_numpy(times.ravel()), torch.from_numpy(columns.ravel().copy())
        constant = torch.cat([seen[at, of, INPUTS : INPUTS + SHAPE], contexts[at, of]], dim=1)
        valid = torch.from_numpy(self._data.valid[:, rows]).float()
        return self._error(predictor, (inputs, targets, valid), (at, of), constant)

    def _error(
        self,
        predictor: Predictor,
        motion: tuple[torch.Tensor, torch.Tensor, torch.Tensor],
        start: tuple[torch.Tensor, torch.Tensor],
        constant: torch.Tensor,
    ) -> torch.Tensor:
        inputs, targets, valid = motion
        at, of = start
        mean, deviation = self._mean[:INPUTS], self._deviation[:INPUTS]
        twist, weight = inputs[at, of, :3], torch.ones(len(at))
        total, weights = torch.zeros(()), torch.zeros(())
        for step in range(self._rollout):
            given, found = inputs[at + step, of], targets[at + step, of]
            values = (torch.cat([twist, given[:, 3:]], dim=1) - mean) / deviation
            outputs = predictor(torch.cat([values, constant], dim=1)) * self._change.repeat(2)
            moved = self._period * (twist + 0.5 * outputs[:, :3] + outputs[:, 3:])
            twist = twist + outputs[:, :3]
            wrong = twist - given[:, :3] - found[:, :3], (moved - found[:, 3:]) / self._period
            errors = torch.cat(wrong, dim=1) / self._change.repeat(2)
            weight = weight * valid[at + step, of]
            huber = torch.nn.functional.smooth_l1_loss(errors, torch.zeros_like(errors), reduction="none")
            total = total + (weight[:, None] * huber).sum()
            weights = weights + weight.sum()
            twist = rotated(twist, moved[:, 2])
        return total / (TARGETS * weights.clamp(min=1.0))


def rotated(twist: torch.Tensor, turn: torch.Tensor) -> torch.Tensor:
    """Return twists in axes that are turned by an angle."""
    cos, sin = torch.cos(turn), torch.sin(turn)
    x, y, spin = twist.unbind(dim=1)
    return torch.stack([cos * x + sin * y, cos * y - sin * x, spin], dim=1)
