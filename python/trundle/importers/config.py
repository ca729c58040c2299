"""Map files, which `trundle.settings` parses into dataclasses."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from trundle.recording import TrundleError
from trundle.settings import SettingsError, parse, typed

__all__ = ["MapError", "load", "typed"]

MapError = SettingsError
"""An invalid setting in a map file; the message names the key and the expected value."""


def load(path: Path) -> dict[str, Any]:
    """Parse a TOML file; the error for invalid TOML names the file and the line."""
    try:
        return parse(path)
    except TrundleError as error:
        raise MapError(str(error)) from error
