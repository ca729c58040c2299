"""SVG elements by nested function calls. Strings that are not `Markup` are escaped.

Templates make the HTML. Python draws the figures, because nearly every attribute is a computed coordinate.
"""

from __future__ import annotations

from collections.abc import Iterable

from markupsafe import Markup, escape

__all__ = ["Child", "Markup", "format_number", "join", "tag"]

Child = str | None | Iterable["Child"]
_EMPTY_ELEMENTS = frozenset({"circle", "ellipse", "line", "path", "polygon", "polyline", "rect"})


def tag(name: str, *children: Child, **attributes: str | float | None) -> Markup:
    """Return an element.

    Parameters
    ----------
    name
        Element name.
    children
        `Markup` is inserted unchanged, other strings are escaped, None is omitted, iterables are flattened.
    attributes
        `class_` loses its underscore, other underscores become hyphens. None is omitted.
        Numbers are rounded to hundredths.
    """
    head = name + "".join(_attribute(key, value) for key, value in attributes.items() if value is not None)
    if name in _EMPTY_ELEMENTS:
        return Markup(f"<{head}/>")
    return Markup(f"<{head}>{join(children)}</{name}>")


def join(children: Iterable[Child]) -> Markup:
    """Return the concatenated children; strings that are not `Markup` are escaped."""
    return Markup("".join(_text(child) for child in children))


def _text(child: Child) -> str:
    if child is None:
        return ""
    return escape(child) if isinstance(child, str) else join(child)


def _attribute(key: str, value: str | float) -> str:
    name = "class" if key == "class_" else key.replace("_", "-")
    return f' {name}="{escape(value) if isinstance(value, str) else format_number(value)}"'


def format_number(value: float) -> str:
    """Format a coordinate: rounded to hundredths, without trailing zeros or negative zero."""
    text = f"{value:.2f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
