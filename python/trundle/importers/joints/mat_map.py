"""MATLAB files of joints."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from trundle.importers.config import typed
from trundle.importers.joints.files import JointTableMap, read_joint_files
from trundle.importers.layout import Imported, ShowProgress
from trundle.importers.matfile import MatFile

__all__ = ["read_mat_joints"]


def read_mat_joints(source: Path, settings: Mapping[str, Any], say: ShowProgress) -> Imported:
    """Read the files of a map."""
    return read_joint_files(
        source, ".mat", typed(JointTableMap, settings), lambda path, _: MatFile(path), say
    )
