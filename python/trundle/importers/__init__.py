"""Importers: convert data of other formats to recordings.

Each layout has one module. `IMPORTERS` lists them by the value of `trundle import --from`.

Examples
--------
>>> import trundle
>>> sorted(trundle.importers.IMPORTERS)[:2]
['cmu-planar-push', 'csv']
"""

from __future__ import annotations

import importlib
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

from trundle.importers.config import MapError, load
from trundle.importers.guess import MapGuess, guess_map, map_text, write_map
from trundle.importers.joints.documents import add_models
from trundle.importers.layout import Imported, Importer, ShowProgress, SourceError

__all__ = [
    "IMPORTERS",
    "Imported",
    "MapError",
    "MapGuess",
    "SourceError",
    "guess_map",
    "importer",
    "map_text",
    "read",
    "write_map",
]


def __dir__() -> list[str]:
    return __all__


IMPORTERS = {
    "cmu-planar-push": "cmu",
    "csv": "csv_map",
    "emps": "emps",
    "lerobot": "lerobot",
    "mat": "mat",
    "mcap": "rosbag",
    "pendulum": "pendulum",
    "pneumatic-seal": "pneumatic_seal",
    "rosbag2": "rosbag",
    "so101": "so101",
    "xl330": "xl330",
}
"""Module of this package by layout."""
GUESS_HINT = defaultdict(str, csv="; --guess proposes one, and --init MAP writes it")
"""Addition to the message about a missing map, by layout."""


def importer(layout: str) -> Importer:
    """Return the module that reads a layout.

    Examples
    --------
    >>> from trundle import importers
    >>> importers.importer("csv").NEEDS_MAP
    True
    """
    if layout not in IMPORTERS:
        raise SourceError(layout, f"unknown layout; choose one of {', '.join(IMPORTERS)}")
    return cast("Importer", importlib.import_module(f"{__name__}.{IMPORTERS[layout]}"))


def read(
    source: Path,
    layout: str,
    map_file: Path | Mapping[str, Any] | None = None,
    say: ShowProgress = lambda _: None,
) -> Imported:
    """Read a source.

    Parameters
    ----------
    source : Path
        File or folder.
    layout : str
        A key of `IMPORTERS`.
    map_file : Path or mapping, optional
        TOML file, or its content, that assigns topics, columns or variables to the columns of a recording,
        such as `guess_map(source).settings`. Some layouts do not need one.
    say : callable
        Shows progress.

    Returns
    -------
    Imported
        Metadata and tables. They are not validated; `trundle.Recording` does that.

    Raises
    ------
    SourceError, MapError
        If the source or the map is invalid.

    Examples
    --------
    >>> from pathlib import Path
    >>> import trundle
    >>> found = trundle.importers.read(Path("run_3.mcap"), "mcap", Path("bag.toml"))  # doctest: +SKIP
    >>> recording = trundle.Recording(found.metadata, found.episodes)  # doctest: +SKIP
    """
    module = importer(layout)
    if map_file is None and module.NEEDS_MAP:
        raise SourceError(
            source,
            f"--from {layout} needs --map: a TOML file that assigns the columns (docs/import.md)"
            f"{GUESS_HINT[layout]}",
        )
    if not source.exists():
        raise SourceError(source, "no such file or folder")
    settings = load(map_file) if isinstance(map_file, Path) else map_file or {}
    try:
        imported = module.read(source, settings, say)
        add_models(imported, map_file.parent if isinstance(map_file, Path) else Path())
        return imported
    except MapError as error:
        named = map_file if isinstance(map_file, Path) else "map"
        raise MapError(f"{named}: {error}") from error
