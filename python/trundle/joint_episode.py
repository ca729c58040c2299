"""Episodes of recordings of joints."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from trundle._native import TrundleError
from trundle.display import Card
from trundle.display.formatting import format_number
from trundle.episode_table import EpisodeTable, Floats

if TYPE_CHECKING:
    from trundle._native import JointRecording

__all__ = ["STREAMS", "JointEpisode"]

STREAMS = ("q", "v", "effort", "target", "known", "on", "load")
"""Prefixes of the columns."""


class JointEpisode(EpisodeTable):
    """One episode of a recording of joints: a mapping of column names to read-only arrays, as in its table.

    Columns are ``t`` and ``STREAM_JOINT``, such as ``q_elbow``, with NaN where a stream has no sample.

    Attributes
    ----------
    recording : JointRecording
    name : str

    Examples
    --------
    >>> import numpy as np
    >>> mechanism = {"axis": "hinge", "joints": ["arm"]}
    >>> metadata = {"format": "trundle-recording/2", "name": "bench", "mechanism": mechanism}
    >>> columns = {"t": [0.0, 0.1, 0.2], "q_arm": [0.0, np.nan, 0.2], "effort_arm": [1.0, 1.0, 1.0]}
    >>> episode = trundle.JointRecording(metadata, {"swing": columns})["swing"]
    >>> episode.stream("q", "arm")
    (array([0. , 0.2]), array([0. , 0.2]))
    >>> episode.streams
    {'arm': ('q', 'effort')}
    """

    recording: JointRecording

    @property
    def streams(self) -> dict[str, tuple[str, ...]]:
        """Prefixes of the recorded streams of each joint."""
        return {
            joint: tuple(prefix for prefix in STREAMS if f"{prefix}_{joint}" in self)
            for joint in self.recording.joints
        }

    def stream(self, prefix: str, joint: str) -> tuple[Floats, Floats]:
        """Return times and values of a stream without empty cells.

        Parameters
        ----------
        prefix : {"q", "v", "effort", "target", "known", "on", "load"}
        joint : str

        Returns
        -------
        t, values : arrays of shape (n,)
            Times, s, and values in the unit of the column.

        Raises
        ------
        TrundleError
            If the episode has no such column.
        """
        column = f"{prefix}_{joint}"
        if prefix not in STREAMS or column not in self:
            known = ", ".join(name for name in self if name != "t" and not name.startswith("note_"))
            raise TrundleError(f"episode {self.name}: there is no column {column}; the columns are: {known}")
        samples = ~np.isnan(self[column])
        return self["t"][samples], self[column][samples]

    def _card(self) -> Card:
        split = "held out" if self.held_out else "training"
        rows = [(joint, ", ".join(self._rates(joint))) for joint in self.recording.joints]
        title = (
            f"trundle.JointEpisode {self.name!r} of {self.recording.name!r}: {self.duration:.2f} s, {split}"
        )
        return Card(title, rows)

    def _rates(self, joint: str) -> list[str]:
        """Return each stream of a joint with its rate."""
        found = []
        for prefix in self.streams[joint]:
            t, _ = self.stream(prefix, joint)
            rate = f" {format_number(float(1.0 / np.median(np.diff(t))))} Hz" if len(t) > 1 else ""
            found.append(f"{prefix}{rate}")
        return found
