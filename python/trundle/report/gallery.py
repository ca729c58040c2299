"""Panels of several episodes: the first few open, the others behind a fold."""

from __future__ import annotations

from collections.abc import Sequence

from trundle.report.markup import Html, tag
from trundle.report.section import fold

__all__ = ["OPEN", "gallery", "of"]

OPEN = 3


def gallery(figures: Sequence[Html], name: str = "episodes") -> Html:
    """Return the first few open, the others behind a fold."""
    first, rest = figures[:OPEN], figures[OPEN:]
    more = fold(f"{len(rest)} more {name}", tag("div", rest, class_="panels")) if rest else None
    return tag("div", tag("div", first, class_="panels"), more, class_="gallery")


def of(shown: int, total: int) -> str | None:
    """Return how many episodes are drawn, unless all are."""
    return None if shown == total else f"{shown} of {total} episodes are drawn."
