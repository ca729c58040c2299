"""What line styles and shades mean; no two differ by colour alone."""

from __future__ import annotations

from collections.abc import Sequence

from trundle.report.markup import Html, tag

__all__ = ["legend", "sides"]

_AREAS = ("band", "window")


def legend(*entries: tuple[str, str]) -> Html:
    """Return the meaning of styles, each given as its class and words."""
    return tag("p", [_swatch(style, words) for style, words in entries], class_="legend")


def sides(verb: str, curves: Sequence[object]) -> list[tuple[str, str]]:
    """Return the entries for recorded curves, and for those of before and after that there are."""
    found = [side for side in ("before", "after") if any(getattr(each, side) is not None for each in curves)]
    words = [(side, f"{verb} {side}" if len(found) > 1 else verb) for side in found]
    return [("recorded", "recorded"), *words]


def _swatch(style: str, words: str) -> Html:
    shape = (
        tag("path", d="M1 0V12H33V0H1", class_=style)
        if style in _AREAS
        else tag("path", d="M1 6H33", class_=style)
    )
    return tag("span", tag("svg", shape, viewBox="0 0 34 12", aria_hidden="true"), f" {words}")
