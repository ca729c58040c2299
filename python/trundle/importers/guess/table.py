"""The columns of a CSV file as a guess sees them: parsed names and values."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from trundle.importers.csv_dialect import Dialect, detect
from trundle.importers.csv_file import CsvFile
from trundle.importers.guess.names import ColumnName, parse_name
from trundle.importers.layout import Floats, SourceError

__all__ = ["Table", "read_table"]


@dataclass(frozen=True)
class Table:
    """The first file of a source, from which a map is guessed.

    Attributes
    ----------
    files : list of Path
        All files, in the order of the episodes.
    dialect : Dialect
        Their layout.
    file : CsvFile
        The first file.
    """

    files: list[Path]
    dialect: Dialect
    file: CsvFile

    @cached_property
    def names(self) -> list[ColumnName]:
        """Parsed names of the columns, in the order of the file."""
        units: list[str] | list[None] = self.file.units or [None] * len(self.file.names)
        return [parse_name(name, unit) for name, unit in zip(self.file.names, units, strict=True)]

    def fault(self, name: str) -> str:
        """Return why a column has no usable values; an empty string if it has."""
        try:
            values = self.file.vector(name)
        except SourceError as error:
            return str(error).removeprefix(f"{self.file.path}: ")
        return "" if np.isfinite(values).any() else "has no value in any row"

    def values(self, name: str) -> Floats:
        """Return the values of a column that are present."""
        values = self.file.vector(name)
        return values[np.isfinite(values)]


def read_table(source: Path) -> Table:
    """Read a CSV file, or the first one of a folder, and check that all have the same columns.

    Raises
    ------
    SourceError
        If there is no file, a file is not a table of numbers, or the files have different columns.
    """
    if not source.exists():
        raise SourceError(source, "no such file or folder")
    files = sorted(source.glob("*.csv")) if source.is_dir() else [source]
    if not files:
        raise SourceError(source, "no *.csv in this folder")
    dialect = detect(files[0])
    file = CsvFile(files[0], dialect)
    for other in files[1:]:
        names = CsvFile(other, dialect, limit=1).names
        if names != file.names:
            different = sorted(set(names) ^ set(file.names)) or names
            raise SourceError(
                other,
                f"its columns differ from those of {files[0].name} ({', '.join(different[:6])}); "
                "all files of a folder are episodes with the same columns. Join the files of the streams of "
                "one episode into one table",
            )
    return Table(files, dialect, file)
