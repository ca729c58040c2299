"""An HTML page from the Markdown that an experiment writes, in the style of the reports.

The parser knows only the Markdown of `prose/` and of `trundle.experiments.markdown`: headings, paragraphs,
lists, tables, fenced code, images, and inline code, emphasis and links.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from markupsafe import Markup, escape

from trundle.report.figures.canvas import Figure
from trundle.report.jinja import render_template
from trundle.report.wording import typeset

__all__ = ["Block", "Section", "inline", "render", "sections"]

_INLINE = re.compile(r"`([^`]+)`|\*\*(.+?)\*\*|\*(\S[^*]*?)\*|\[([^\]]+)\]\(([^)\s]+)\)")
_IMAGE = re.compile(r"!\[([^\]]*)\]\(([^)\s]+)\)")
_LOCAL_LINK = re.compile(r"(?!\w+:)[\w./-]+\.md(#.*)?$")
"""A link to another Markdown page, which is not next to the HTML page."""


@dataclass(frozen=True)
class Block:
    """Part of a section.

    Attributes
    ----------
    kind
        "heading", "text", "list", "table", "code" or "image".
    lines
        Content: one item, or one for each item of a list.
    head, rows
        Cells of a table.
    target
        Path of an image.
    """

    kind: str
    lines: tuple[Markup, ...] = ()
    head: tuple[Markup, ...] = ()
    rows: tuple[tuple[Markup, ...], ...] = ()
    target: str = ""


@dataclass
class Section:
    """A heading of the second level with its blocks; the first section has the page's title."""

    title: str
    identity: str
    blocks: list[Block] = field(default_factory=list)


def render(text: str, figures: Mapping[str, Sequence[Figure]], kicker: str) -> str:
    """Render a Markdown document as a page.

    Parameters
    ----------
    text
        The document; it begins with its title.
    figures
        Figures in place of each image, by its path. An image without figures is omitted.
    kicker
        Line above the title.

    Returns
    -------
    str
        The page. It needs no network and works without scripts.
    """
    first, *others = sections(text)
    return render_template(
        "trundle.report",
        "document.html",
        title=first.title,
        kicker=kicker,
        first=first,
        entries=[(one.identity, one.title) for one in others],
        sections=others,
        figures=figures,
    )


def sections(text: str) -> list[Section]:
    """Return the sections of a document; the first one has the title and the text below it."""
    found: list[Section] = []
    for chunk in re.split(r"\n{2,}", text.strip()):
        for part in _split_heading(chunk):
            level = re.match(r"(#{1,3}) (.*)$", part)
            if level and len(level[1]) < 3:
                found.append(Section(level[2], f"section-{len(found)}"))
            elif found:
                found[-1].blocks.append(_block(part))
    return found


def _split_heading(chunk: str) -> Iterator[str]:
    """Yield a heading line and the rest of a chunk separately."""
    first, _, rest = chunk.partition("\n")
    if first.startswith("#"):
        yield first
        if rest.strip():
            yield rest
    elif chunk.strip():
        yield chunk


def _block(chunk: str) -> Block:
    lines = chunk.split("\n")
    if chunk.startswith("```"):
        return Block("code", (Markup("\n").join(map(escape, lines[1:-1])),))
    if chunk.startswith("### "):
        return Block("heading", (inline(chunk[4:]),))
    if chunk.startswith("|"):
        head, _, *rows = ([inline(cell.strip()) for cell in line.strip("|").split(" | ")] for line in lines)
        return Block("table", head=tuple(head), rows=tuple(tuple(row) for row in rows))
    if chunk.startswith("- "):
        return Block("list", tuple(inline(item) for item in re.split(r"\n- ", chunk[2:])))
    image = _IMAGE.fullmatch(chunk)
    return Block("image", target=image[2]) if image else Block("text", (inline(chunk),))


def inline(text: str) -> Markup:
    """Return a line of Markdown as HTML."""
    parts, end = [], 0
    for match in _INLINE.finditer(text):
        parts.append(escape(typeset(text[end : match.start()])))
        parts.append(_inline_element(*match.groups()))
        end = match.end()
    return Markup("").join([*parts, escape(typeset(text[end:]))])


def _inline_element(
    code: str | None, strong: str | None, soft: str | None, linked: str | None, target: str | None
) -> Markup:
    if code is not None:
        return Markup("<code>{}</code>").format(code)
    if strong is not None:
        return Markup("<b>{}</b>").format(inline(strong))
    if soft is not None:
        return Markup("<em>{}</em>").format(inline(soft))
    if _LOCAL_LINK.match(target or ""):
        return inline(linked or "")
    return Markup('<a href="{}">{}</a>').format(target, inline(linked or ""))
