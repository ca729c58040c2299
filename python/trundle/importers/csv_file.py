"""CSV files: their layout in a map, and their columns by name."""

from __future__ import annotations

import csv
import itertools
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from trundle.importers.config import MapError
from trundle.importers.csv_dialect import EMPTY, Dialect, is_number
from trundle.importers.layout import Floats, SourceError

__all__ = ["CsvFile", "DialectMap"]


@dataclass(frozen=True)
class DialectMap:
    """Settings of a map file for the layout of CSV files.

    Attributes
    ----------
    encoding : str
        Codec of the text.
    delimiter : str
        Separator of cells; a space matches any number of spaces.
    decimal : str
        Decimal sign, "." or ",".
    header : bool
        Whether the first row contains the column names; else columns are named "1", "2", …
    skip_rows : int
        Number of lines to skip at the beginning.
    unit_row : bool
        Whether the row below the header contains units, and is skipped.
    """

    encoding: str = "utf-8"
    delimiter: str = ","
    decimal: str = "."
    header: bool = True
    skip_rows: int = 0
    unit_row: bool = False

    @property
    def dialect(self) -> Dialect:
        """The layout of the files."""
        if len(self.delimiter) != 1:
            raise MapError(f"`delimiter` = {self.delimiter!r}: must be one character, such as ',' or ';'")
        return Dialect(
            self.encoding, self.delimiter, self.decimal, self.header, self.skip_rows, self.unit_row
        )


class CsvFile:
    """Numeric columns of a CSV file by name, or by number from 1 without a header.

    Attributes
    ----------
    path : Path
        The file.
    names : list of str
        Columns in the order of the file.
    units : list of str or None
        Cells of the row of units by column, or None without such a row.
    rows : list of list of str
        Cells.
    """

    def __init__(self, path: Path, dialect: Dialect, limit: int | None = None) -> None:
        self.path, self._dialect = path, dialect
        try:
            # This codec also reads UTF-8 without a byte-order mark.
            encoding = "utf-8-sig" if dialect.encoding == "utf-8" else dialect.encoding
            with path.open(encoding=encoding, newline="") as file:
                self.rows = list(itertools.islice(_rows(file, dialect), limit))
        except (csv.Error, UnicodeError, LookupError) as error:
            raise SourceError(path, f"cannot be read with {_describe(dialect)}: {error}{REMEDY}") from error
        if not self.rows:
            raise SourceError(path, "is empty; it must have a header and one row for each sample")
        first = [cell.strip() for cell in self.rows[0]]
        self.names = first if dialect.header else [str(i + 1) for i in range(len(first))]
        self.units = (
            [cell.strip() for cell in self.rows[1]] if dialect.unit_row and len(self.rows) > 1 else None
        )
        self.rows = self.rows[dialect.header + dialect.unit_row :]
        self._check_widths()

    def _check_widths(self) -> None:
        for number, row in enumerate(self.rows, 1):
            # A delimiter at the end of every row is common and adds an empty cell.
            if len(row) == len(self.names) + 1 and not row[-1].strip():
                row.pop()
            if len(row) != len(self.names):
                raise SourceError(
                    self.path,
                    f"row {number} has {len(row)} cells and the header {len(self.names)} (with "
                    f"{_describe(self._dialect)}); correct or delete the row{REMEDY}",
                )

    def vector(self, name: str, index: int | None = None) -> Floats:
        """Return a column, NaN where a cell is empty."""
        if index is not None:
            raise SourceError(
                self.path, f"`index` = {index} with {name!r}: applies only to MATLAB matrices; remove it"
            )
        decimal = self._dialect.decimal
        cells = self.cells(name)
        try:
            return np.array([_number(cell, decimal) for cell in cells])
        except ValueError:
            row = next(number for number, cell in enumerate(cells) if not is_number(cell, decimal))
            hint = '; for a decimal comma set `decimal` = ","' if is_number(cells[row], ",") else ""
            raise SourceError(
                self.path, f"row {row + 1}, column {name!r}: {cells[row]!r} is not a number{hint}"
            ) from None

    def matrix(self, name: str, order: Sequence[str]) -> Floats:
        """Return a column of lists such as "[0.1, 0.2]", shape (n, k); NaN in the rows of empty cells.

        Parameters
        ----------
        name : str
            The column.
        order : sequence of str
            Names of the k entries of a list.
        """
        width = len(order)
        rows = []
        for number, cell in enumerate(self.cells(name), 1):
            entries = LIST_SEPARATORS.split(cell.strip("[](){} \t")) if cell else ["nan"] * width
            if len(entries) != width:
                raise SourceError(
                    self.path,
                    f"row {number}, column {name!r}: a list of {len(entries)} values, but `order` (by "
                    f"default `joints`) has {width}: {', '.join(order)}; give `order`, the joints in the "
                    "order of the list, or correct the row",
                )
            try:
                rows.append([_number(entry, ".") for entry in entries])
            except ValueError:
                raise SourceError(
                    self.path,
                    f"row {number}, column {name!r}: {cell!r} is not a list of numbers such as [0.1, 0.2]",
                ) from None
        return np.array(rows, dtype=np.float64).reshape(len(rows), width)

    def cells(self, name: str) -> list[str]:
        """Return the cells of a column without surrounding spaces."""
        if name not in self.names:
            wrong = f" (with {_describe(self._dialect)}{REMEDY})" if len(self.names) == 1 else ""
            raise SourceError(
                self.path, f"no column {name!r}; the columns are {', '.join(map(repr, self.names))}{wrong}"
            )
        if self.names.count(name) > 1:
            raise SourceError(self.path, f"has two columns {name!r}; rename one of them in the header")
        place = self.names.index(name)
        return [row[place].strip() for row in self.rows]


LIST_SEPARATORS = re.compile(r"\s*[,;]\s*|\s+")
REMEDY = "; `encoding`, `delimiter` and `decimal` of the map set the layout, and `--guess` detects it"


def _rows(file: Iterator[str], dialect: Dialect) -> Iterator[list[str]]:
    """Yield the rows from the header on, without blank lines."""
    lines = itertools.islice(file, dialect.skip_rows, None)
    if dialect.delimiter == " ":
        return (line.split() for line in lines if line.strip())
    reader = csv.reader(lines, delimiter=dialect.delimiter, skipinitialspace=True)
    return (row for row in reader if row and (len(row) > 1 or row[0].strip()))


def _number(cell: str, decimal: str) -> float:
    """Return a cell as a number, NaN if it has no value."""
    if cell.lower() in EMPTY:
        return float("nan")
    if decimal != ".":
        cell = cell.replace(".", "_").replace(decimal, ".")
    if "_" in cell:
        raise ValueError(cell)
    return float(cell)


def _describe(dialect: Dialect) -> str:
    return f"encoding {dialect.encoding}, delimiter {dialect.delimiter!r}, decimal sign {dialect.decimal!r}"
