"""What an importer hands over, and what it is asked with."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

__all__ = ["Columns", "Floats", "Imported", "Importer", "ShowProgress", "SourceError"]

Floats = NDArray[np.float64]
Columns = dict[str, Floats]
"""Columns of one episode's table, all of one length, NaN where a stream has no sample."""
ShowProgress = Callable[[str], None]
"""Shows what is being read; may be called as often as convenient."""


class SourceError(ValueError):
    """A source that cannot be imported; the message names the file, the place in it and the remedy."""

    def __init__(self, source: Path | str, trouble: str) -> None:
        super().__init__(f"{source}: {trouble}")


@dataclass
class Imported:
    """A recording before it is validated.

    Attributes
    ----------
    metadata : dict
        `recording.toml` as a dictionary.
    episodes : dict of str to Columns
        Tables by episode name, SI units, times strictly increasing.
    remarks : list of str
        What was left out or decided, with counts: nothing is repaired silently.
    """

    metadata: dict[str, Any]
    episodes: dict[str, Columns]
    remarks: list[str] = field(default_factory=list)


class Importer(Protocol):
    """A module of this package that reads one layout."""

    NEEDS_MAP: bool
    """Whether the layout says nothing without a map."""

    def read(self, source: Path, settings: Mapping[str, Any], say: ShowProgress) -> Imported:
        """Read `source` as `settings`, the parsed map file, tell."""
