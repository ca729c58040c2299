"""One JSON log of the XL330 data set, and its PWM register."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from trundle.importers.layout import Floats, SourceError

__all__ = ["ServoLog", "mask_wraps", "read_log"]

COLUMNS = ("timestamp", "position", "speed", "load", "input_volts", "goal_position", "torque_enable")
WRAP = 65536
"""Number of values of the PWM register."""
MAX_DUTY = 885
"""Largest absolute value that the servo writes to the register."""
TOLERANCE = 1.5
"""Tolerance of a value between its neighbours, in steps of the register."""


@dataclass(frozen=True)
class ServoLog:
    """A log.

    Attributes
    ----------
    mass, length : float
        Load of the pendulum, kg and m.
    kp, vin : float
        Gain of the position loop, in the unit of the firmware, and nominal voltage.
    trajectory : str
        Name of the commanded motion.
    columns : dict of str to (n,) array
        Samples of `COLUMNS`.
    """

    mass: float
    length: float
    kp: float
    vin: float
    trajectory: str
    columns: dict[str, Floats]


def read_log(path: Path) -> ServoLog | None:
    """Read a log; None for a JSON file without `entries`, such as the published parameters."""
    if not path.is_file():
        raise SourceError(path, "no such file")
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise SourceError(path, f"not valid JSON: {error}; download it again") from error
    if not isinstance(content, dict):
        raise SourceError(path, "must be a JSON object with `entries`; is it a file of the data set?")
    if "entries" not in content:
        return None
    entries = content["entries"]
    if not isinstance(entries, list) or len(entries) < 2:
        raise SourceError(path, "`entries` must be a list of at least two samples")
    columns = {
        name: np.array([_value(path, row, entry, name) for row, entry in enumerate(entries, 1)])
        for name in COLUMNS
    }
    late = np.flatnonzero(np.diff(columns["timestamp"]) <= 0.0)
    if len(late):
        row = int(late[0]) + 2
        raise SourceError(
            path, f"entry {row}: timestamp {columns['timestamp'][row - 1]:.9g} s is not after the one before"
        )
    mass, length, kp, vin = (_positive(path, content, key) for key in ("mass", "length", "kp", "vin"))
    return ServoLog(mass, length, kp, vin, str(content.get("trajectory", "unknown")), columns)


def mask_wraps(register: Floats) -> tuple[Floats, int]:
    """Return the signed values of the PWM register, NaN where they are wrong, and the number of those.

    The logs are resampled, and a value between -1 (65535) and 0 of the unsigned register is interpolated to
    anything between the two. Such values are beyond the range of the register, or outside the interval of
    their neighbours next to a wrap.

    Parameters
    ----------
    register : (n,) array
        Unsigned 16-bit values, resampled.
    """
    signed = np.where(register > WRAP / 2, register - WRAP, register)
    wrong = np.abs(signed) > MAX_DUTY + TOLERANCE
    wraps = np.flatnonzero(np.abs(np.diff(register)) > MAX_DUTY)
    for k in np.unique(np.concatenate([wraps - 1, wraps, wraps + 1, wraps + 2])):
        if not 0 < k < len(signed) - 1 or wrong[k]:
            continue
        before, after = np.flatnonzero(~wrong[:k]), np.flatnonzero(~wrong[k + 1 :])
        if len(before) and len(after):
            ends = sorted((signed[before[-1]], signed[k + 1 + after[0]]))
            wrong[k] = not ends[0] - TOLERANCE <= signed[k] <= ends[1] + TOLERANCE
    return np.where(wrong, np.nan, signed), int(np.sum(wrong))


def _value(path: Path, row: int, entry: Any, name: str) -> float:
    value = entry.get(name) if isinstance(entry, dict) else None
    if not isinstance(value, int | float) or not np.isfinite(value):
        raise SourceError(path, f"entry {row}: {name} = {value!r} must be a number; is the file complete?")
    return float(value)


def _positive(path: Path, content: dict[str, Any], key: str) -> float:
    value = content.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < float("inf"):
        raise SourceError(path, f"{key} = {value!r} must be a positive number; is it a file of the data set?")
    return float(value)
