"""Files and folders that appear whole or not at all.

A process that is killed at any instant, or a full disk, leaves at the path what was there before or all
that is new; beside it there may be a hidden file or folder, which is of no use. A power cut is not covered:
nothing waits for the disk.
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
"""How the name of what is under way ends; a kill may leave it."""


def read_json(path: Path) -> Any:
    """Return what an earlier call has kept in a file."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise TrundleError(f"{path}: is damaged ({error}): remove it to have it made again") from error


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """Give a path to write to; what is there in the end takes the file's place, or goes if anything fails."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{os.getpid()}{PARTIAL_SUFFIX}")
    with report_target_path(part, path):
        try:
            yield part
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)


@contextmanager
def atomic_folder(folder: Path, mark: str, what: str) -> Iterator[Path]:
    """Give a folder to write into that in the end takes an earlier one's place, or goes if anything fails.

    The two are exchanged in one step. On a file system that cannot do that (NFS, for one), a process that is
    killed between two renames leaves the earlier folder as `.NAME.replaced`; the next call brings it back.

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
    folder = Path(os.path.realpath(folder))
    _recover_folder(folder)
    if folder.exists() and not (folder / mark).exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise TrundleError(f"{folder}: holds something else than {what}; give another folder with --out")
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
    """Name in an operating system's error the path that is written, not the hidden one or none."""
    try:
        yield
    except OSError as error:
        found = error.filename
        if error.errno is None or (found is not None and not str(found).startswith(str(part))):
            raise
        name = path if found is None else Path(f"{path}{str(found)[len(str(part)) :]}")
        raise OSError(error.errno, error.strerror, str(name)) from error


def write_text(path: Path, text: str) -> None:
    """Write a text file."""
    with atomic_file(path) as part:
        part.write_text(text, encoding="utf-8")
