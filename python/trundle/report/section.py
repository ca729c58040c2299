"""The frame that every section of the page shares."""

from __future__ import annotations

from trundle.report.markup import Child, Html, tag

__all__ = ["section"]


def section(title: str, *children: Child) -> Html:
    """Return a section under its title."""
    return tag("section", tag("h2", title), *children)
