"""HTML and SVG by nested function calls. Every string that is not `Html` is escaped."""

from __future__ import annotations

import html
import re
from collections.abc import Iterable

__all__ = ["Child", "Html", "join", "tag"]

_VOID = frozenset({"meta", "br", "col"})
_FORBIDDEN = re.compile("[\\x00-\\x08\\x0b-\\x1f\\x7f-\\x9f\\ud800-\\udfff]")
_SELF_CLOSING = frozenset({"circle", "ellipse", "line", "path", "polygon", "rect"})


class Html(str):
    """A string of markup, which `tag` and `join` do not escape."""

    __slots__ = ()


Child = str | None | Iterable["Child"]
Attribute = str | float | None


def tag(name: str, *children: Child, **attributes: Attribute) -> Html:
    """Return an element.

    Parameters
    ----------
    name
        Element name.
    children
        `Html` is inserted unchanged, other strings are escaped, None is omitted, iterables are flattened.
    attributes
        `class_` and `name_` lose their underscore, other underscores become hyphens. None is omitted.
        Numbers are rounded to hundredths.
    """
    head = name + "".join(_attribute(key, value) for key, value in attributes.items())
    if name in _VOID:
        return Html(f"<{head}>")
    if name in _SELF_CLOSING and not children:
        return Html(f"<{head}/>")
    return Html(f"<{head}>{join(children)}</{name}>")


def join(children: Iterable[Child]) -> Html:
    """Return the concatenated children; strings that are not `Html` are escaped."""
    return Html("".join(_text(child) for child in children))


def _text(child: Child) -> str:
    if child is None:
        return ""
    if isinstance(child, Html):
        return child
    if isinstance(child, str):
        return html.escape(_replace_controls(child), quote=False)
    return join(child)


def _replace_controls(text: str) -> str:
    """Replace the control characters that HTML forbids."""
    return _FORBIDDEN.sub("\N{REPLACEMENT CHARACTER}", text)


def _attribute(key: str, value: Attribute) -> str:
    if value is None:
        return ""
    name = "class" if key == "class_" else "name" if key == "name_" else key.replace("_", "-")
    text = html.escape(_replace_controls(value)) if isinstance(value, str) else format_number(value)
    return f' {name}="{text}"'


def format_number(value: float) -> str:
    """Format a coordinate: rounded to hundredths, without trailing zeros or negative zero."""
    text = f"{value:.2f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
