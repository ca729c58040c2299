"""Clean recordings that tests corrupt."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any

import pytest

import trundle
from tests.record_prepare.table import TABLES, Table, metadata, tables

Corrupt = Callable[[dict[str, Any], TABLES], None]
Kinds = set[str]


@pytest.fixture(scope="session")
def clean() -> tuple[dict[str, Any], TABLES]:
    """Metadata and columns of a clean recording; copy before a change."""
    table = Table()
    return metadata(table), tables(table)


@pytest.fixture
def found(clean: tuple[dict[str, Any], TABLES]) -> Callable[[Corrupt], trundle.Findings]:
    """Return the findings about the clean recording after it was corrupted."""

    def check(corrupt: Corrupt) -> trundle.Findings:
        described, episodes = deepcopy(clean)
        corrupt(described, episodes)
        return trundle.check(trundle.Recording(described, episodes))

    return check
