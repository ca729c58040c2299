"""The folder of a run. Finished episodes are kept; an unfinished episode is run again.

The settings are written first, and each episode's history after its other files, so that the state is clear
after any interruption.
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

from trundle.atomic import PARTIAL_SUFFIX, read_json, write_text
from trundle.recording import TrundleError

__all__ = ["Folder"]

History = dict[str, Any]


class Folder:
    """The folder of a run.

    Parameters
    ----------
    path : Path
        Created if it does not exist.
    settings : dict
        Everything that the run depends on.

    Raises
    ------
    TrundleError
        If it holds other files, or a run with other settings.
    """

    def __init__(self, path: Path, settings: dict[str, Any]) -> None:
        self.path = path
        self._marker = path / "settings.json"
        text = json.dumps(settings, indent=1, sort_keys=True) + "\n"
        path.mkdir(parents=True, exist_ok=True)
        if self._marker.exists():
            if self._marker.read_text(encoding="utf-8") != text:
                raise TrundleError(
                    f"{path}: holds a run with other settings or of another version: choose another --out, "
                    "or remove the folder"
                )
        elif any(not entry.name.endswith(PARTIAL_SUFFIX) for entry in path.iterdir()):
            raise TrundleError(f"{path}: the folder is not empty and holds no run: choose another --out")
        else:
            write_text(self._marker, text)
        for left in path.glob(f".page.html.*{PARTIAL_SUFFIX}"):
            left.unlink()

    def episode(self, number: int) -> Path:
        """Return the folder of an episode."""
        return self.path / f"episode_{number:02}"

    def history(self, number: int) -> History | None:
        """Return the history of an episode; delete its folder and return None if it is not finished."""
        file = self.episode(number) / "history.json"
        if not file.exists():
            shutil.rmtree(self.episode(number), ignore_errors=True)
            return None
        found: History = read_json(file)
        return found

    def keep(self, number: int, history: History) -> None:
        """Write the history of an episode, which marks it as finished."""
        self.episode(number).mkdir(exist_ok=True)
        write_text(self.episode(number) / "history.json", json.dumps(history) + "\n")

    def show(self, page: str) -> Path:
        """Write the page."""
        write_text(self.path / "page.html", page)
        return self.path / "page.html"
