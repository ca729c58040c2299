"""Layers of PyTorch as arrays; needs `trundle[rl]`."""

from __future__ import annotations

from typing import Any

from trundle.experiments.training.network import Layer, Memory

__all__ = ["layer_of", "memory_of"]


def layer_of(module: Any) -> Layer:
    """Return a `torch.nn.Linear` as arrays."""
    return array_of(module.weight), array_of(module.bias)


def memory_of(module: Any) -> Memory:
    """Return a `torch.nn.LSTM` of one layer as arrays."""
    bias = array_of(module.bias_ih_l0) + array_of(module.bias_hh_l0)
    return Memory(array_of(module.weight_ih_l0), array_of(module.weight_hh_l0), bias)


def array_of(parameter: Any) -> Any:
    """Return a parameter as an array of its own."""
    return parameter.detach().cpu().numpy().copy()
