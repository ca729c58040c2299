"""Models of a recording: MJCF and URDF files that `recording.toml` names, with their included files."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from trundle.importers.config import MapError
from trundle.importers.layout import Imported

__all__ = ["add_models"]


def add_models(imported: Imported, folder: Path) -> None:
    """Copy the models that a recording of joints names into it, and name them by their files' names.

    Parameters
    ----------
    imported : Imported
        Metadata are changed in place: a model that is not yet among `imported.files` is read.
    folder : Path
        Folder to which the paths of models are relative, that of the map.

    Raises
    ------
    MapError
        If a model cannot be read, is not XML, or two files of one name differ.
    """
    for key, table in _tables_with_models(imported.metadata):
        model = table["model"]
        if not isinstance(model, str):
            raise MapError(f"`recording.{key}.model` = {model!r}: it is the path of an MJCF or URDF file")
        if model in imported.files:
            continue
        for path in _with_includes(folder / model, f"recording.{key}.model", ()):
            text = path.read_text(encoding="utf-8")
            if imported.files.setdefault(path.name, text) != text:
                raise MapError(
                    f"`recording.{key}.model`: two files are named {path.name}; rename one of them"
                )
        table["model"] = Path(model).name


def _tables_with_models(metadata: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    tables = {"mechanism": metadata.get("mechanism", {})}
    episodes = metadata.get("episode", {})
    if isinstance(episodes, dict):
        tables |= {f"episode.{name}": each for name, each in episodes.items()}
    for key, table in tables.items():
        if isinstance(table, dict) and "model" in table:
            yield key, table


def _with_includes(path: Path, where: str, above: tuple[Path, ...]) -> Iterator[Path]:
    """Yield a model and the files that it includes, which must be in its folder."""
    if path in above:
        raise MapError(f"`{where}`: {path} includes itself; remove the <include>")
    try:
        root = ElementTree.fromstring(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise MapError(f"`{where}`: {path}: {error.strerror}; paths are relative to the map") from error
    except (ElementTree.ParseError, UnicodeError) as error:
        raise MapError(f"`{where}`: {path} is not an MJCF or URDF file: {error}") from error
    yield path
    for element in root.iter("include"):
        name = element.get("file", "")
        if not name or Path(name).name != name:
            raise MapError(f"`{where}`: {path} includes {name!r}; move it next to {path.name}")
        yield from _with_includes(path.parent / name, where, (*above, path))
