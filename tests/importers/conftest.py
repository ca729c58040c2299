"""Fixtures for importers."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import tomli_w

from trundle.importers import Imported, read

Import = Callable[[Path, str, dict[str, Any]], Imported]


@pytest.fixture
def imported(tmp_path: Path) -> Import:
    """Return a function that imports with a map given as a dictionary."""

    def run(source: Path, layout: str, settings: dict[str, Any]) -> Imported:
        path = tmp_path / "map.toml"
        path.write_text(tomli_w.dumps(settings))
        return read(source, layout, path)

    return run
