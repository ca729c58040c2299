"""Results of single effects, read from the committed pages of the blind benchmarks."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

__all__ = ["DETECTION_PAGE", "Detection", "correct_answers", "detection"]

DOCS = Path(__file__).resolve().parents[1] / "docs"
DETECTION_PAGE = "proof_further.md"
PAGES = {
    "proof.md": "first benchmark",
    "wide.md": "wide benchmark, reported range",
    "wide_smoke.md": "wide benchmark, tuning range",
}
"""Pages with a table of single effects, and their names."""

Rows = list[dict[str, str]]


@dataclass(frozen=True)
class Detection:
    """How often an effect is named when it is smaller.

    Attributes
    ----------
    counts : dict of str to str
        Named recordings, such as "3/3", by size relative to the drawn one.
    smallest : str
        Smallest size that is named in 95 %, with the values of that size.
    """

    counts: dict[str, str]
    smallest: str


def detection(effect: str) -> Detection | None:
    """Return the detection limit of an effect, or None if it was not measured."""
    for row in table(DETECTION_PAGE, "Detection limits"):
        if row.pop("effect") == f"`{effect}`":
            return Detection(row, row.pop("smallest size named in 95 %"))
    return None


def correct_answers(effect: str) -> list[tuple[str, str, str]]:
    """Return page, name of the benchmark and share of correct answers where an effect was hidden alone."""
    return [
        (page, name, row["correct"])
        for page, name in PAGES.items()
        for row in table(page, "Single effects")
        if row["hidden effect"] == f"`{effect}`"
    ]


def table(page: str, heading: str) -> Rows:
    """Return the first table below a heading of a page, as one dictionary per row."""
    head, *rows = cells(page, heading)
    return [dict(zip(head, row, strict=True)) for row in rows]


@cache
def cells(page: str, heading: str) -> tuple[tuple[str, ...], ...]:
    """Return the cells of the first table below a heading; the first row is its head."""
    _, _, text = (DOCS / page).read_text(encoding="utf-8").partition(f"\n## {heading}\n")
    lines = text.partition("\n## ")[0].splitlines()
    start = next((k for k, line in enumerate(lines) if line.startswith("|")), None)
    if start is None:
        raise ValueError(f"docs/{page}: no table below the heading {heading!r}")
    rows = []
    for line in lines[start:]:
        if not line.startswith("|"):
            break
        rows.append(tuple(cell.strip() for cell in line.strip().strip("|").split("|")))
    return (rows[0], *rows[2:])
