"""Run an experiment's units of work: each once, on any backend, resumable after a kill at any time.

A unit is one call of a module-level function with JSON arguments. Its key is the SHA-256 of the code version,
the function's name and the arguments, which hold all configuration and the seed. A finished unit is one file
``KEY.json`` in the store, written atomically, so an interrupted run continues with the units that have no
file. Results are returned in the order of the units, whatever order they finished in.
"""

from __future__ import annotations

import hashlib
import json
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TextIO

from trundle._native import TrundleError
from trundle.atomic import read_json, write_text
from trundle.experiments.backends import Backend, Local
from trundle.experiments.results import rounded
from trundle.progress import Progress, format_duration

__all__ = ["Runner", "Unit"]

LOG_INTERVAL_SECONDS = 10.0
"""Between two lines of progress where standard error is not a terminal."""


@dataclass(frozen=True)
class Unit:
    """One piece of work.

    Attributes
    ----------
    name : str
        For messages, for example "case_0007".
    work : callable
        A module-level function of `arguments` that returns plain JSON values. They depend on the arguments
        alone, except for values under the key "cost" (wall time, memory).
    arguments : dict
        Keyword arguments, plain JSON values: all configuration and the seed.
    folders : dict of str to Path
        Further keyword arguments with the places of files. They are not part of the key.
    made : Path, optional
        A file or folder that the work writes. If it is missing and the result has a "digest" of it, the unit
        runs again.
    """

    name: str
    work: Callable[..., Any]
    arguments: dict[str, Any] = field(default_factory=dict)
    folders: dict[str, Path] = field(default_factory=dict)
    made: Path | None = None

    def key(self, version: str) -> str:
        """Return the key of the result."""
        function = f"{self.work.__module__}.{self.work.__qualname__}"
        content = json.dumps([version, function, self.arguments], sort_keys=True)
        return hashlib.sha256(content.encode()).hexdigest()[:32]


@dataclass(frozen=True)
class Failure:
    """Why a unit has no result."""

    reason: str


@dataclass(frozen=True)
class Runner:
    """Where and how units are run.

    Attributes
    ----------
    store : Path
        Folder of finished units.
    version : str
        Of the code that the results depend on, see `trundle.experiments.versions`.
    backend : Backend
        By default one process.
    quiet : bool
        Show no progress.
    stream : text stream, optional
        Where progress goes; standard error by default.
    """

    store: Path
    version: str
    backend: Backend = field(default_factory=Local)
    quiet: bool = False
    stream: TextIO | None = None

    def file_of(self, unit: Unit) -> Path:
        """Return the file of a unit's result."""
        return self.store / f"{unit.key(self.version)}.json"

    def is_done(self, unit: Unit) -> bool:
        """Return whether a unit has a result, and the files that it wrote."""
        path = self.file_of(unit)
        if not path.exists():
            return False
        lost = unit.made is not None and not unit.made.exists()
        return not (lost and read_json(path)["result"].get("digest"))

    def run(self, label: str, units: Sequence[Unit]) -> list[Any]:
        """Run the units that have no result, and return the results of all, in order.

        Raises
        ------
        TrundleError
            If units raised one; the results of the others are kept.
        """
        missing = [unit for unit in units if not self.is_done(unit)]
        calls = [(unit.work, unit.arguments, unit.folders, unit.name) for unit in missing]
        failures = []
        with Report(label, len(units), len(missing), self.stream, self.quiet) as report:
            for number, outcome in self.backend.map(perform, calls):
                unit = missing[number]
                if isinstance(outcome, Failure):
                    failures.append(f"{unit.name}: {outcome.reason}")
                    report.tell(failures[-1])
                else:
                    write_text(self.file_of(unit), outcome)
                report.step(unit.name)
        if failures:
            raise TrundleError(f"{label}: {len(failures)} of {len(units)} failed; first {failures[0]}")
        return [read_json(self.file_of(unit))["result"] for unit in units]


def perform(
    work: Callable[..., Any], arguments: dict[str, Any], folders: dict[str, Path], name: str
) -> str | Failure:
    """Do one unit and return the content of its file."""
    try:
        result = work(**arguments, **folders)
    except TrundleError as error:
        return Failure(str(error))
    return json.dumps({"unit": name, "result": rounded(result)}) + "\n"


class Report:
    """Progress with the remaining time: a line that is updated on a terminal, otherwise occasional lines."""

    def __init__(self, label: str, total: int, missing: int, stream: TextIO | None, quiet: bool) -> None:
        self.label, self.total, self.missing, self.quiet = label, total, missing, quiet
        self.stream = stream or sys.stderr
        self.line = Progress(label, missing, quiet=quiet, stream=self.stream)
        self.done, self.began, self.shown = 0, time.monotonic(), time.monotonic()

    def __enter__(self) -> Report:
        self.line.__enter__()
        return self

    def __exit__(self, *error: Any) -> None:
        self.line.__exit__(*error)

    def tell(self, text: str) -> None:
        """Print a permanent line."""
        print(text, file=self.stream, flush=True)

    def step(self, name: str) -> None:
        """Report that a unit is finished."""
        self.done += 1
        self.line.step(name)
        now = time.monotonic()
        due = now - self.shown >= LOG_INTERVAL_SECONDS or self.done == self.missing
        if self.quiet or self.stream.isatty() or not due:
            return
        self.shown = now
        left = format_duration((now - self.began) / self.done * (self.missing - self.done))
        done = self.total - self.missing + self.done
        self.tell(f"{self.label}: {done} of {self.total} ({name}), about {left} left")
