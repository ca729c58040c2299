"""SHA-256 fingerprints of the input files, so that a reader can check that they have the same input."""

from __future__ import annotations

import hashlib
import os
import shlex
from pathlib import Path

__all__ = ["fingerprint", "inputs"]

_BLOCK_BYTES = 1 << 20


def inputs(**given: object) -> list[dict[str, str]]:
    """Return `what`, `sha256` and `check` (the command that prints it) of each input that is a path.

    Recordings and models in memory have no fingerprint and are omitted.

    Examples
    --------
    >>> import trundle
    >>> (found,) = trundle.report.inputs(model="configs/objects/chair.toml")
    >>> found["what"], len(found["sha256"])
    ('model', 64)
    """
    paths = {what: Path(path) for what, path in given.items() if isinstance(path, str | os.PathLike)}
    return [
        {"what": what, "sha256": fingerprint(path), "check": _check(path)} for what, path in paths.items()
    ]


def fingerprint(path: Path) -> str:
    """Return the SHA-256 of a file, or of the concatenated files of a folder in the order of their names.

    For a folder it equals the output of ``cat FOLDER/* | sha256sum`` in the C locale: hidden files and
    subfolders are ignored.
    """
    digest = hashlib.sha256()
    for file in _files(path):
        with file.open("rb") as stream:
            while block := stream.read(_BLOCK_BYTES):
                digest.update(block)
    return digest.hexdigest()


def _check(path: Path) -> str:
    name = shlex.quote(str(path))
    return f"cat {name}/* | sha256sum" if path.is_dir() else f"sha256sum {name}"


def _files(path: Path) -> list[Path]:
    if not path.is_dir():
        return [path]
    visible = (file for file in path.iterdir() if file.is_file() and not file.name.startswith("."))
    return sorted(visible, key=lambda file: file.name.encode())
