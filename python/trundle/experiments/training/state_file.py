"""Files of nested state as arrays and JSON. Reading one executes no code."""

from __future__ import annotations

import json
import sys
import zipfile
from collections import deque
from pathlib import Path
from typing import IO, Any

import numpy as np

from trundle._native import Snapshot

__all__ = ["load", "save"]

TREE = "tree"
"""Name of the array that holds the JSON, as UTF-8."""


def save(file: IO[bytes], state: Any) -> None:
    """Write nested dictionaries, lists, tuples and deques of numbers, strings, arrays, tensors and snapshots.

    Raises
    ------
    TypeError
        If the state holds anything else.
    """
    arrays: dict[str, Any] = {}
    tree = json.dumps(_encoded(state, arrays)).encode()
    arrays[TREE] = np.frombuffer(tree, np.uint8)
    np.savez(file, **arrays)


def load(path: Path) -> Any:
    """Return a state that `save` has written.

    Raises
    ------
    ValueError
        If the file has another content, or is damaged.
    """
    try:
        with np.load(path, allow_pickle=False) as found:
            return _decoded(json.loads(found[TREE].tobytes()), found)
    except (KeyError, IndexError, TypeError, EOFError, zipfile.BadZipFile) as error:
        raise ValueError(f"{type(error).__name__}: {error}") from error


def _encoded(value: Any, arrays: dict[str, Any]) -> Any:
    """Return a value as JSON: a leaf unchanged, other values as a list that begins with the kind."""
    if value is None or type(value) in (bool, int, float, str):
        return value
    if isinstance(value, dict):
        return ["dict", [[_encoded(key, arrays), _encoded(each, arrays)] for key, each in value.items()]]
    if type(value) in (list, tuple):
        return [type(value).__name__, [_encoded(each, arrays) for each in value]]
    if isinstance(value, deque):
        return ["deque", value.maxlen, [_encoded(each, arrays) for each in value]]
    if isinstance(value, Snapshot):
        options, state = value.__getnewargs__()
        return ["snapshot", options, _kept(np.frombuffer(state, np.uint8), arrays)]
    if isinstance(value, (np.ndarray, np.generic)) and value.dtype != object:
        return ["scalar" if isinstance(value, np.generic) else "array", _kept(np.asarray(value), arrays)]
    torch: Any = sys.modules.get("torch")
    if torch is not None and isinstance(value, torch.Tensor):
        return ["tensor", _kept(value.detach().cpu().numpy(), arrays)]
    if type(value).__name__ == "RunningMeanStd":
        return ["moments", _encoded(vars(value), arrays)]
    raise TypeError(f"a state cannot hold {type(value)}")


def _kept(array: np.ndarray[Any, Any], arrays: dict[str, Any]) -> str:
    name = f"a{len(arrays)}"
    arrays[name] = array
    return name


def _decoded(value: Any, arrays: Any) -> Any:
    if not isinstance(value, list):
        return value
    kind, *rest = value
    if kind == "dict":
        return {_decoded(key, arrays): _decoded(each, arrays) for key, each in rest[0]}
    if kind in ("list", "tuple"):
        values = [_decoded(each, arrays) for each in rest[0]]
        return values if kind == "list" else tuple(values)
    if kind == "deque":
        return deque((_decoded(each, arrays) for each in rest[1]), maxlen=rest[0])
    if kind == "snapshot":
        return Snapshot(rest[0], arrays[rest[1]].tobytes())
    if kind in ("array", "scalar"):
        array = arrays[rest[0]]
        return array if kind == "array" else array[()]
    if kind == "tensor":
        import torch

        return torch.from_numpy(arrays[rest[0]])
    if kind == "moments":
        from stable_baselines3.common.running_mean_std import RunningMeanStd

        moments = RunningMeanStd()
        vars(moments).update(_decoded(rest[0], arrays))
        return moments
    raise ValueError(f"{kind!r} is no kind of value")
