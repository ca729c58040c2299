"""Networks of trained policies in NumPy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Layer", "Memory", "Network"]

Values = NDArray[np.float32]
Layer = tuple[Values, Values]
"""Weight (outputs, inputs) and bias (outputs,)."""


@dataclass(frozen=True)
class Memory:
    """A layer of long short-term memory (Hochreiter & Schmidhuber 1997), with PyTorch's order of gates.

    Attributes
    ----------
    inputs : ndarray, shape (4 units, entries)
        Weights of the inputs: input gate, forget gate, cell, output gate.
    recurrent : ndarray, shape (4 units, units)
        Weights of the last output.
    bias : ndarray, shape (4 units,)
    """

    inputs: Values
    recurrent: Values
    bias: Values

    @property
    def units(self) -> int:
        """Number of outputs."""
        return int(self.recurrent.shape[1])

    def step(self, values: Values, state: Values) -> Values:
        """Return the next state.

        Parameters
        ----------
        values : ndarray, shape (n, entries)
        state : ndarray, shape (n, 2, units)
            Output and cell; zeros at the start of an episode.
        """
        gates = values @ self.inputs.T + state[:, 0] @ self.recurrent.T + self.bias
        enter, forget, cell, leave = np.split(gates, 4, axis=1)
        kept = sigmoid(forget) * state[:, 1] + sigmoid(enter) * np.tanh(cell)
        return np.stack([sigmoid(leave) * np.tanh(kept), kept], axis=1).astype(np.float32)


@dataclass(frozen=True)
class Network:
    """A network of dense layers, with a memory before them if it has one.

    Without `estimate`, the layers see the output of the memory. With it they see the inputs, and the memory's
    estimate of the hidden parameters in place of the parameters.

    Attributes
    ----------
    layers : list of (weight, bias)
        The last one is linear.
    activation : {"tanh", "relu"}
        Of the other layers.
    memory : Memory, optional
    estimate : (weight, bias), optional
        Linear layer from the output of the memory to the hidden parameters.
    """

    layers: list[Layer]
    activation: str
    memory: Memory | None = None
    estimate: Layer | None = None

    @property
    def parameters(self) -> int:
        """Number of weights and biases."""
        return sum(array.size for array in self.arrays().values())

    def run(self, inputs: Values, state: Values | None) -> tuple[Values, Values | None]:
        """Return the outputs, shape (n, outputs), and the next state of the memory."""
        values = inputs
        if self.memory is not None and state is not None:
            state = self.memory.step(inputs, state)
            values = state[:, 0]
            if self.estimate is not None:
                weight, bias = self.estimate
                values = np.concatenate([inputs, values @ weight.T + bias], axis=1)
        *hidden, last = self.layers
        for weight, bias in hidden:
            values = values @ weight.T + bias
            values = np.tanh(values) if self.activation == "tanh" else np.maximum(values, 0)
        return values @ last[0].T + last[1], state

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays by their names in a file."""
        found: dict[str, NDArray[Any]] = {}
        for k, (weight, bias) in enumerate(self.layers):
            found |= {f"weight_{k}": weight, f"bias_{k}": bias}
        if self.memory is not None:
            found |= {f"memory_{key}": array for key, array in vars(self.memory).items()}
        if self.estimate is not None:
            found |= dict(zip(("estimate_weight", "estimate_bias"), self.estimate, strict=True))
        return found

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]], activation: str) -> Network:
        """Return the network of `arrays`.

        Raises
        ------
        KeyError
            If an array is missing.
        """
        count = sum(key.startswith("weight_") for key in arrays)
        layers = [(arrays[f"weight_{k}"], arrays[f"bias_{k}"]) for k in range(count)]
        memory = estimate = None
        if "memory_bias" in arrays:
            memory = Memory(*(arrays[f"memory_{key}"] for key in ("inputs", "recurrent", "bias")))
        if "estimate_bias" in arrays:
            estimate = arrays["estimate_weight"], arrays["estimate_bias"]
        return cls(layers, activation, memory, estimate)


def sigmoid(values: Values) -> Values:
    """Return the logistic function."""
    return np.asarray(0.5 * (1.0 + np.tanh(0.5 * values)), dtype=np.float32)
