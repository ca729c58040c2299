"""Cards: a title, labelled facts and a table, as text or as HTML."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from trundle.display.markup import card_html

__all__ = ["MAX_LINES", "MAX_WIDTH", "Card", "Displayed", "Table"]

MAX_LINES = 15
"""Maximum number of lines of a text representation."""
MAX_WIDTH = 100
"""Maximum number of characters in a line."""
MAX_CELL_WIDTH = 48
"""Maximum number of characters in a cell of a table."""


@dataclass(frozen=True)
class Table:
    """A table of formatted cells: the first column to the left, the others to the right.

    Attributes
    ----------
    heads : sequence of str
        Titles of the columns.
    rows : sequence of sequences of str
        Cells, as many per row as there are titles.
    """

    heads: Sequence[str]
    rows: Sequence[Sequence[str]]

    def lines(self, count: int) -> list[str]:
        """Return at most `count` aligned lines, titles included. The last one counts omitted rows."""
        cells = [[clip(cell, MAX_CELL_WIDTH) for cell in row] for row in (self.heads, *self.rows)]
        widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
        lines = [
            "  ".join(
                cell.ljust(width) if place == 0 else cell.rjust(width)
                for place, (cell, width) in enumerate(zip(row, widths, strict=True))
            )
            for row in cells
        ]
        return shorten(lines, count)


@dataclass(frozen=True)
class Card:
    """Content of a representation.

    Attributes
    ----------
    title : str
        Class and name of the object.
    facts : sequence of pairs of str
        Label and text.
    table : Table, optional
    """

    title: str
    facts: Sequence[tuple[str, str]] = ()
    table: Table | None = None

    def text(self) -> str:
        """Return at most `MAX_LINES` lines of at most `MAX_WIDTH` characters."""
        label_width = max((len(label) for label, _ in self.facts), default=0)
        facts = [f"  {label.ljust(label_width)}  {text}" for label, text in self.facts]
        lines = [f"<{self.title}>", *shorten(facts, MAX_LINES - 1)]
        if self.table is not None and self.table.rows and len(lines) + 2 <= MAX_LINES:
            lines += [f"  {line}" for line in self.table.lines(MAX_LINES - len(lines))]
        return "\n".join(clip(line, MAX_WIDTH) for line in lines)

    def html(self) -> str:
        """Return HTML for a notebook, with escaped text."""
        table = None if self.table is None else (self.table.heads, self.table.rows)
        return card_html(self.title, self.facts, table)


class Displayed:
    """Base of classes that are represented by a card."""

    __slots__ = ()

    def _card(self) -> Card:
        raise NotImplementedError

    def __repr__(self) -> str:
        """Return the card as text."""
        return self._card().text()

    def _repr_html_(self) -> str:
        """Return the card as HTML, for notebooks."""
        return self._card().html()


def clip(text: str, width: int) -> str:
    """Return a text on one line, cut to a width."""
    line = text.replace("\r", " ").replace("\n", " ")
    return line if len(line) <= width else line[: width - 1] + "…"


def shorten(lines: list[str], count: int) -> list[str]:
    """Return at most `count` lines; the last one counts the omitted ones."""
    if len(lines) <= count:
        return lines
    return [*lines[: count - 1], f"  … and {len(lines) - count + 1} more"]
