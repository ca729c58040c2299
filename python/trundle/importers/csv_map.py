"""CSV files with a column map; several files are several episodes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from trundle.importers.config import typed
from trundle.importers.csv_file import CsvFile, DialectMap
from trundle.importers.joints.csv_map import read_csv_joints
from trundle.importers.joints.joint_map import is_joint_map
from trundle.importers.layout import Imported, ShowProgress
from trundle.importers.tables import TableMap, read_files

__all__ = ["NEEDS_MAP", "CsvMap", "read"]

NEEDS_MAP = True


@dataclass(frozen=True)
class CsvMap(DialectMap, TableMap):
    """Settings of a map file for CSV files of a pushed object."""


def read(source: Path, settings: Mapping[str, Any], say: ShowProgress) -> Imported:
    """Read one file, or every `*.csv` of a folder in the order of their names."""
    if is_joint_map(settings):
        return read_csv_joints(source, settings, say)
    source_map = typed(CsvMap, settings)
    return read_files(source, ".csv", lambda path: CsvFile(path, source_map.dialect), source_map, say)
