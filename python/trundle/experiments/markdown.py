"""Parts of the Markdown pages that experiments write."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from importlib.resources import files

__all__ = ["prose", "table"]


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def prose(experiment: str, name: str, /, **values: object) -> str:
    """Return the text `prose/NAME.md` of an experiment, with values in place of its braces."""
    file = files(f"trundle.experiments.{experiment}").joinpath("prose", f"{name}.md")
    return file.read_text(encoding="utf-8").format(**values).strip()
