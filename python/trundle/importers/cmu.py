"""The CMU data set of planar pushing with force: an ABB arm, an ATI sensor and motion capture.

Zhou, Paolini, Bagnell and Mason, "A Convex Polynomial Force-Motion Model for Planar Sliding:
Identification and Application", ICRA 2016 (arXiv 1602.06056). A file in `pushes/` becomes a recording with
one episode per push. The folder `timeseries/` becomes a recording with one episode per log.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from trundle.importers import cmu_logs, cmu_pushes
from trundle.importers.config import MapError, typed
from trundle.importers.layout import Imported, ShowProgress

__all__ = ["NEEDS_MAP", "CmuMap", "read"]

NEEDS_MAP = False


@dataclass(frozen=True)
class CmuMap:
    """Settings of the import; all are optional.

    Attributes
    ----------
    name : str
        Name of the recording; by default derived from the name of the file.
    held_out_every : int
        Every n-th push or log is held out; by default 5 for pushes and 2 for logs.
    logs : list of str
        Continuous logs to read; by default those that are not in `cmu_logs.EARLIER_SESSION`.
    """

    name: str | None = None
    held_out_every: int | None = None
    logs: list[str] | None = None


def read(source: Path, settings: Mapping[str, Any], say: ShowProgress) -> Imported:
    """Read one file of pushes, or the folder of continuous logs."""
    options = typed(CmuMap, settings)
    default = 2 if source.is_dir() else 5
    every = default if options.held_out_every is None else options.held_out_every
    if every < 2:
        raise MapError(f"`held_out_every` = {every}: must be at least 2, so that episodes to fit remain")
    if source.is_dir():
        return cmu_logs.read(source, options.name, every, say, options.logs)
    if options.logs is not None:
        raise MapError("`logs`: applies only to the folder timeseries/; remove it for a file of pushes")
    return cmu_pushes.read(source, options.name, every, say)
