"""Results of an experiment as JSON lines: the settings first, then a line for each trial."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from trundle.recording import TrundleError
from trundle.whole import write_text

__all__ = ["Results", "Row"]

Row = dict[str, Any]


class Results:
    """Results that outlive an interruption.

    The file is written beside its place and renamed after every trial: it is whole at any time. Results of
    other settings are discarded, because trials of two settings must not stand in one table.

    Parameters
    ----------
    path : Path
        The file; made with the first trial.
    settings : dict
        Everything that the results depend on.
    fresh : bool
        Forget what is there.
    """

    def __init__(self, path: Path, settings: dict[str, Any], *, fresh: bool = False) -> None:
        self.path = path
        self.settings: dict[str, Any] = json.loads(json.dumps(settings))
        self._rows: dict[str, Row] = {}
        if not fresh and path.exists():
            found, rows = load(path)
            if comparable(found) == comparable(self.settings):
                self._rows = {key(row["trial"]): row for row in rows}

    @classmethod
    def whatever(cls, path: Path) -> Results:
        """Return the results that are there, with their own settings."""
        return cls(path, load(path)[0])

    def of(self, trial: Row) -> Row | None:
        """Return a trial's name, results and `seconds` in one, or None if it has not been done."""
        row = self._rows.get(key(trial))
        return None if row is None else {**row["trial"], **row["found"], "seconds": row["seconds"]}

    def add(self, trial: Row, found: Row, seconds: float) -> None:
        """Keep what a trial found, and how long it took."""
        row = {"trial": trial, "found": rounded(found), "seconds": round(seconds, 2)}
        self._rows[key(trial)] = json.loads(json.dumps(row))
        self.write()

    def write(self) -> None:
        """Write all of it; whole or not at all."""
        lines = [{"settings": self.settings}, *self._rows.values()]
        write_text(self.path, "".join(json.dumps(line) + "\n" for line in lines))


def comparable(settings: dict[str, Any]) -> dict[str, Any]:
    """Return what trials depend on: not how many seeds there are."""
    return {name: value for name, value in settings.items() if name != "seeds"}


def load(path: Path) -> tuple[dict[str, Any], list[Row]]:
    """Return the settings and the trials of a file."""
    try:
        first, *rest = map(json.loads, path.read_text(encoding="utf-8").splitlines())
        return first["settings"], rest
    except (ValueError, KeyError, TypeError) as error:
        raise TrundleError(
            f"{path}: these are no results of an experiment ({error}); remove the file, or give --fresh"
        ) from error


def key(trial: Row) -> str:
    """Return a trial's name as a key."""
    return json.dumps(trial, sort_keys=True)


def rounded(value: Any) -> Any:
    """Return results with six significant digits, infinities and NaN as None: files that can be compared."""
    if isinstance(value, float):
        return float(f"{value:.6g}") if math.isfinite(value) else None
    if isinstance(value, dict):
        return {name: rounded(inner) for name, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [rounded(inner) for inner in value]
    return value
