"""What a module of this package provides, and what the command line says to it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from trundle.experiments.results import Row

__all__ = ["Experiment", "Options", "Section"]


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

    def perform(self, settings: dict[str, Any], trial: Row) -> Row:
        """Do one trial and return its results, plain values."""

    def section(self, settings: dict[str, Any], rows: Sequence[Row]) -> Section:
        """Return the section that these results (trial and results in one) make."""
