"""Files of nested state. Reading one creates objects of the listed types and runs no other code."""

from __future__ import annotations

import os
import pickle
import sys
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trundle._native import TrundleError
from trundle.atomic import atomic_file

__all__ = ["load", "save", "tensor"]

PROTOCOL = 4
ALLOWED = {
    "collections.OrderedDict",
    "collections.deque",
    "numpy.core.multiarray._reconstruct",
    "numpy.core.multiarray.scalar",
    "numpy.dtype",
    "numpy.ndarray",
    "stable_baselines3.common.running_mean_std.RunningMeanStd",
    "trundle._native.Snapshot",
    f"{__name__}.tensor",
}
"""Types and functions that a file may name. NumPy 2 has `core` under the name `_core`."""


def tensor(values: NDArray[Any]) -> Any:
    """Return a tensor with the values of an array."""
    import torch

    return torch.from_numpy(values)


class Pickler(pickle.Pickler):
    """Writes tensors as arrays."""

    def reducer_override(self, value: Any) -> Any:
        """Return how to create a tensor again."""
        torch: Any = sys.modules.get("torch")
        if torch is not None and isinstance(value, torch.Tensor):
            return tensor, (np.asarray(value.detach().cpu()),)
        return NotImplemented


class Unpickler(pickle.Unpickler):
    """Refuses everything that is not in `ALLOWED`."""

    def find_class(self, module: str, name: str) -> Any:
        """Return a type or function."""
        if f"{module}.{name}".replace("numpy._core.", "numpy.core.") not in ALLOWED:
            raise pickle.UnpicklingError(f"{module}.{name} is not allowed")
        return super().find_class(module, name)


def save(path: Path, state: Any) -> None:
    """Write nested containers of numbers, strings, arrays, tensors and snapshots atomically, to the disk."""
    with atomic_file(path) as part, part.open("wb") as file:
        Pickler(file, PROTOCOL).dump(state)
        file.flush()
        os.fsync(file.fileno())


def load(path: Path) -> Any:
    """Return a state that `save` has written.

    Raises
    ------
    TrundleError
        If the file has another content, or is damaged.
    """
    try:
        with path.open("rb") as file:
            return Unpickler(file).load()
    except Exception as error:  # damaged files raise various errors
        raise TrundleError(
            f"{path}: not a checkpoint ({error}): remove the file to restart the training"
        ) from error
