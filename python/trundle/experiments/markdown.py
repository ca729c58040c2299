"""Parts of the Markdown pages that experiments write."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from importlib.resources import files
from pathlib import Path

from trundle.atomic import write_text
from trundle.recording import TrundleError

__all__ = ["prose", "replace_section", "table"]


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def prose(experiment: str, name: str, /, **values: object) -> str:
    """Return the text `prose/NAME.md` of an experiment, with values in place of its braces."""
    file = files(f"trundle.experiments.{experiment}").joinpath("prose", f"{name}.md")
    return file.read_text(encoding="utf-8").format(**values).strip()


def replace_section(path: Path, name: str, text: str, order: Sequence[str], head: str) -> None:
    """Put a text between the markers `<!-- trundle NAME -->` and `<!-- end of NAME -->` of a page.

    Parameters
    ----------
    path : Path
        The page. A missing page begins with `head`, a missing marker is added.
    name : str
        Name of the section.
    text : str
        Its new content.
    order : sequence of str
        All sections in order, for the position of a new one.
    head : str
        Text before the sections.
    """
    page = path.read_text(encoding="utf-8") if path.exists() else head
    begin, end = markers(name)
    if begin not in page:
        later = [markers(other)[0] for other in order[order.index(name) + 1 :]]
        before, marker, after = page.partition(next((one for one in later if one in page), "\0"))
        page = f"{before.rstrip()}\n\n{begin}\n{end}\n" + (f"\n{marker}{after}" if marker else "")
    before, _, rest = page.partition(begin)
    _, found, after = rest.partition(end)
    if not found:
        raise TrundleError(
            f"{path}: the line {begin!r} is not followed by {end!r}: restore that line, or remove both"
        )
    write_text(path, f"{before}{begin}\n\n{text.strip()}\n\n{end}{after}")


def markers(name: str) -> tuple[str, str]:
    """Return the lines before and after a section."""
    return f"<!-- trundle {name} -->", f"<!-- end of {name.rpartition(' ')[2]} -->"
