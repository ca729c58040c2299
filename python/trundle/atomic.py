"""Atomic writes of files and folders.

If the process is killed at any time, or the disk is full, the path holds either the old or the complete new
content. A hidden temporary file or folder may remain next to it and can be deleted. Power failures are not
covered: data is not flushed to disk (no fsync).
"""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from trundle._native import TrundleError, _recover_folder, _replace_folder

__all__ = ["PARTIAL_SUFFIX", "atomic_file", "atomic_folder", "read_json", "report_target_path", "write_text"]

PARTIAL_SUFFIX = ".part"
"""Suffix of temporary files, which a killed process leaves behind."""


def read_json(path: Path) -> Any:
    """Read a JSON file that an earlier run wrote.

    Raises
    ------
    TrundleError
        If the file is damaged.
    """
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise TrundleError(f"{path}: is damaged ({error}): delete it, and it is created again") from error


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """Yield a temporary path that replaces `path` at the end, or is deleted if an exception occurs."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{os.getpid()}{PARTIAL_SUFFIX}")
    with report_target_path(part, path):
        try:
            yield part
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)


@contextmanager
def atomic_folder(folder: Path, marker: str, content: str) -> Iterator[Path]:
    """Yield a temporary folder that replaces `folder` at the end, or is deleted if an exception occurs.

    The folders are exchanged in one step. On file systems without such an operation (such as NFS), a process
    that is killed between two renames leaves the old folder as `.NAME.replaced`; the next call restores it.

    Parameters
    ----------
    folder : Path
        New, empty, or an earlier output.
    marker : str
        Name of a file that identifies an earlier output.
    content : str
        What the folder contains, for the error message: "a diagnosis".

    Raises
    ------
    TrundleError
        If the folder contains anything else.
    """
    folder = Path(os.path.realpath(folder))
    _recover_folder(folder)
    if folder.exists() and not (folder / marker).exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise TrundleError(f"{folder}: is not empty and not {content}; give another folder with --out")
    folder.parent.mkdir(parents=True, exist_ok=True)
    partial = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
    with report_target_path(partial, folder):
        try:
            partial.chmod(0o755)
            yield partial
            _replace_folder(partial, folder)
        finally:
            shutil.rmtree(partial, ignore_errors=True)


@contextmanager
def report_target_path(part: Path, path: Path) -> Iterator[None]:
    """Replace the temporary path in an operating system error by the path that is written."""
    try:
        yield
    except OSError as error:
        found = error.filename
        if error.errno is None or (found is not None and not str(found).startswith(str(part))):
            raise
        name = path if found is None else Path(f"{path}{str(found)[len(str(part)) :]}")
        raise OSError(error.errno, error.strerror, str(name)) from error


def write_text(path: Path, text: str) -> None:
    """Write a text file atomically."""
    with atomic_file(path) as part:
        part.write_text(text, encoding="utf-8")
