"""The folder of a run: what is finished stays, what was under way when the run ended is done again.

The settings are written first and each episode's history last of what is the episode's, so that a folder
tells after any interruption what it holds.
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
    """Where a run is kept.

    Parameters
    ----------
    path : Path
        Made if it is not there.
    settings : dict
        Everything that the run depends on.

    Raises
    ------
    TrundleError
        If it holds something else, or a run of other settings.
    """

    def __init__(self, path: Path, settings: dict[str, Any]) -> None:
        self.path = path
        self._marker = path / "settings.json"
        text = json.dumps(settings, indent=1, sort_keys=True) + "\n"
        path.mkdir(parents=True, exist_ok=True)
        if self._marker.exists():
            if self._marker.read_text(encoding="utf-8") != text:
                raise TrundleError(
                    f"{path}: holds a run of other settings, or of another version; give another --out or "
                    "remove it"
                )
        elif any(not entry.name.endswith(PARTIAL_SUFFIX) for entry in path.iterdir()):
            raise TrundleError(f"{path}: is not empty and holds no run; give another --out")
        else:
            write_text(self._marker, text)
        for left in path.glob(f".page.html.*{PARTIAL_SUFFIX}"):
            left.unlink()

    def episode(self, number: int) -> Path:
        """Return the folder of an episode."""
        return self.path / f"episode_{number:02}"

    def history(self, number: int) -> History | None:
        """Return what is kept of an episode; None, and nothing of it, where it has not been finished."""
        file = self.episode(number) / "history.json"
        if not file.exists():
            shutil.rmtree(self.episode(number), ignore_errors=True)
            return None
        found: History = read_json(file)
        return found

    def keep(self, number: int, history: History) -> None:
        """Keep what happened in an episode: from now on it is finished."""
        self.episode(number).mkdir(exist_ok=True)
        write_text(self.episode(number) / "history.json", json.dumps(history) + "\n")

    def show(self, page: str) -> Path:
        """Write the page."""
        write_text(self.path / "page.html", page)
        return self.path / "page.html"
