"""CSV files with a column map; several files are several episodes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from trundle.importers.layout import Floats, Imported, Say, SourceError
from trundle.importers.tables import TableMap, read_files

__all__ = ["NEEDS_MAP", "SUMMARY", "CsvFile", "read"]

SUMMARY = "CSV with a column map: a file, or a folder of files that are one episode each"
NEEDS_MAP = True


class CsvFile:
    """Columns of numbers, by name, or by number from 1 where there is no header."""

    def __init__(self, path: Path, told: TableMap) -> None:
        self.path = path
        try:
            self._table = pd.read_csv(
                path,
                sep=told.delimiter,
                header=0 if told.header else None,
                skiprows=told.skip_rows,
                skipinitialspace=True,
                dtype=str,
                keep_default_na=False,
            )
        except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeDecodeError) as error:
            raise SourceError(path, f"not a table with the delimiter {told.delimiter!r} ({error})") from error
        names = [str(name).strip() for name in self._table.columns]
        self._table.columns = pd.Index(names if told.header else [str(i + 1) for i in range(len(names))])

    def vector(self, name: str, index: int | None = None) -> Floats:
        """Return a column, NaN where a cell is empty."""
        if index is not None:
            raise SourceError(
                self.path, f"`index` = {index} with {name!r}: a CSV column has no columns of its own"
            )
        if name not in self._table:
            raise SourceError(self.path, f"no column {name!r}; it has {', '.join(map(repr, self._table))}")
        cells = self._table[name].str.strip()
        numbers = pd.to_numeric(cells, errors="coerce").to_numpy(dtype=np.float64)
        wrong = np.flatnonzero(np.isnan(numbers) & ~cells.str.lower().isin(["", "nan", "null"]).to_numpy())
        if len(wrong):
            row = int(wrong[0])
            raise SourceError(self.path, f"row {row + 1}, column {name!r}: {cells.iloc[row]!r} is no number")
        return numbers


def read(source: Path, settings: Mapping[str, Any], say: Say) -> Imported:
    """Read one file, or every `*.csv` of a folder in the order of their names."""
    return read_files(source, ".csv", CsvFile, settings, say)
