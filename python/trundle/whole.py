"""Files and folders that appear whole or not at all."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from trundle._native import TrundleError

__all__ = ["PART", "kept_json", "whole_file", "whole_folder", "write_text"]

PART = ".part"
"""How the name of what is under way ends; a kill may leave it."""


def kept_json(path: Path) -> Any:
    """Return what an earlier call has kept in a file."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise TrundleError(f"{path}: is damaged ({error}): remove it to have it made again") from error


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a path to write to; what is there in the end takes the file's place, or goes if anything fails."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{os.getpid()}{PART}")
    try:
        yield part
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


@contextmanager
def whole_folder(folder: Path, mark: str, what: str) -> Iterator[Path]:
    """Give a folder to write into that in the end takes an earlier one's place, or goes if anything fails.

    Parameters
    ----------
    folder : Path
    mark : str
        File by which an earlier one is known.
    what : str
        What it is, for the error: "a diagnosis".

    Raises
    ------
    TrundleError
        If the folder holds something else.
    """
    if folder.exists() and not (folder / mark).exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise TrundleError(f"{folder}: holds something else than {what}; give another folder with --out")
    folder.parent.mkdir(parents=True, exist_ok=True)
    partial = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
    try:
        partial.chmod(0o755)
        yield partial
        shutil.rmtree(folder, ignore_errors=True)
        partial.rename(folder)
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def write_text(path: Path, text: str) -> None:
    """Write a text file."""
    with whole_file(path) as part:
        part.write_text(text, encoding="utf-8")
