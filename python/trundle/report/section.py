"""The frame that every section of the page shares."""

from __future__ import annotations

from collections.abc import Sequence

from trundle.report.markup import Child, Html, tag

__all__ = ["contents", "fold", "section"]


def section(identity: str, title: str, *children: Child) -> Html:
    """Return a section under its title; `identity` is its address in the page."""
    name = f"{identity}-heading"
    return tag("section", tag("h2", title, id=name), *children, id=identity, aria_labelledby=name)


def fold(summary: str, *children: Child) -> Html:
    """Return what only some readers want, closed at first."""
    return tag("details", tag("summary", summary), *children)


def contents(entries: Sequence[tuple[str, str]]) -> Html:
    """Return links to sections, each given as identity and name."""
    links = [tag("a", name, href=f"#{identity}") for identity, name in entries]
    return tag("nav", links, aria_label="Contents")
