"""What has been played: one line for each episode, appended as soon as it ends."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from trundle import __version__
from trundle.comparison.config import Agent, Worlds
from trundle.paper.results import Row
from trundle.recording import TrundleError

__all__ = ["Journal", "key"]


def key(worlds: Worlds, agent: Agent, run: int, seed: int, digests: Mapping[str, str]) -> str:
    """Return what an episode's outcome depends on, as a key.

    Neither names nor numbers of worlds are in it: an episode is kept while others are added. The version of
    trundle is, but not its code: whoever changes that forgets what has been played (`--fresh`).

    Parameters
    ----------
    digests : mapping
        SHA-256 of each policy's file.
    """
    file = digests[agent.files[run]] if agent.files else ""
    told = json.dumps([__version__, worlds.identity, agent.identity, file, seed], sort_keys=True)
    return hashlib.sha256(told.encode()).hexdigest()[:32]


class Journal:
    """Episodes that outlive an interruption at any moment.

    A line that was cut short is forgotten, with its episode.

    Parameters
    ----------
    path : Path
        The file; made with the first episode.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._rows: dict[str, tuple[Row, Row]] = {}
        if path.exists():
            self._load()

    def __contains__(self, name: str) -> bool:
        return name in self._rows

    def __getitem__(self, name: str) -> tuple[Row, Row]:
        return self._rows[name]

    def add(self, name: str, row: Row, timing: Row) -> None:
        """Keep an episode's outcome and what its decisions cost."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with self.path.open("ab") as file:
            file.write(json.dumps({"key": name, "row": row, "timing": timing}).encode() + b"\n")
        self._rows[name] = row, timing

    def _load(self) -> None:
        text = self.path.read_bytes()
        whole = text[: text.rfind(b"\n") + 1]
        if len(whole) < len(text):
            with self.path.open("r+b") as file:
                file.truncate(len(whole))
        for number, line in enumerate(whole.splitlines(), start=1):
            try:
                found: dict[str, Any] = json.loads(line)
                self._rows[found["key"]] = found["row"], found["timing"]
            except (ValueError, KeyError, TypeError) as error:
                raise TrundleError(
                    f"{self.path}: line {number} holds no episode ({error!r}): another --work, or --fresh"
                ) from error
