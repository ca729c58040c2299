"""Interface of the paper's experiments, and the options of their command."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from trundle.experiments.results import Row

__all__ = ["Experiment", "Options", "Section"]


@dataclass(frozen=True)
class Options:
    """Options of the command line.

    Attributes
    ----------
    configs : Path
        Folder of `experiments/` and `objects/`.
    seeds : int, optional
        Number of seeds; by default that of the experiment's file.
    quick : bool
        Run a small version of the experiment.
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
    """One section of the document: its text, and its figures by file name."""

    text: str
    pictures: dict[str, Callable[[Path], None]]


class Experiment(Protocol):
    """Members of an experiment's module."""

    FILE: str
    """Name of its file in `configs/experiments`, without `.toml`."""

    TITLE: str
    """Heading of its section."""

    def settings(self, options: Options) -> dict[str, Any]:
        """Return everything that the results depend on, as plain values."""

    def trials(self, settings: dict[str, Any]) -> Sequence[Row]:
        """Return the names of all trials, in order."""

    def perform(self, settings: dict[str, Any], trial: Row) -> Row:
        """Run one trial and return its results, plain values."""

    def section(self, settings: dict[str, Any], rows: Sequence[Row]) -> Section:
        """Return the section of these results (trial and results in one row)."""
