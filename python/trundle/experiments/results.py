"""Files of results: JSON lines whose bytes depend on the results alone."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from trundle._native import TrundleError
from trundle.atomic import write_text

__all__ = ["Row", "read_headed", "read_lines", "read_trials", "rounded", "write_lines", "write_trials"]

Row = dict[str, Any]


def write_lines(path: Path, values: Iterable[Any]) -> None:
    """Write values as JSON lines, atomically."""
    write_text(path, "".join(json.dumps(value, sort_keys=True) + "\n" for value in values))


def read_lines(path: Path) -> list[Any]:
    """Return the values of a file of JSON lines."""
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]


def write_trials(path: Path, settings: Row, trials: Iterable[tuple[Row, Row, float]]) -> None:
    """Write the settings, then for each trial its name, its results and its duration in s."""
    lines: list[Row] = [{"settings": settings}]
    lines += [{"trial": name, "found": found, "seconds": round(took, 2)} for name, found, took in trials]
    write_text(path, "".join(json.dumps(line) + "\n" for line in lines))


def read_trials(path: Path) -> tuple[Row, list[Row]]:
    """Return the settings of a file of `write_trials`, and a row for each trial: name, results and `seconds`.

    Raises
    ------
    TrundleError
        As `read_headed`.
    """
    settings, lines = read_headed(path, ("trial", "found", "seconds"))
    return settings, [{**line["trial"], **line["found"], "seconds": line["seconds"]} for line in lines]


def read_headed(path: Path, keys: Iterable[str]) -> tuple[Row, list[Row]]:
    """Return the settings in the first line of a file of results, and its other lines.

    Raises
    ------
    TrundleError
        If the file does not exist, or the first line has no settings, or a key is missing from another line.
    """
    if not path.exists():
        raise TrundleError(f"{path}: no results to draw: run without --redraw")
    try:
        first, *lines = read_lines(path)
        for line in lines:
            for key in keys:
                line[key]
        return dict(first["settings"]), lines
    except (ValueError, KeyError, TypeError) as error:
        raise TrundleError(
            f"{path}: not results of an experiment ({error!r}): remove the file, or run without --redraw"
        ) from error


def rounded(value: Any) -> Any:
    """Return results as plain values with six significant digits; infinities and NaN become None."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return float(f"{value:.6g}") if math.isfinite(value) else None
    if isinstance(value, dict):
        return {name: rounded(inner) for name, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [rounded(inner) for inner in value]
    return value
