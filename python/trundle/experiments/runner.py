"""Run an experiment's units of work: each once, in parallel, resumable after a kill at any time.

A unit is one call of a module-level function with JSON arguments. Its key is the SHA-256 of the code version,
the function's name and the arguments, which hold all configuration and the seed. A finished unit is one file
``KEY.json`` in the store, written atomically, so an interrupted run continues with the units that have no
file. Results are returned in the order of the units, whatever order they finished in.
"""

from __future__ import annotations

import ast
import hashlib
import json
import os
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TextIO

from trundle.cli.progress import duration
from trundle.paper.results import rounded
from trundle.proof.pool import in_parallel
from trundle.whole import kept_json, write_text

__all__ = ["Runner", "Unit", "code_version", "collect", "write_lines"]


@dataclass(frozen=True)
class Unit:
    """One piece of work.

    Attributes
    ----------
    name : str
        Short and unique within the run, "case_0007".
    work : callable
        A module-level function: called with `arguments`, it returns plain JSON values that depend on these
        alone. Values under the key "cost" (wall time, memory) are exempt from that.
    arguments : dict
        Keyword arguments, plain JSON values: all configuration and the seed.
    folders : dict of str to Path
        Further keyword arguments that say where files are; they are not part of the key.
    made : Path, optional
        What the work leaves besides its result: the unit is done again where it is missing and the result has
        a "digest" of it.
    """

    name: str
    work: Callable[..., Any]
    arguments: dict[str, Any] = field(default_factory=dict)
    folders: dict[str, Path] = field(default_factory=dict)
    made: Path | None = None

    def key(self, version: str) -> str:
        """Return the address of the result."""
        named = f"{self.work.__module__}.{self.work.__qualname__}"
        content = json.dumps([version, named, self.name, self.arguments], sort_keys=True)
        return hashlib.sha256(content.encode()).hexdigest()[:32]


@dataclass(frozen=True)
class Runner:
    """Where and how units are run.

    Attributes
    ----------
    store : Path
        Folder of finished units.
    version : str
        Of the code that the results depend on, see `code_version`.
    jobs : int
        Processes.
    quiet : bool
        Show no progress.
    stream : text stream, optional
        Where progress goes; standard error by default.
    """

    store: Path
    version: str
    jobs: int = 1
    quiet: bool = False
    stream: TextIO | None = None

    def file_of(self, unit: Unit) -> Path:
        """Return the file of a unit's result."""
        return self.store / f"{unit.key(self.version)}.json"

    def done(self, unit: Unit) -> bool:
        """Tell whether a unit has a result, and what it made."""
        path = self.file_of(unit)
        if not path.exists():
            return False
        lost = unit.made is not None and not unit.made.exists()
        return not (lost and kept_json(path)["result"].get("digest"))

    def run(self, label: str, units: Sequence[Unit]) -> list[Any]:
        """Run the units that have no result, and return the results of all, in order."""
        missing = [unit for unit in units if not self.done(unit)]
        report = Countdown(label, len(units), len(units) - len(missing), self.stream, self.quiet)
        calls = [
            (unit.work, unit.arguments, unit.folders, str(self.file_of(unit)), unit.name) for unit in missing
        ]
        for number, _ in in_parallel(perform, calls, self.jobs):
            report.step(missing[number].name)
        return [kept_json(self.file_of(unit))["result"] for unit in units]


def perform(
    work: Callable[..., Any], arguments: dict[str, Any], folders: dict[str, Path], path: str, name: str
) -> None:
    """Do one unit and keep its result."""
    result = rounded(work(**arguments, **folders))
    write_text(Path(path), json.dumps({"unit": name, "result": result}, sort_keys=True) + "\n")


class Countdown:
    """Progress lines with the time left: one per unit, at most one a second, and the last one."""

    def __init__(self, label: str, total: int, done: int, stream: TextIO | None, quiet: bool) -> None:
        self.label, self.total, self.done, self.quiet = label, total, done, quiet
        self.stream = stream or sys.stderr
        self.first, self.began, self.shown = done, time.monotonic(), 0.0

    def step(self, name: str) -> None:
        """Report that a unit is finished."""
        self.done += 1
        now = time.monotonic()
        if self.quiet or (now - self.shown < 1.0 and self.done < self.total):
            return
        self.shown = now
        left = (now - self.began) / (self.done - self.first) * (self.total - self.done)
        text = f"{self.label}: {self.done} of {self.total} ({name}), about {duration(left)} left"
        print(text, file=self.stream, flush=True)


def code_version(*sources: Path) -> str:
    """Return the SHA-256 of files, and of all Python files and native modules below folders.

    Comments, docstrings and the layout of Python files do not count.
    """
    digest = hashlib.sha256()
    for source in sources:
        for path in sorted(files_below(source)):
            digest.update(f"{path.relative_to(source.parent).as_posix()}\0".encode())
            digest.update(hashlib.sha256(essence(path)).digest())
    return digest.hexdigest()


def essence(path: Path) -> bytes:
    """Return what of a file can change results."""
    if path.suffix != ".py":
        return path.read_bytes()
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            node.body = [one for one in body if not is_text(one)]  # type: ignore[attr-defined]
    return ast.dump(tree).encode()


def is_text(node: ast.AST) -> bool:
    """Tell whether a statement is only a string."""
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def files_below(source: Path) -> Iterable[Path]:
    """Yield the code files of a folder, or the file itself."""
    if source.is_file():
        yield source
        return
    for folder, _, names in os.walk(source):
        yield from (Path(folder) / name for name in names if name.endswith((".py", ".so", ".pyd")))


def collect(path: Path) -> list[Any]:
    """Return the values of a JSON-lines file."""
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]


def write_lines(path: Path, values: Iterable[Any]) -> None:
    """Write values as JSON lines, atomically; the same values give the same bytes."""
    write_text(path, "".join(json.dumps(value, sort_keys=True) + "\n" for value in values))
