"""CSV files of joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from trundle.importers.config import typed
from trundle.importers.csv_file import CsvFile, DialectMap
from trundle.importers.joints.files import FileMap, JointTableMap, read_joint_files
from trundle.importers.joints.table import ColumnMap
from trundle.importers.layout import Imported, ShowProgress

__all__ = ["CsvFileMap", "JointCsvMap", "read_csv", "read_csv_joints"]


@dataclass(frozen=True)
class CsvFileMap(FileMap):
    """Settings of one of several files of an episode; its layout is by default that of the map."""

    encoding: str | None = None
    delimiter: str | None = None
    decimal: str | None = None
    header: bool | None = None
    skip_rows: int | None = None
    unit_row: bool | None = None


@dataclass(frozen=True)
class JointCsvMap(DialectMap, JointTableMap):
    """Settings of a map file for CSV files of joints."""

    file: tuple[CsvFileMap, ...] = ()


def read_csv_joints(source: Path, settings: Mapping[str, Any], say: ShowProgress) -> Imported:
    """Read the files of a map."""
    return read_csv(source, typed(JointCsvMap, settings), say)


def read_csv(source: Path, source_map: JointCsvMap, say: ShowProgress) -> Imported:
    """Read the files of a parsed map."""

    def open_file(path: Path, column_map: ColumnMap) -> CsvFile:
        layout = {each.name: getattr(source_map, each.name) for each in fields(DialectMap)}
        own = {key: value for key in layout if (value := getattr(column_map, key, None)) is not None}
        return CsvFile(path, DialectMap(**{**layout, **own}).dialect)

    return read_joint_files(source, ".csv", source_map, open_file, say)
