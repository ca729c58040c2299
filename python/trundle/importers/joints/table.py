"""Joints from files of named columns or variables."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from trundle.importers.config import MapError
from trundle.importers.joints.columns import UNITS_OF, Kind, known, split_column
from trundle.importers.joints.joint_map import JointMap
from trundle.importers.layout import Floats, SourceError
from trundle.importers.quantity import Quantity, Vectors, numbers
from trundle.importers.units import UNITS

__all__ = ["ColumnMap", "Matrices", "check_order", "read_columns", "read_times"]


class Matrices(Vectors, Protocol):
    """A file of named vectors, lists and texts."""

    def matrix(self, name: str, order: Sequence[str]) -> Floats:
        """Return a column of lists, or a matrix, shape (n, k) with k the length of `order`."""

    def cells(self, name: str) -> list[str]:
        """Return a column as text."""


@dataclass(frozen=True)
class ColumnMap:
    """Settings of a map for the columns of one file.

    Attributes
    ----------
    time : str or Quantity
        Sample times, with any origin.
    columns : dict of str to str or Quantity
        Source of each column of the recording, such as `q_elbow`.
    lists : dict of str to str or Quantity
        Source of one kind of column of all joints, such as `q`: a column of lists, or a matrix with a column
        for each joint.
    order : list of str
        Names in the log of the entries of a list; by default those of `joints`.
    """

    time: str | Quantity | None = None
    columns: dict[str, str | Quantity] = field(default_factory=dict)
    lists: dict[Kind, str | Quantity] = field(default_factory=dict)
    order: list[str] | None = None


def read_times(file: Matrices, time: str | Quantity | None) -> Floats:
    """Return the sample times, s."""
    if time is None:
        raise MapError("`time` is missing; name the column of the sample times")
    return numbers(file, time, UNITS["time"], "time")


def check_order(file: Matrices, t: Floats, rows: np.ndarray) -> None:
    """Refuse times, s, that decrease in the rows of an episode."""
    timed = rows[np.isfinite(t[rows])]
    back = np.flatnonzero(np.diff(t[timed]) < 0.0)
    if len(back):
        above, row = int(timed[back[0]]), int(timed[back[0] + 1])
        raise SourceError(
            file.path,
            f"row {row + 1}: time {t[row]:.9g} s is before that of row {above + 1} ({t[above]:.9g} s); sort "
            "the rows, or name the column that counts the recordings in the file as `episode_column`",
        )


def read_columns(
    file: Matrices, column_map: ColumnMap, joint_map: JointMap
) -> Iterator[tuple[Kind, str, Floats]]:
    """Yield kind, joint and values of each mapped column, in SI units."""
    for column, source in column_map.columns.items():
        kind, joint = split_column(column, joint_map.names, "columns")
        values = numbers(file, source, UNITS_OF[kind], f"columns.{column}")
        yield kind, joint, _radians(file, joint_map, kind, joint, source, values)
    order = column_map.order or joint_map.log_names
    absent = [name for name in joint_map.log_names if name not in order]
    if column_map.lists and absent:
        raise MapError(f"`joints`: {absent[0]!r} is not in `order`; {known(order)}")
    for kind, source in column_map.lists.items():
        matrix = _matrix(file, kind, source, order)
        for joint, name in zip(joint_map.names, joint_map.log_names, strict=True):
            values = matrix[:, order.index(name)]
            yield kind, joint, _radians(file, joint_map, kind, joint, source, values)


def _radians(
    file: Matrices, joint_map: JointMap, kind: Kind, joint: str, source: str | Quantity, values: Floats
) -> Floats:
    """Return values in the unit of `angle`, which a unit of the column replaces, in radians."""
    has_unit = isinstance(source, Quantity) and source.unit is not None
    return values if has_unit else joint_map.radians(file.path, kind, joint, values)


def _matrix(file: Matrices, kind: Kind, source: str | Quantity, order: Sequence[str]) -> Floats:
    """Return one kind of column of all joints in SI units, shape (n, k)."""
    quantity = Quantity(name=source) if isinstance(source, str) else source
    if quantity.name is None or quantity.product or quantity.sum or quantity.index is not None:
        raise MapError(
            f"`lists.{kind}`: give only `name`, `unit` and `scale` of a column of lists or a matrix"
        )
    return file.matrix(quantity.name, order) * quantity.size(UNITS_OF[kind], f"lists.{kind}")
