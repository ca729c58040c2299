"""Episodes: one uninterrupted manipulation of the object in a recording."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from trundle import _native
from trundle._optional import require
from trundle.display import Card
from trundle.episode_table import EpisodeTable, Floats
from trundle.stream import Stream, unit_of

if TYPE_CHECKING:
    import xarray as xr

    from trundle._native import Recording

__all__ = ["Episode"]

PREFIXES = {"object": ("object_",), "gripper": ("gripper_",), "wrench": ("force_", "torque_")}
"""Beginnings of the names of the columns of each stream."""


class Episode(EpisodeTable):
    """One episode of a recording: a mapping of column names to read-only arrays, as in its table.

    All columns have one row per time stamp of any instrument, and NaN where a stream has no sample.
    ``object``, ``gripper`` and ``wrench`` are the streams without empty cells, each at its own times.
    ``recording["episode_00"]`` is an episode.

    Attributes
    ----------
    recording : Recording
    name : str

    Examples
    --------
    >>> episode = recording["episode_00"]
    >>> episode.name, episode.held_out
    ('episode_00', False)
    >>> list(episode.streams)
    ['object', 'gripper', 'wrench']
    >>> episode.object["object_x"].shape == episode.object.t.shape
    True
    """

    recording: Recording

    @property
    def streams(self) -> dict[str, Stream]:
        """The recorded streams by name, each at its own times."""
        return {name: self._stream(name) for name in PREFIXES if self._names(name)}

    @property
    def object(self) -> Stream:
        """Poses of the object frame in the world."""
        return self._stream("object")

    @property
    def gripper(self) -> Stream:
        """Poses of the gripper (the force-torque sensor frame) in the world; no columns if not recorded."""
        return self._stream("gripper")

    @property
    def wrench(self) -> Stream:
        """Readings of the force-torque sensor as recorded; see `tared`."""
        return self._stream("wrench")

    def tared(
        self,
        tare: Literal["separated", "equation_12"] = "separated",
        wrench_pose: Literal["own_time", "latest"] = "own_time",
    ) -> dict[str, Stream]:
        """Return the streams as the estimator sees them: tared, masked and transformed.

        The tare may need several episodes, so each call prepares the whole recording. `trundle.prepare`
        returns all episodes at once.

        Parameters
        ----------
        tare, wrench_pose : str
            As for `trundle.prepare`.

        Returns
        -------
        dict of str to Stream
            ``object``: poses without outliers, world frame. ``wrench``: wrench on the object, object axes,
            torque about the origin of the object frame. ``reading``: the tared reading in its own axes.

        Raises
        ------
        TrundleError
            If a raw reading cannot be tared, or a stream is missing.

        Examples
        --------
        >>> tared = episode.tared()
        >>> list(tared["wrench"])
        ['force_x', 'force_y', 'torque_z']
        >>> quiet = tared["wrench"].t < 0.2  # before contact
        >>> bool(abs(tared["wrench"]["force_x"][quiet].mean()) < 1.0)
        True
        """
        prepared = _native.prepare(self.recording, tare, wrench_pose)[self.name]
        poses = ("object_x", "object_y", "object_theta")
        wrenches = ("force_x", "force_y", "torque_z")

        def stream(name: str, t: Floats, names: tuple[str, ...], rows: Floats, description: str) -> Stream:
            return Stream(name, t, dict(zip(names, rows.T, strict=True)), description)

        t = prepared["wrench_t"]
        return {
            "object": stream("object", prepared["pose_t"], poses, prepared["pose"], "world frame, masked"),
            "wrench": stream(
                "wrench", t, wrenches, prepared["on_object"], "on the object, object frame, tared"
            ),
            "reading": stream(
                "reading", t, wrenches, prepared["reading"], "on the object, reading axes, tared"
            ),
        }

    def to_xarray(self) -> xr.Dataset:
        """Return all streams as an xarray dataset.

        Returns
        -------
        xarray.Dataset
            One variable per column, with its unit in ``attrs["units"]``. The samples of a stream have the
            dimension ``time_object``, ``time_gripper`` or ``time_wrench``, whose coordinate is in s.

        Raises
        ------
        TrundleError
            If xarray is not installed.

        Examples
        --------
        >>> data = episode.to_xarray()
        >>> data.object_theta.dims, data.object_theta.attrs["units"]
        (('time_object',), 'rad')
        """
        xarray = require("xarray", "arviz", "xarray datasets")
        streams = [stream.to_xarray(f"time_{name}") for name, stream in self.streams.items()]
        variables = {name: column for stream in streams for name, column in stream.data_vars.items()}
        attributes = {"recording": self.recording.name, "episode": self.name, "held_out": int(self.held_out)}
        data: xr.Dataset = xarray.Dataset(variables, attrs=attributes)
        return data

    def _names(self, stream: str) -> list[str]:
        return [name for name in self._columns if name.startswith(PREFIXES[stream])]

    def _stream(self, name: str) -> Stream:
        """Return the rows in which a stream has a sample; a sample has all columns of its stream."""
        names = self._names(name)
        rows = ~np.isnan(self[names[0]]) if names else np.zeros(len(self["t"]), dtype=bool)
        columns = {column: self[column][rows] for column in names}
        frame = "world frame" if name != "wrench" else f"{self.recording.metadata['wrench']['frame']} axes"
        return Stream(name, self["t"][rows], columns, f"{frame}, as recorded")

    def _card(self) -> Card:
        split = "held out" if self.held_out else "training"
        rows = [
            (name, f"{len(s.t)} samples at {s.rate:.4g} Hz: {', '.join(map(_with_unit, s))}")
            for name, s in self.streams.items()
        ]
        notes = [name for name in self if name.startswith("note_")]
        if notes:
            rows.append(("notes", ", ".join(notes)))
        title = f"trundle.Episode {self.name!r} of {self.recording.name!r}: {self.duration:.2f} s, {split}"
        return Card(title, rows)


def _with_unit(column: str) -> str:
    unit = unit_of(column)
    return f"{column} [{unit}]" if unit else column
