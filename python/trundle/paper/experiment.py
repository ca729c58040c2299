"""What an experiment is, and how it is run: trial by trial, each kept as soon as it is done."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from trundle.paper.results import Results, Row

__all__ = ["Experiment", "Options", "Section", "carry_out"]

Show = Callable[[str], object]


@dataclass(frozen=True)
class Options:
    """What the command line says.

    Attributes
    ----------
    configs : Path
        The folder that holds `experiments/` and `objects/`.
    seeds : int, optional
        How many seeds; as many as the experiment's file says if left out.
    quick : bool
        A small version of the experiment, to see that it works.
    """

    configs: Path
    seeds: int | None = None
    quick: bool = False

    def file(self, name: str) -> Path:
        """Return the file of an experiment."""
        return self.configs / "experiments" / f"{name}.toml"

    @property
    def objects(self) -> Path:
        """The folder of the objects."""
        return self.configs / "objects"


@dataclass(frozen=True)
class Section:
    """One section of the document: its text, and its pictures by file name."""

    text: str
    pictures: dict[str, Callable[[Path], None]]


class Experiment(Protocol):
    """What a module of this package provides."""

    FILE: str
    """Name of its file in `configs/experiments`, without `.toml`."""

    TITLE: str
    """Heading of its section."""

    def settings(self, options: Options) -> dict[str, Any]:
        """Return everything that the results depend on, plain values; results of others are discarded."""

    def trials(self, settings: dict[str, Any]) -> Sequence[Row]:
        """Return what names each trial, in order."""

    def perform(self, settings: dict[str, Any], trial: Row, show: Show) -> Row:
        """Do one trial and return its results, plain values."""

    def section(self, settings: dict[str, Any], rows: Sequence[Row]) -> Section:
        """Return the section that these results (trial and results in one) make."""


def carry_out(
    experiment: Experiment, settings: dict[str, Any], results: Results, show: Show, *, perform: bool = True
) -> list[Row]:
    """Do the trials that are not among the results yet, unless `perform` is false; return all in order.

    Each trial is kept as soon as it is done, so that an interrupted experiment goes on where it was.
    """
    trials = experiment.trials(settings)
    missing = [trial for trial in trials if results.of(trial) is None] if perform else []
    for number, trial in enumerate(missing):
        what = f"trial {len(trials) - len(missing) + number + 1} of {len(trials)}: {words(trial)}"
        show(what)
        began = time.perf_counter()
        found = experiment.perform(settings, trial, partial(within, show, what))
        results.add(trial, found, time.perf_counter() - began)
    return [row for row in map(results.of, trials) if row is not None]


def within(show: Show, what: str, text: str) -> None:
    """Show what is being done within a trial."""
    show(f"{what}, {text}")


def words(values: Row) -> str:
    """Return what names a trial in words."""
    return ", ".join(f"{key} {value}" for key, value in values.items())


def seconds(rows: Iterable[Row]) -> float:
    """Return how long the trials took together, s."""
    return sum(float(row["seconds"]) for row in rows)
