"""Interface of importers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from trundle._native import Recording, TrundleError

if TYPE_CHECKING:
    from trundle._native import JointRecording

__all__ = ["Columns", "Floats", "Imported", "Importer", "ShowProgress", "SourceError"]

Floats = NDArray[np.float64]
Columns = dict[str, Floats]
"""Columns of an episode table, of equal length, NaN where a stream has no sample."""
ShowProgress = Callable[[str], None]
"""Callback that shows what is being read; it may be called at any rate."""


class SourceError(ValueError):
    """A source that cannot be imported; the message names the file, the position in it and the remedy.

    Examples
    --------
    >>> from trundle import importers
    >>> importers.importer("xlsx")
    Traceback (most recent call last):
        ...
    trundle.importers.layout.SourceError: xlsx: unknown layout; choose one of ...
    """

    def __init__(self, source: Path | str, message: str) -> None:
        super().__init__(f"{source}: {message}")


@dataclass
class Imported:
    """A recording before validation, of a pushed object or of joints.

    Attributes
    ----------
    metadata : dict
        `recording.toml` as a dictionary; its `format` is that of an object or of joints.
    episodes : dict of str to Columns
        Tables by episode name, in SI units, with strictly increasing times.
    remarks : list of str
        Omitted samples and other changes, with counts. No data is changed without a remark.
    files : dict of str to str
        Text of the models of joints by file name.

    Examples
    --------
    >>> import trundle
    >>> found = trundle.importers.read(Path("logs"), "csv", Path("map.toml"))  # doctest: +SKIP
    >>> trundle.Recording(found.metadata, found.episodes).write("recordings/run_3")  # doctest: +SKIP
    >>> len(found.remarks)  # doctest: +SKIP
    """

    metadata: dict[str, Any]
    episodes: dict[str, Columns]
    remarks: list[str] = field(default_factory=list)
    files: dict[str, str] = field(default_factory=dict)

    def recording(self) -> Recording | JointRecording:
        """Return the validated recording.

        Raises
        ------
        TrundleError
            If a table is not valid, or required metadata are missing; the message lists all missing keys.
        """
        from trundle.importers.guess.metadata import missing_metadata

        if self.metadata.get("format") == "trundle-recording/2":
            from trundle._native import JointRecording

            return JointRecording(self.metadata, self.episodes, files=self.files)
        columns = {column for table in self.episodes.values() for column in table}
        missing = missing_metadata(self.metadata, columns)
        if missing:
            lines = "".join(f"\n  {question.key}: {question.text}{question.hint}" for question in missing)
            raise TrundleError(f"missing in the map:{lines}")
        return Recording(self.metadata, self.episodes)


class Importer(Protocol):
    """A module of this package that reads one layout."""

    NEEDS_MAP: bool
    """Whether the layout requires a map."""

    def read(self, source: Path, settings: Mapping[str, Any], say: ShowProgress) -> Imported:
        """Read `source` with `settings`, the parsed map file."""
