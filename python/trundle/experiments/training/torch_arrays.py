"""Layers of PyTorch as arrays; needs `trundle[rl]`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from trundle.experiments.training.network import Layer, Memory

__all__ = ["layer_of", "layers_of", "memory_of"]


def layers_of(modules: Iterable[Any]) -> list[Layer]:
    """Return the linear layers among modules as arrays.

    The batch renormalisation before a layer (Ioffe 2017; in the networks of CrossQ) becomes part of it, with
    its running statistics.
    """
    layers, renormalisation = [], None
    for module in modules:
        if hasattr(module, "ra_mean"):
            renormalisation = module
        elif hasattr(module, "weight"):
            weight, bias = layer_of(module)
            if renormalisation is not None:
                gain, offset = affine_of(renormalisation)
                weight, bias = weight * gain, bias + weight @ offset
            layers.append((weight, bias))
            renormalisation = None
    return layers


def affine_of(module: Any) -> Layer:
    """Return gain and offset of a `BatchRenorm` of sb3-contrib in evaluation."""
    mean, variance, scale, bias = map(array_of, (module.ra_mean, module.ra_var, module.scale, module.bias))
    gain = scale / np.sqrt(variance + module.eps)
    return gain, bias - gain * mean


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
