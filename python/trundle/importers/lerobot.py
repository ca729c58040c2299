"""LeRobot data sets of version 3: Parquet files with the states and actions of all episodes.

The format is described in the documentation of LeRobot (Hugging Face), "LeRobotDataset v3.0".
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from trundle._optional import require
from trundle.importers.config import MapError, typed
from trundle.importers.joints.columns import Kind, known
from trundle.importers.joints.joint_map import JointMap, assemble_joints
from trundle.importers.joints.streams import joint_take, sample_stream
from trundle.importers.layout import Floats, Imported, ShowProgress, SourceError
from trundle.importers.streams import Stream
from trundle.importers.takes import Take

__all__ = ["NEEDS_MAP", "LeRobotMap", "read"]

NEEDS_MAP = True

COLUMNS: dict[str, Kind] = {"observation.state": "q", "action": "target"}
"""Kind of column for each feature."""
SUPPORTED = ("v2", "v3")
"""Beginning of supported format versions; the tables of version 2 have the same columns."""


@dataclass(frozen=True)
class LeRobotMap(JointMap):
    """Settings of the import.

    Attributes
    ----------
    angle : str, or dict of str to str
        Required, because a data set does not contain the unit of its positions.
    episodes : list of int
        Episodes to import, by `episode_index`; by default all.
    target : bool
        Whether actions are the commanded positions.
    """

    episodes: list[int] | None = None
    target: bool = True

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.angle is None:
            raise MapError(
                '`angle` is missing: "degrees" or "radians", for all joints or by joint; a data set does not '
                "contain the unit. Positions normalised to -100 to 100 are not angles: record with degrees"
            )


def read(source: Path, settings: Mapping[str, Any], say: ShowProgress) -> Imported:
    """Read the folder of a data set, which contains `meta/info.json` and `data/`."""
    source_map = typed(LeRobotMap, settings)
    info = _read_info(source)
    orders = {feature: _order(source, info, feature) for feature in COLUMNS if feature in info["features"]}
    if "observation.state" not in orders:
        raise SourceError(
            source / INFO, "no feature 'observation.state': the data set has no joint positions"
        )
    if not source_map.target:
        orders.pop("action", None)
    for name in source_map.log_names:
        if name not in orders["observation.state"]:
            raise MapError(f"`joints`: no joint {name!r}; {known(orders['observation.state'])}")
    takes: list[Take] = []
    for path in _tables(source):
        say(path.name)
        takes += _takes(path, source_map, orders)
    if not takes:
        raise SourceError(source, f"no episode of `episodes` = {source_map.episodes}; correct the map")
    imported = assemble_joints(takes, source_map, source.name)
    imported.metadata["notes"] = {
        "times": f"nominal, frame / fps with fps = {info.get('fps')}",
        **imported.metadata.get("notes", {}),
    }
    return imported


INFO = Path("meta") / "info.json"


def _read_info(source: Path) -> dict[str, Any]:
    """Return the content of `meta/info.json`."""
    path = source / INFO
    if not path.is_file():
        raise SourceError(path, "no such file; give the folder of a LeRobot data set, which contains it")
    try:
        info = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise SourceError(path, f"not valid JSON: {error}; download it again") from error
    if not isinstance(info, dict) or not isinstance(info.get("features"), dict):
        raise SourceError(path, "no table `features`; is it the file of a LeRobot data set?")
    version = info.get("codebase_version", "v3")
    if not str(version).startswith(SUPPORTED):
        raise SourceError(
            path,
            f"codebase_version = {version!r}: only versions 2 and 3 are supported; convert it with LeRobot",
        )
    return info


def _order(source: Path, info: Mapping[str, Any], feature: str) -> list[str]:
    """Return the names of the entries of a feature."""
    names = info["features"][feature].get("names") if isinstance(info["features"][feature], dict) else None
    if isinstance(names, dict) and len(names) == 1:
        names = next(iter(names.values()))
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise SourceError(
            source / INFO, f"features.{feature}.names = {names!r}: must be a list of joint names"
        )
    return names


def _tables(source: Path) -> list[Path]:
    paths = sorted(source.glob("data/chunk-*/*.parquet"))
    if not paths:
        raise SourceError(source, "no data/chunk-*/file-*.parquet; download the data set completely")
    return paths


def _takes(path: Path, source_map: LeRobotMap, orders: Mapping[str, Sequence[str]]) -> Iterator[Take]:
    """Yield the chosen episodes in a Parquet file."""
    parquet = require("pyarrow.parquet", "lerobot", "LeRobot data sets")
    widths = {feature: len(order) for feature, order in orders.items()} | {"timestamp": 1, "episode_index": 1}
    try:
        present = parquet.read_schema(path).names
        table = parquet.read_table(path, columns=[name for name in widths if name in present])
        found = {name: table.column(name).to_pylist() for name in table.column_names}
    except Exception as error:
        # For a damaged file the library may raise any exception.
        reason = str(error).split("\n")[0][:200]
        raise SourceError(path, f"not a readable Parquet file ({reason}); download it again") from error
    for name in widths:
        if name not in found:
            raise SourceError(path, f"no column {name!r}; the columns are {', '.join(present)}")
    columns = {name: _matrix(path, name, found[name], width) for name, width in widths.items()}
    numbers = columns["episode_index"][:, 0]
    for number in np.unique(numbers):
        if source_map.episodes is None or number in source_map.episodes:
            yield _take(path, source_map, orders, columns, np.flatnonzero(numbers == number))


def _take(
    path: Path,
    source_map: LeRobotMap,
    orders: Mapping[str, Sequence[str]],
    columns: Mapping[str, Floats],
    rows: np.ndarray,
) -> Take:
    """Return the episode in some rows of the columns."""
    name = f"episode_{columns['episode_index'][rows[0], 0]:06.0f}"
    t = columns["timestamp"][rows, 0]
    late = np.flatnonzero(np.diff(t) <= 0.0)
    if len(late):
        row = rows[late[0] + 1]
        raise SourceError(
            path,
            f"row {row + 1}, column 'timestamp': {columns['timestamp'][row, 0]:.9g} s is not after the row "
            f"before in {name}; record the episode again, or leave it out with `episodes`",
        )
    streams: dict[str, Stream] = {}
    repeated: dict[str, int] = {}
    for feature, order in orders.items():
        kind = COLUMNS[feature]
        for joint, log_name in zip(source_map.names, source_map.log_names, strict=True):
            if log_name in order:
                values = source_map.radians(path, kind, joint, columns[feature][:, order.index(log_name)])
                stream, repeated[f"{kind}_{joint}"] = sample_stream(
                    kind, joint, t, values[rows], source_map.holds(kind, joint)
                )
                streams[f"{kind}_{joint}"] = stream
    return joint_take(path, source_map.names, streams, repeated, name)


def _matrix(path: Path, name: str, rows: Sequence[Any], width: int) -> Floats:
    """Return a column of lists, or of numbers, shape (n, width)."""
    lists = [row if isinstance(row, list) else [row] for row in rows]
    for number, row in enumerate(lists, 1):
        if len(row) != width or not all(
            isinstance(entry, int | float) and np.isfinite(entry) for entry in row
        ):
            raise SourceError(
                path,
                f"row {number}, column {name!r}: {str(row)[:80]} must be {width} numbers, as in "
                f"{INFO.as_posix()}",
            )
    return np.array(lists, dtype=np.float64).reshape(len(lists), width)
