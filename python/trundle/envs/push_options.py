"""Options of a pushing environment and of its resets, as the native module expects them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike, fspath
from typing import Any

import numpy as np
import tomli_w

from trundle._native import TrundleError

__all__ = ["Names", "default_horizon", "options_toml", "reset_options"]

Names = str | PathLike[str] | Sequence[str | PathLike[str]]

RESET_OPTIONS = ("start", "goal", "grasp", "same_object")
DEFAULT_OBJECT = "office_table"


def options_toml(
    fixed: Mapping[str, Any],
    *,
    action: str = "wrench",
    object: Names | None = None,
    effects: Sequence[Mapping[str, Any]] = (),
    horizon: int | None = None,
    realtime: float | str | None = None,
    arm: Mapping[str, Any] | None = None,
    **others: Any,
) -> str:
    """Return options as TOML for the native module, without those that are None; `fixed` takes precedence."""
    for key, value in fixed.items():
        if others.get(key, value) not in (None, value):
            raise TrundleError(f"{key} = {others[key]!r}: this task has {value!r}; choose another task")
    if others.get("level") is not None and object is not None:
        raise TrundleError(f"level = {others['level']!r}, object = {object!r}: give one of them")
    if arm is not None and not isinstance(arm, Mapping):
        raise TrundleError(f"arm = {arm!r}: give a mapping, such as {{'lag': 0.08}}")
    if isinstance(realtime, str) and realtime != "measured":
        raise TrundleError(f"realtime = {realtime!r}: give a decision time in s, 'measured' or None")
    object = DEFAULT_OBJECT if object is None else object
    names = [object] if isinstance(object, (str, PathLike)) else object
    if not isinstance(names, Sequence) or not all(isinstance(name, (str, PathLike)) for name in names):
        raise TrundleError(f"object = {object!r}: give the name of an object or a sequence of names")
    if isinstance(effects, str) or not all(isinstance(effect, Mapping) for effect in effects):
        raise TrundleError(f"effects = {effects!r}: give tables as in model.toml, such as {{'kind': …}}")
    options = {
        "action": action,
        "object": [fspath(name) for name in names],
        "effects": [dict(effect) for effect in effects],
        "horizon": default_horizon(action, others.get("version", 0)) if horizon is None else horizon,
        "arm": None if arm is None else {key: _plain(value) for key, value in arm.items()},
        "decision_time": None if isinstance(realtime, str) else realtime,
        "measures_decisions": isinstance(realtime, str),
        **others,
        **fixed,
    }
    return tomli_w.dumps({key: _plain(value) for key, value in options.items() if value is not None})


def default_horizon(action: str, version: int) -> int:
    """Return the steps after which an episode is truncated by default; 0: never."""
    if action == "push":
        return 30
    return 300 if version == 0 else 0


def _plain(value: Any) -> Any:
    """Convert NumPy numbers and arrays, and tuples, to what TOML can hold."""
    return value.tolist() if isinstance(value, (np.generic, np.ndarray)) else value


def reset_options(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return reset options as the native module expects them."""
    for key in given:
        if key not in RESET_OPTIONS:
            raise TrundleError(f"unknown reset option {key!r}; known are {', '.join(RESET_OPTIONS)}")
    return {
        "start": _numbers("start", given.get("start"), 3),
        "goal": _numbers("goal", given.get("goal"), 3),
        "grasp": _numbers("grasp", given.get("grasp"), 2),
        "same_object": _boolean("same_object", given.get("same_object", False)),
    }


def _boolean(key: str, value: Any) -> bool:
    if not isinstance(value, (bool, np.bool_)):
        raise TrundleError(f"reset option {key!r} = {value!r}: give True or False")
    return bool(value)


def _numbers(key: str, value: Any, count: int) -> list[float] | None:
    if value is None:
        return None
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape != (count,):
        raise TrundleError(f"reset option {key!r} = {value!r}: give {count} numbers")
    return [float(entry) for entry in array]
