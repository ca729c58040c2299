"""Map files: what they hold is read into dataclasses by `trundle.settings`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from trundle.recording import TrundleError
from trundle.settings import SettingsError, parse, typed

__all__ = ["MapError", "load", "typed"]

MapError = SettingsError
"""A map file says something that is not understood; the message names the key and the remedy."""


def load(path: Path) -> dict[str, Any]:
    """Parse a TOML file, saying which file and line are wrong where it is none."""
    try:
        return parse(path)
    except TrundleError as error:
        raise MapError(str(error)) from error
