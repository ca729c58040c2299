"""ARCHITECTURE.md names every file or its folder."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CRATES = (
    "env/model",
    "env/record",
    "env/sim",
    *(f"adaptive/{path.name}" for path in (ROOT / "adaptive").iterdir()),
)
PACKAGES = (
    "python/trundle",
    "python/trundle/mechanism",
    "python/trundle/plots",
    "python/trundle/experiments",
)
UNLISTED = {"lib", "tests", "__init__", "__main__", "__pycache__", "py"}


def section(name: str) -> str:
    """Return the section on a crate or package."""
    text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    return next(part for part in re.split(r"^### ", text, flags=re.M) if part.startswith(f"`{name}`"))


def listed(name: str) -> set[str]:
    """Return the names in the first column of the tables of a section."""
    cells = re.findall(r"^\| ([^|]*)\|", section(name), flags=re.M)
    return {found for cell in cells for found in re.findall(r"`(\w+)/?`", cell)}


def stems(folder: Path) -> Iterator[str]:
    """Yield the names of the modules in a folder."""
    for path in folder.iterdir():
        stem = path.name.partition(".")[0]
        if stem not in UNLISTED:
            yield stem


@pytest.mark.parametrize("name", CRATES)
def test_the_page_lists_the_modules_of_a_crate(name: str) -> None:
    assert listed(name) == set(stems(ROOT / name / "src"))


@pytest.mark.parametrize("name", PACKAGES)
def test_the_page_lists_the_modules_of_a_package(name: str) -> None:
    assert listed(name) == set(stems(ROOT / name))
