"""CSV files with a column map; several files are several episodes."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from trundle.importers.config import MapError, typed
from trundle.importers.layout import Floats, Imported, ShowProgress, SourceError
from trundle.importers.tables import TableMap, read_files

__all__ = ["NEEDS_MAP", "CsvFile", "CsvMap", "read"]

NEEDS_MAP = True

EMPTY_CELLS = ("", "nan", "null")
"""Cells without a sample, in any case."""


@dataclass(frozen=True)
class CsvMap(TableMap):
    """Settings of a map file for CSV files, in addition to `TableMap`.

    Attributes
    ----------
    delimiter : str
        Separator of cells.
    header : bool
        Whether the first row contains the column names; else columns are named "1", "2", …
    skip_rows : int
        Number of lines to skip at the beginning.
    """

    delimiter: str = ","
    header: bool = True
    skip_rows: int = 0


class CsvFile:
    """Numeric columns of a CSV file by name, or by number from 1 without a header.

    Parameters
    ----------
    path : Path
        File in UTF-8. Empty lines are skipped, and absent cells at the end of a row are empty.
    source_map : CsvMap
        Layout of the file.

    Raises
    ------
    SourceError
        If the file is not a table with this layout.
    """

    def __init__(self, path: Path, source_map: CsvMap) -> None:
        self.path = path
        rows = self._read_rows(source_map)
        if not rows:
            raise SourceError(path, "no rows")
        width = len(rows[0])
        names = [name.strip() for name in rows.pop(0)] if source_map.header else range(1, width + 1)
        self._cells: dict[str, list[str]] = {str(name): [] for name in names}
        if len(self._cells) < width:
            raise SourceError(
                path, f"two columns have the same name; the columns are {', '.join(map(repr, names))}"
            )
        for number, row in enumerate(rows, start=1):
            if any(cell.strip() for cell in row[width:]):
                raise SourceError(path, f"row {number} has {len(row)} cells, but there are {width} columns")
            filled = [*row[:width], *[""] * (width - len(row))]
            for cells, cell in zip(self._cells.values(), filled, strict=True):
                cells.append(cell.strip())

    def _read_rows(self, source_map: CsvMap) -> list[list[str]]:
        """Return the cells of all lines that are not empty."""
        delimiter = source_map.delimiter
        if len(delimiter) != 1:
            raise MapError(f"`delimiter` = {delimiter!r}: must be one character, such as ',', ';' or '\\t'")
        try:
            with self.path.open(encoding="utf-8-sig", newline="") as file:
                lines = islice(file, source_map.skip_rows, None)
                return [row for row in csv.reader(lines, delimiter=delimiter, skipinitialspace=True) if row]
        except (csv.Error, UnicodeDecodeError) as error:
            raise SourceError(self.path, f"not a table with the delimiter {delimiter!r} ({error})") from error

    def vector(self, name: str, index: int | None = None) -> Floats:
        """Return a column, NaN where a cell is empty."""
        if index is not None:
            raise SourceError(
                self.path, f"`index` = {index} with {name!r}: applies only to MATLAB matrices; remove it"
            )
        if name not in self._cells:
            raise SourceError(
                self.path, f"no column {name!r}; the columns are {', '.join(map(repr, self._cells))}"
            )
        numbers = np.empty(len(self._cells[name]))
        for row, cell in enumerate(self._cells[name]):
            try:
                numbers[row] = np.nan if cell.lower() in EMPTY_CELLS else parse_number(cell)
            except ValueError as error:
                raise SourceError(
                    self.path, f"row {row + 1}, column {name!r}: {cell!r} is not a number"
                ) from error
        return numbers


def parse_number(cell: str) -> float:
    """Return the number in a cell; raise `ValueError` for other text."""
    if "_" in cell:  # Python's separator of thousands, which no logger writes
        raise ValueError(cell)
    return float(cell)


def read(source: Path, settings: Mapping[str, Any], say: ShowProgress) -> Imported:
    """Read one file, or every `*.csv` of a folder in the order of their names."""
    source_map = typed(CsvMap, settings)
    return read_files(source, ".csv", lambda path: CsvFile(path, source_map), source_map, say)
