"""CMU's planar pushing with force: an ABB arm, an ATI sensor and motion capture.

Zhou, Paolini, Bagnell and Mason, "A Convex Polynomial Force-Motion Model for Planar Sliding:
Identification and Application", ICRA 2016 (arXiv 1602.06056). A file of `pushes/` becomes a recording
whose episodes are its pushes; the folder `timeseries/` becomes one recording, an episode a log.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from trundle.importers import cmu_logs, cmu_pushes
from trundle.importers.config import typed
from trundle.importers.layout import Imported, Say

__all__ = ["NEEDS_MAP", "SUMMARY", "CmuMap", "read"]

SUMMARY = "CMU planar pushing with force: one file of pushes/, or the folder timeseries/"
NEEDS_MAP = False


@dataclass(frozen=True)
class CmuMap:
    """What may be told about the set.

    Attributes
    ----------
    name : str
        Name of the recording; made from the file's by default.
    held_out_every : int
        Pushes: every such push is only predicted.
    held_out : list of str
        Logs that are only predicted.
    """

    name: str | None = None
    held_out_every: int = 5
    held_out: tuple[str, ...] | list[str] = ("exp3_4",)


def read(source: Path, settings: Mapping[str, Any], say: Say) -> Imported:
    """Read one file of pushes, or the folder of continuous logs."""
    options = typed(CmuMap, settings)
    if source.is_dir():
        return cmu_logs.read(source, options.name, options.held_out, say)
    return cmu_pushes.read(source, options.name, options.held_out_every, say)
