"""Fixtures for all tests."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import hypothesis
import pytest

# A deadline would make tests fail on a slow or busy machine.
hypothesis.settings.register_profile("trundle", deadline=None)
hypothesis.settings.load_profile("trundle")

RealData = Callable[[str], Path]


@pytest.fixture(scope="session")
def real_data() -> RealData:
    """Return the path of a real data set, by its name below `../shared/real`, or skip the test.

    The data are not part of this repository; docs/real-recordings.md lists their sources. TRUNDLE_REAL_DATA
    sets another folder.
    """
    default = Path(__file__).resolve().parents[2] / "shared" / "real"
    folder = Path(os.environ.get("TRUNDLE_REAL_DATA", default))

    def find(name: str) -> Path:
        path = folder / name
        if not path.exists():
            pytest.skip(f"real data not present: {path} (TRUNDLE_REAL_DATA names another folder)")
        return path

    return find
