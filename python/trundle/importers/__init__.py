"""Importers: what people have, turned into a recording.

One module a layout; `IMPORTERS` lists them by the name that `trundle import --from` takes.
"""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import cast

from trundle.importers.config import MapError, load
from trundle.importers.layout import Imported, Importer, ShowProgress, SourceError

__all__ = ["IMPORTERS", "Imported", "MapError", "SourceError", "importer", "read"]

IMPORTERS = {
    "cmu-planar-push": "cmu",
    "csv": "csv_map",
    "emps": "emps",
    "mat": "mat",
    "mcap": "rosbag",
    "pneumatic-seal": "pneumatic_seal",
    "rosbag2": "rosbag",
}
"""Layout to module of this package."""


def importer(layout: str) -> Importer:
    """Return the module that reads a layout."""
    if layout not in IMPORTERS:
        raise SourceError(layout, f"no such layout; known are {', '.join(IMPORTERS)}")
    return cast("Importer", importlib.import_module(f"{__name__}.{IMPORTERS[layout]}"))


def read(
    source: Path, layout: str, map_file: Path | None = None, say: ShowProgress = lambda _: None
) -> Imported:
    """Read a source.

    Parameters
    ----------
    source : Path
        File or folder.
    layout : str
        A key of `IMPORTERS`.
    map_file : Path, optional
        TOML that says which topic, column or variable is what; some layouts need none.
    say : callable
        Shows progress.

    Returns
    -------
    Imported
        Metadata and tables, not validated yet: `trundle.Recording` does that.
    """
    module = importer(layout)
    if map_file is None and module.NEEDS_MAP:
        raise SourceError(
            source, f"--from {layout} needs --map: a TOML file that says what is what (docs/import.md)"
        )
    if not source.exists():
        raise SourceError(source, "no such file or folder")
    settings = {} if map_file is None else load(map_file)
    try:
        return module.read(source, settings, say)
    except MapError as error:
        raise MapError(f"{map_file}: {error}") from error
