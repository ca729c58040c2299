"""Legends of line styles and shades. No two entries differ by colour alone."""

from __future__ import annotations

from collections.abc import Sequence

from trundle.report.markup import Html, tag

__all__ = ["legend", "side_entries"]

_AREAS = ("band", "window")


def legend(*entries: tuple[str, str]) -> Html:
    """Return a legend of (CSS class, text) entries."""
    return tag("p", [_swatch(style, text) for style, text in entries], class_="legend")


def side_entries(verb: str, curves: Sequence[object]) -> list[tuple[str, str]]:
    """Return the legend entries of recorded curves and of the existing curves before and after."""
    found = [side for side in ("before", "after") if any(getattr(each, side) is not None for each in curves)]
    entries = [(side, f"{verb} {side}" if len(found) > 1 else verb) for side in found]
    return [("recorded", "recorded"), *entries]


def _swatch(style: str, text: str) -> Html:
    shape = (
        tag("path", d="M1 0V12H33V0H1", class_=style)
        if style in _AREAS
        else tag("path", d="M1 6H33", class_=style)
    )
    return tag("span", tag("svg", shape, viewBox="0 0 34 12", aria_hidden="true"), f" {text}")
