"""CSV files with a column map; several files are several episodes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from trundle.importers.config import typed
from trundle.importers.layout import Floats, Imported, ShowProgress, SourceError
from trundle.importers.tables import TableMap, read_files

__all__ = ["NEEDS_MAP", "CsvFile", "CsvMap", "read"]

NEEDS_MAP = True


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
    """Numeric columns of a CSV file by name, or by number from 1 without a header."""

    def __init__(self, path: Path, source_map: CsvMap) -> None:
        self.path = path
        try:
            self._table = pd.read_csv(
                path,
                sep=source_map.delimiter,
                header=0 if source_map.header else None,
                skiprows=source_map.skip_rows,
                skipinitialspace=True,
                dtype=str,
                keep_default_na=False,
            )
        except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeDecodeError) as error:
            raise SourceError(
                path, f"not a table with the delimiter {source_map.delimiter!r} ({error})"
            ) from error
        names = [str(name).strip() for name in self._table.columns]
        self._table.columns = pd.Index(
            names if source_map.header else [str(i + 1) for i in range(len(names))]
        )

    def vector(self, name: str, index: int | None = None) -> Floats:
        """Return a column, NaN where a cell is empty."""
        if index is not None:
            raise SourceError(
                self.path, f"`index` = {index} with {name!r}: applies only to MATLAB matrices; remove it"
            )
        if name not in self._table:
            raise SourceError(
                self.path, f"no column {name!r}; the columns are {', '.join(map(repr, self._table))}"
            )
        cells = self._table[name].str.strip()
        numbers = pd.to_numeric(cells, errors="coerce").to_numpy(dtype=np.float64)
        wrong = np.flatnonzero(np.isnan(numbers) & ~cells.str.lower().isin(["", "nan", "null"]).to_numpy())
        if len(wrong):
            row = int(wrong[0])
            raise SourceError(
                self.path, f"row {row + 1}, column {name!r}: {cells.iloc[row]!r} is not a number"
            )
        return numbers


def read(source: Path, settings: Mapping[str, Any], say: ShowProgress) -> Imported:
    """Read one file, or every `*.csv` of a folder in the order of their names."""
    source_map = typed(CsvMap, settings)
    return read_files(source, ".csv", lambda path: CsvFile(path, source_map), source_map, say)
