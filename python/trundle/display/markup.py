"""HTML of cards: compact tables without colours of their own, for light and dark notebooks."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

__all__ = ["MAX_ROWS", "card_html"]

MAX_ROWS = 40
"""Maximum number of rows of a table."""

_LINE = "border:0;border-top:1px solid rgba(128,128,128,0.35)"
_CELL = f"padding:2px 10px 2px 0;background:none;color:inherit;vertical-align:top;{_LINE}"
_TABLE = "border-collapse:collapse;border:0;margin:6px 0;font-size:90%;font-variant-numeric:tabular-nums"

Cells = Sequence[Sequence[str]]


def card_html(title: str, facts: Sequence[tuple[str, str]], table: tuple[Sequence[str], Cells] | None) -> str:
    """Return the HTML of a card; all text is escaped."""
    parts = [f'<div style="color:inherit;max-width:60em"><strong>{escape(title)}</strong>']
    if facts:
        rows = "".join(_row(fact, ("th", "td"), ("left", "left")) for fact in facts[:MAX_ROWS])
        rows += _omitted(len(facts), 2)
        parts.append(f'<table style="{_TABLE}"><tbody>{rows}</tbody></table>')
    if table is not None and table[1]:
        parts.append(_table(*table))
    return "".join([*parts, "</div>"])


def _table(heads: Sequence[str], rows: Cells) -> str:
    sides = ("left", *["right"] * (len(heads) - 1))
    head = _row(heads, ["th"] * len(heads), sides)
    body = "".join(_row(row, ("th", *["td"] * (len(heads) - 1)), sides) for row in rows[:MAX_ROWS])
    body += _omitted(len(rows), len(heads))
    return f'<table style="{_TABLE}"><thead>{head}</thead><tbody>{body}</tbody></table>'


def _omitted(count: int, columns: int) -> str:
    """Return a row with the number of omitted rows; an empty string if all rows are shown."""
    if count <= MAX_ROWS:
        return ""
    return f'<tr><td style="{_CELL}" colspan="{columns}">… and {count - MAX_ROWS} more</td></tr>'


def _row(cells: Sequence[str], tags: Sequence[str], sides: Sequence[str]) -> str:
    inner = "".join(
        f'<{tag} style="{_CELL};text-align:{side}">{escape(cell)}</{tag}>'
        for cell, tag, side in zip(cells, tags, sides, strict=True)
    )
    return f'<tr style="background:none">{inner}</tr>'
