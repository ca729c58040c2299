"""Panels of several episodes: the first few are open, the others collapsed."""

from __future__ import annotations

from collections.abc import Sequence

from trundle.report.markup import Html, tag
from trundle.report.section import collapsible

__all__ = ["OPEN_PANELS", "drawn_note", "gallery"]

OPEN_PANELS = 3
"""Number of panels that are not collapsed."""


def gallery(figures: Sequence[Html], name: str = "episodes") -> Html:
    """Return the panels, of which the first `OPEN_PANELS` are open; `name` is what the others are called."""
    first, rest = figures[:OPEN_PANELS], figures[OPEN_PANELS:]
    more = collapsible(f"{len(rest)} more {name}", tag("div", rest, class_="panels")) if rest else None
    return tag("div", tag("div", first, class_="panels"), more, class_="gallery")


def drawn_note(shown: int, total: int) -> str | None:
    """Return a note on how many episodes are drawn; None if all are."""
    return None if shown == total else f"{shown} of {total} episodes are shown."
