"""MATLAB files with a map of variables; several files are several episodes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from trundle.importers.config import typed
from trundle.importers.joints.joint_map import is_joint_map
from trundle.importers.joints.mat_map import read_mat_joints
from trundle.importers.layout import Imported, ShowProgress
from trundle.importers.matfile import MatFile
from trundle.importers.tables import TableMap, read_files

__all__ = ["NEEDS_MAP", "read"]

NEEDS_MAP = True


def read(source: Path, settings: Mapping[str, Any], say: ShowProgress) -> Imported:
    """Read one file, or every `*.mat` of a folder in the order of their names."""
    if is_joint_map(settings):
        return read_mat_joints(source, settings, say)
    return read_files(source, ".mat", MatFile, typed(TableMap, settings), say)
