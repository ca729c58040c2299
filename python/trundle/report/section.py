"""Structure that all sections of the page share."""

from __future__ import annotations

from collections.abc import Sequence

from trundle.report.markup import Child, Html, tag

__all__ = ["collapsible", "contents", "section"]


def section(identity: str, title: str, *children: Child) -> Html:
    """Return a section with a heading; `identity` is its anchor in the page."""
    name = f"{identity}-heading"
    return tag("section", tag("h2", title, id=name), *children, id=identity, aria_labelledby=name)


def collapsible(summary: str, *children: Child) -> Html:
    """Return an element that is collapsed at first."""
    return tag("details", tag("summary", summary), *children)


def contents(entries: Sequence[tuple[str, str]]) -> Html:
    """Return links to sections, given as (identity, name)."""
    links = [tag("a", name, href=f"#{identity}") for identity, name in entries]
    return tag("nav", links, aria_label="Contents")
