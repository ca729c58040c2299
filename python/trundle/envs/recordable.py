"""Recordings of the episodes of an environment."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trundle._native import Pushing

__all__ = ["RecordableEpisodes"]

Array = NDArray[np.float64]


class RecordableEpisodes:
    """Part of `trundle.envs.Push`: readings of sensor and tracker, for `trundle.Record`."""

    _native: Pushing

    def start_recording(self) -> None:
        """Store the readings of sensor and tracker from the next reset on; for `trundle.Record`."""
        self._native.record()

    def take_rows(self) -> dict[str, Array]:
        """Return the readings since the last call, by column of a recording."""
        return self._native.take_rows()

    def recording_metadata(self, name: str) -> dict[str, Any]:
        """Return the content of `recording.toml`."""
        return self._native.metadata(name)

    @property
    def object_count(self) -> int:
        """Number of different objects so far; it increases when the hidden object changes."""
        return self._native.objects
