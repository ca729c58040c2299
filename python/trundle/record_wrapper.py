"""A Gymnasium wrapper that writes the episodes of an environment as recordings."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any, Literal, Protocol, SupportsFloat, TypeVar, runtime_checkable

import gymnasium as gym
import numpy as np
from gymnasium.utils import RecordConstructorArgs
from numpy.typing import NDArray

from trundle.recording import Recording, TrundleError

__all__ = ["Record", "Recordable"]

ObsType = TypeVar("ObsType")
ActType = TypeVar("ActType")
Columns = dict[str, NDArray[np.float64]]


@runtime_checkable
class Recordable(Protocol):
    """Interface of an environment that can be recorded."""

    @property
    def object_count(self) -> int:
        """Number of different objects so far; it increases when the object changes."""

    def start_recording(self) -> None:
        """Store the readings of sensor and tracker from the next reset on."""

    def take_rows(self) -> Columns:
        """Return the readings since the last call, by column of a recording."""

    def recording_metadata(self, name: str) -> dict[str, Any]:
        """Return the content of `recording.toml`."""


class Record(gym.Wrapper[ObsType, ActType, ObsType, ActType], RecordConstructorArgs):
    """Write the sensor and tracker readings of each episode, at their own rates, as a recording.

    A recording is of one object. Therefore a reset without a seed keeps the hidden object (reset option
    ``same_object``), unless the caller gives that option or ``keep_object`` is False. If the object changes
    nevertheless, because of a seed, a new recording begins: ``folder_2``, ``folder_3`` and so on.

    The folder is written atomically, by `close` or when the object changes. An existing recording is
    replaced. Episodes without a step are omitted.

    Parameters
    ----------
    env : gymnasium.Env
        An environment of `trundle`, wrapped or not.
    folder : str or os.PathLike
        Folder of the recording.
    name : str, optional
        Name of the recording; by default that of the folder.
    table : {"csv", "parquet"}
        Format of the episode tables.
    held_out : int
        Number of episodes at the end of each recording that are marked as held out.
    keep_object : bool
        Whether a reset without a seed keeps the hidden object.

    Raises
    ------
    TrundleError
        If the environment is not one of `trundle`, or the folder cannot be written.

    Examples
    --------
    >>> import gymnasium, trundle
    >>> env = trundle.Record(gymnasium.make("trundle/LockedWheel-v0"), "pushes")
    >>> for episode in range(3):
    ...     obs, info = env.reset(seed=0 if episode == 0 else None)
    ...     for _ in range(60):
    ...         obs, reward, terminated, truncated, info = env.step(env.action_space.sample())
    ...         if terminated or truncated:
    ...             break
    >>> env.close()
    """

    def __init__(
        self,
        env: gym.Env[ObsType, ActType],
        folder: str | PathLike[str],
        *,
        name: str | None = None,
        table: Literal["csv", "parquet"] = "csv",
        held_out: int = 0,
        keep_object: bool = True,
    ) -> None:
        RecordConstructorArgs.__init__(
            self, folder=folder, name=name, table=table, held_out=held_out, keep_object=keep_object
        )
        gym.Wrapper.__init__(self, env)
        if not isinstance(env.unwrapped, Recordable):
            raise TrundleError(f"{env.unwrapped}: cannot be recorded; give an environment of trundle")
        if table not in ("csv", "parquet"):
            raise TrundleError(f"table = {table!r}: choose 'csv' or 'parquet'")
        self._source: Recordable = env.unwrapped
        self._source.start_recording()
        self._folder = Path(folder)
        self._name = self._folder.name if name is None else name
        self._table = table
        self._held_out = held_out
        self._keep_object = keep_object
        self._object = self._source.object_count
        self._described: dict[str, Any] = {}
        self._has_episode = False
        self._has_step = False
        self._rows: list[Columns] = []
        self._episodes: list[Columns] = []
        self.folders: list[Path] = []
        """Recordings written so far."""

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[ObsType, dict[str, Any]]:
        """Begin the next episode, by default with the same object."""
        self._finish_episode()
        if self._keep_object and self._has_episode and seed is None:
            options = {"same_object": True, **(options or {})}
        observation, info = self.env.reset(seed=seed, options=options)
        if self._source.object_count != self._object:
            self._write()
            self._object = self._source.object_count
        # Read now: the object may have changed when the recording is written.
        self._described = self._source.recording_metadata(self._name)
        self._has_episode = True
        self._rows = [self._source.take_rows()]
        return observation, info

    def step(self, action: ActType) -> tuple[ObsType, SupportsFloat, bool, bool, dict[str, Any]]:
        """Step the environment and store the readings."""
        result = self.env.step(action)
        self._rows.append(self._source.take_rows())
        self._has_step = True
        return result

    def close(self) -> None:
        """Write the recording and close the environment."""
        self._finish_episode()
        try:
            self._write()
        finally:
            super().close()

    def _finish_episode(self) -> None:
        if self._has_step:
            self._episodes.append(
                {key: np.concatenate([rows[key] for rows in self._rows]) for key in self._rows[0]}
            )
        self._rows, self._has_step = [], False

    def _write(self) -> None:
        if not self._episodes:
            return
        episodes = {f"episode_{k:02}": columns for k, columns in enumerate(self._episodes)}
        number = len(self.folders) + 1
        suffix = "" if number == 1 else f"_{number}"
        metadata = {**self._described, "name": f"{self._name}{suffix}"}
        if self._held_out > 0:
            metadata["split"] = {"held_out": list(episodes)[-self._held_out :]}
        folder = self._folder.with_name(f"{self._folder.name}{suffix}")
        Recording(metadata, episodes).write(folder, self._table)
        self.folders.append(folder)
        self._episodes = []
