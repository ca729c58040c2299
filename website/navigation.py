"""Patterns in the navigation of `mkdocs.yml`."""

from __future__ import annotations

import fnmatch
from collections.abc import Iterable
from typing import Any

__all__ = ["expand"]


def expand(nav: list[Any], pages: Iterable[str]) -> list[Any]:
    """Return a navigation with its patterns replaced by pages.

    Parameters
    ----------
    nav : list
        Navigation as in `mkdocs.yml`. An entry `NAME?` is a page that may be missing. An entry with `*`
        is replaced by the pages of that folder that match and are not listed elsewhere.
    pages : iterable of str
        Paths of all pages, relative to the documentation.

    Returns
    -------
    list
        Navigation without patterns and missing pages; empty sections are left out.
    """
    existing = sorted(pages)
    listed = {entry.rstrip("?") for entry in leaves(nav)}
    unlisted = [page for page in existing if page not in listed]
    return replaced(nav, set(existing), unlisted)


def leaves(nav: Any) -> Iterable[str]:
    """Return all paths and patterns of a navigation."""
    if isinstance(nav, str):
        return [nav]
    children = nav.values() if isinstance(nav, dict) else nav
    return [leaf for child in children for leaf in leaves(child)]


def replaced(nav: list[Any], existing: set[str], unlisted: list[str]) -> list[Any]:
    """Return the entries of a section, with sections in it treated the same way."""
    entries: list[Any] = []
    for entry in nav:
        if isinstance(entry, dict):
            ((title, child),) = entry.items()
            inside = replaced(child, existing, unlisted) if isinstance(child, list) else child
            entries += [{title: inside}] if inside else []
        elif "*" in entry:
            entries += [page for page in unlisted if matches(page, entry)]
        elif not entry.endswith("?"):
            entries.append(entry)
        elif entry.rstrip("?") in existing:
            entries.append(entry.rstrip("?"))
    return entries


def matches(page: str, pattern: str) -> bool:
    """Return whether a page is in the folder of a pattern and matches it."""
    return page.count("/") == pattern.count("/") and fnmatch.fnmatchcase(page, pattern)
