"""Episodes of joints from files: one or several files each, or the values of a column."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from trundle.importers.config import MapError
from trundle.importers.joints.columns import Kind
from trundle.importers.joints.joint_map import JointMap, assemble_joints
from trundle.importers.joints.streams import joint_take, sample_stream
from trundle.importers.joints.table import ColumnMap, Matrices, check_order, read_columns, read_times
from trundle.importers.layout import Floats, Imported, ShowProgress, SourceError
from trundle.importers.streams import Stream
from trundle.importers.tables import list_files
from trundle.importers.takes import Take

__all__ = ["FileMap", "JointTableMap", "match_files", "read_joint_files"]


@dataclass(frozen=True)
class FileMap(ColumnMap):
    """Settings of a map for one of several files of an episode.

    Attributes
    ----------
    path : str
        Path below the source; a `*` in it matches the name of the episode.
    """

    path: str = ""

    def __post_init__(self) -> None:
        if not self.path or self.path.count("*") > 1 or Path(self.path).is_absolute():
            raise MapError(f"`path` = {self.path!r}: give a path below the source, with at most one `*`")
        if not self.columns and not self.lists:
            raise MapError(f"{self.path!r}: `columns` and `lists` are empty; map at least one column")


@dataclass(frozen=True)
class JointTableMap(ColumnMap, JointMap):
    """Settings of a map file for joints in files of named columns.

    Attributes
    ----------
    file : sequence of FileMap
        The files of an episode, if there are several; `time` and `order` are then their defaults.
    episode_column : str
        Column whose values divide the rows of a file into episodes.
    """

    file: tuple[FileMap, ...] = ()
    episode_column: str | None = None

    def __post_init__(self) -> None:
        JointMap.__post_init__(self)
        if bool(self.file) == bool(self.columns or self.lists):
            raise MapError(
                "give either `columns` and `lists` (one file for each episode) or `[[file]]` (several files)"
            )


Column = tuple[Kind, str, Floats, Floats]
"""Kind, joint, times and values of a column."""


def read_joint_files(
    source: Path,
    suffix: str,
    joint_map: JointTableMap,
    open_file: Callable[[Path, ColumnMap], Matrices],
    say: ShowProgress,
) -> Imported:
    """Read all episodes of a source.

    Parameters
    ----------
    source : Path
        A file, a folder of files with the suffix `suffix`, or the folder of the files in `joint_map.file`.
    suffix : str
        ".csv" or ".mat".
    joint_map : JointTableMap
        The map.
    open_file : callable
        Opens a file with the settings of its columns.
    say : callable
        Shows progress.
    """
    found = (
        match_files(source, joint_map.file) if joint_map.file else _single_files(source, suffix, joint_map)
    )
    takes: list[Take] = []
    for name, files in found.items():
        episodes: dict[str | None, list[Column]] = {}
        for path, column_map in files:
            say(path.name)
            file = open_file(path, column_map)
            for value, columns in _divide(file, column_map, joint_map):
                episodes.setdefault(value, []).extend(columns)
        for value, columns in episodes.items():
            episode = "_".join(each for each in (name, value) if each is not None) or None
            takes.append(_take(files[0][0], joint_map, columns, episode))
    return assemble_joints(takes, joint_map, source.stem)


def _single_files(
    source: Path, suffix: str, joint_map: JointTableMap
) -> dict[str | None, list[tuple[Path, ColumnMap]]]:
    """Return the file of each episode by the name of the file."""
    files = list_files(source, suffix)
    return {path.stem if source.is_dir() else None: [(path, joint_map)] for path in files}


def match_files(source: Path, files: Sequence[FileMap]) -> dict[str | None, list[tuple[Path, ColumnMap]]]:
    """Return the files of each episode, by the text that the `*` of their paths matches.

    Raises
    ------
    SourceError
        If a file of an episode is missing.
    """
    if not source.is_dir():
        raise SourceError(source, "is a file; give the folder that contains the files of `[[file]]`")
    matches: list[dict[str | None, Path]] = []
    for each in files:
        before, star, after = each.path.partition("*")
        match: dict[str | None, Path] = {}
        for path in sorted(source.glob(each.path)):
            inside = path.relative_to(source).as_posix()
            match[inside[len(before) : len(inside) - len(after)] if star else None] = path
        if not match:
            raise SourceError(source, f"no file {each.path!r}; correct `path` in the map")
        matches.append(match)
    names = sorted({name for match in matches for name in match}, key=str)
    for match, each in zip(matches, files, strict=True):
        for name in names:
            if name not in match:
                path = source / each.path.replace("*", str(name))
                raise SourceError(
                    path, f"no such file, which episode {name!r} needs; add it, or remove its others"
                )
    return {name: [(match[name], each) for match, each in zip(matches, files, strict=True)] for name in names}


def _divide(
    file: Matrices, column_map: ColumnMap, joint_map: JointTableMap
) -> Iterator[tuple[str | None, list[Column]]]:
    """Yield the columns of each episode in a file, by its value of `episode_column`."""
    time = column_map.time if column_map.time is not None else joint_map.time
    default = joint_map.order if column_map.order is None else column_map.order
    columns = list(read_columns(file, replace(column_map, order=default), joint_map))
    t = read_times(file, time)
    for kind, joint, values in columns:
        if len(values) != len(t):
            raise SourceError(
                file.path,
                f"{kind}_{joint} has {len(values)} samples and its time {len(t)}; give each clock "
                "a `[[file]]`",
            )
    for value, rows in _episode_rows(file, joint_map.episode_column, len(t)):
        check_order(file, t, rows)
        yield value, [(kind, joint, t[rows], values[rows]) for kind, joint, values in columns]


def _episode_rows(file: Matrices, column: str | None, length: int) -> Iterator[tuple[str | None, np.ndarray]]:
    """Yield each value of a column with its rows; all rows without a column."""
    if column is None:
        yield None, np.arange(length)
        return
    rows: dict[str, list[int]] = {}
    for row, value in enumerate(file.cells(column)):
        rows.setdefault(value, []).append(row)
    if sum(map(len, rows.values())) != length:
        raise SourceError(file.path, f"`{column}` and the times differ in length; map columns of one length")
    for value, found in rows.items():
        yield value, np.array(found)


def _take(path: Path, joint_map: JointMap, columns: Sequence[Column], name: str | None) -> Take:
    streams: dict[str, Stream] = {}
    repeated: dict[str, int] = {}
    for kind, joint, t, values in columns:
        if f"{kind}_{joint}" in streams:
            raise MapError(f"{kind}_{joint} is mapped twice; remove one of the two")
        stream, count = sample_stream(kind, joint, t, values, joint_map.holds(kind, joint))
        streams[f"{kind}_{joint}"], repeated[f"{kind}_{joint}"] = stream, count
    return joint_take(path, joint_map.names, streams, repeated, name)
