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
from trundle.importers.config import MapError, typed
from trundle.importers.layout import Imported, ShowProgress

__all__ = ["NEEDS_MAP", "CmuMap", "read"]

NEEDS_MAP = False


@dataclass(frozen=True)
class CmuMap:
    """What may be told about the set.

    Attributes
    ----------
    name : str
        Name of the recording; made from the file's by default.
    held_out_every : int
        Every such push, or log, is only predicted: by default the fifth of five pushes
        and the second of two logs.
    logs : list of str
        Which of the continuous logs, by default those of the later sessions (`cmu_logs.EARLIER`).
    """

    name: str | None = None
    held_out_every: int | None = None
    logs: list[str] | None = None


def read(source: Path, settings: Mapping[str, Any], say: ShowProgress) -> Imported:
    """Read one file of pushes, or the folder of continuous logs."""
    options = typed(CmuMap, settings)
    usual = 2 if source.is_dir() else 5
    every = usual if options.held_out_every is None else options.held_out_every
    if every < 2:
        raise MapError(f"`held_out_every` = {every} leaves nothing to fit; it is 2 or more")
    if source.is_dir():
        return cmu_logs.read(source, options.name, every, say, options.logs)
    if options.logs is not None:
        raise MapError("`logs` chooses among the logs of the folder timeseries/; a file of pushes has none")
    return cmu_pushes.read(source, options.name, every, say)
