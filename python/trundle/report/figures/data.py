"""The data of a figure as CSV in a link, from which the script of the page also reads the values it shows."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from urllib.parse import quote

import numpy as np

from trundle.report.decimate import representative_rows
from trundle.report.series import Array, finite

__all__ = ["Data", "Table", "tabulate"]

Cell = str | float | None

MAX_ROWS = 200
"""Maximum number of rows of curves over time, about one per pixel."""
_SAFE = " ,;:()/+*=·°±-_.~'"
"""Characters that a data link may contain as they are."""


@dataclass(frozen=True)
class Data:
    """A table: names of its columns with units, and its rows; an absent number is None or NaN."""

    columns: tuple[str, ...]
    rows: Sequence[Sequence[Cell]]

    @property
    def csv(self) -> str:
        """The table as CSV, with five significant digits."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.columns)
        writer.writerows([_text(cell) for cell in row] for row in self.rows)
        return text.getvalue()

    @property
    def uri(self) -> str:
        """The table as a link that needs no network."""
        return f"data:text/csv;charset=utf-8,{quote(self.csv, safe=_SAFE)}"


@dataclass(frozen=True)
class Table:
    """Columns of numbers over time: names with units, time (n,) in s, and values (n, k)."""

    names: tuple[str, ...]
    t: Array
    values: Array

    def with_columns(self, names: Sequence[str], values: Array) -> Table:
        """Return the table with further columns (n, k) at the end."""
        return Table((*self.names, *names), self.t, np.column_stack([self.values, values]))

    def data(self, axis: str = "time, s") -> Data:
        """Return at most `MAX_ROWS` rows, with the extremes of every column. `axis` names the times."""
        rows = representative_rows(self.t, self.values, MAX_ROWS)
        return Data((axis, *self.names), np.column_stack([self.t, self.values])[rows].tolist())


def tabulate(names: Sequence[str], curves: Sequence[tuple[Array, Array]]) -> Table:
    """Return curves, given as times and values (n,), as columns over their common times.

    A curve with other times is interpolated linearly, and is NaN outside them.
    """
    times = [t for t, _ in curves]
    if not times:
        return Table((), np.empty(0), np.empty((0, 0)))
    shared = all(len(t) == len(times[0]) and np.array_equal(t, times[0]) for t in times)
    t = times[0] if shared else np.unique(np.concatenate(times))
    columns = [y if shared else np.interp(t, own, y, left=np.nan, right=np.nan) for own, y in curves]
    return Table(tuple(names), t, np.column_stack(columns))


def _text(cell: Cell) -> str:
    if isinstance(cell, str):
        return cell
    number = finite(cell)
    return "" if number is None else f"{number:.5g}"
