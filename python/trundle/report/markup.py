"""HTML and SVG as nested calls: what is not markup already is escaped, so no name can break the page."""

from __future__ import annotations

import html
import re
from collections.abc import Iterable

__all__ = ["Child", "Html", "join", "tag"]

_VOID = frozenset({"meta", "br", "col"})
_FORBIDDEN = re.compile("[\\x00-\\x08\\x0b-\\x1f\\x7f-\\x9f\\ud800-\\udfff]")
_SELF_CLOSING = frozenset({"circle", "ellipse", "line", "path", "polygon", "rect"})


class Html(str):
    """Text that is markup; every other string is escaped when it enters a tag."""

    __slots__ = ()


Child = str | None | Iterable["Child"]
Attribute = str | float | None


def tag(name: str, *children: Child, **attributes: Attribute) -> Html:
    """One element.

    Parameters
    ----------
    name
        Element name.
    children
        `Html` enters as it is, other strings are escaped, None is left out, iterables are flattened.
    attributes
        `class_` and `name_` lose their underscore, other underscores become hyphens; None is left out;
        numbers are rounded to hundredths, which is finer than any screen shows.
    """
    head = name + "".join(_attribute(key, value) for key, value in attributes.items())
    if name in _VOID:
        return Html(f"<{head}>")
    if name in _SELF_CLOSING and not children:
        return Html(f"<{head}/>")
    return Html(f"<{head}>{join(children)}</{name}>")


def join(children: Iterable[Child]) -> Html:
    """Children one after the other, escaped where they are not markup."""
    return Html("".join(_text(child) for child in children))


def _text(child: Child) -> str:
    if child is None:
        return ""
    if isinstance(child, Html):
        return child
    if isinstance(child, str):
        return html.escape(_visible(child), quote=False)
    return join(child)


def _visible(text: str) -> str:
    """Text without the control characters that a page may not hold."""
    return _FORBIDDEN.sub("\N{REPLACEMENT CHARACTER}", text)


def _attribute(key: str, value: Attribute) -> str:
    if value is None:
        return ""
    name = "class" if key == "class_" else "name" if key == "name_" else key.replace("_", "-")
    text = html.escape(_visible(value)) if isinstance(value, str) else number(value)
    return f' {name}="{text}"'


def number(value: float) -> str:
    """Return a coordinate, rounded to hundredths, without trailing zeros or a negative zero."""
    text = f"{value:.2f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
