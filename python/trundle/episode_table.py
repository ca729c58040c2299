"""Tables of episodes: what the episodes of all recordings have in common."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from trundle._optional import require
from trundle.display import Displayed

if TYPE_CHECKING:
    import pandas as pd

    from trundle._native import JointRecording, Recording

__all__ = ["EpisodeTable", "Floats"]

Floats = NDArray[np.float64]


class EpisodeTable(Mapping[str, Floats], Displayed):
    """The table of one episode: a mapping of column names to read-only arrays.

    Attributes
    ----------
    recording : Recording or JointRecording
    name : str
    """

    recording: Recording | JointRecording

    def __init__(
        self, recording: Recording | JointRecording, name: str, columns: Mapping[str, Floats]
    ) -> None:
        self.recording = recording
        self.name = name
        self._columns = dict(columns)

    def __getitem__(self, column: str) -> Floats:
        """Return a column with NaN in empty cells, shape (n,)."""
        return self._columns[column]

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names of the columns, ``t`` first."""
        return iter(self._columns)

    def __len__(self) -> int:
        """Return the number of columns."""
        return len(self._columns)

    def __eq__(self, other: object) -> bool:
        """Whether both are the same episode of equal recordings."""
        if not isinstance(other, EpisodeTable):
            return NotImplemented
        return self.name == other.name and bool(self.recording == other.recording)

    __hash__ = None  # type: ignore[assignment]

    @property
    def held_out(self) -> bool:
        """Whether the episode is held out: predicted, never fitted."""
        return self.name in self.recording.metadata.get("split", {}).get("held_out", [])

    @property
    def duration(self) -> float:
        """Time from the first to the last row, s."""
        return float(self["t"][-1] - self["t"][0])

    def frame(self) -> pd.DataFrame:
        """Return all columns as a pandas data frame: a copy, ``t`` first, NaN for an empty cell.

        Raises
        ------
        TrundleError
            If pandas is not installed.

        Examples
        --------
        >>> list(recording["episode_00"].frame().columns[:2])
        ['t', 'object_x']
        """
        pandas = require("pandas", "pandas", "data frames")
        table: pd.DataFrame = pandas.DataFrame(dict(self))
        return table
