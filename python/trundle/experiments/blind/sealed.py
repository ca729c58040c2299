"""The sealed truth: one file whose SHA-256 is printed before the first diagnosis."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

from trundle.atomic import write_text
from trundle.recording import TrundleError

__all__ = ["digest", "folder_digest", "open_sealed", "seal"]

FORMAT = "trundle-proof-answers/1"


def seal(path: Path, settings: dict[str, Any], answers: dict[str, dict[str, Any]]) -> str:
    """Write the truth by case and return the SHA-256 of the file; the same truth gives the same bytes."""
    ordered = {case: answers[case] for case in sorted(answers)}
    lines = [f'"{case}": {json.dumps(answer, sort_keys=True)}' for case, answer in ordered.items()]
    head = f'"format": "{FORMAT}",\n"settings": {json.dumps(settings, sort_keys=True)}'
    write_text(path, "{" + head + ',\n"cases": {\n' + ",\n".join(lines) + "\n}}\n")
    return digest(path)


def digest(path: Path) -> str:
    """Return the SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def folder_digest(folder: Path) -> str:
    """Return the SHA-256 of the files in a folder."""
    found = hashlib.sha256()
    for path in sorted(folder.iterdir()):
        found.update(f"{path.name}\0".encode())
        found.update(hashlib.sha256(path.read_bytes()).digest())
    return found.hexdigest()


def open_sealed(path: Path, expected: str) -> dict[str, dict[str, Any]]:
    """Return the truth by case.

    Raises
    ------
    TrundleError
        If the file is not the one that was sealed.
    """
    if digest(path) != expected:
        raise TrundleError(
            f"{path}: SHA-256 {digest(path)} is not {expected}, which was printed before the first "
            "diagnosis. The file has changed: rerun with --fresh"
        )
    cases: dict[str, dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))["cases"]
    return cases
