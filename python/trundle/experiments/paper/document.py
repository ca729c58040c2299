"""Update `docs/paper.md`: each experiment rewrites the lines between its own two markers."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from trundle.atomic import write_text
from trundle.recording import TrundleError

__all__ = ["replace_section"]

HEAD = """# The paper's experiments

The evaluation of Scholz, Levihn, Isbell, Christensen and Stilman, "Learning Non-Holonomic Object Models for
Mobile Manipulation", section V, done again in simulation, and what that paper left open. Every section is
written by its command from the results in [paper/](paper/); `trundle paper all` writes all of them.
"""


def replace_section(path: Path, name: str, text: str, order: Sequence[str]) -> None:
    """Put `text` between the markers of `name`; create a missing document or missing markers.

    Parameters
    ----------
    path : Path
        The document.
    name : str
        Name of the section.
    text : str
        Its new content.
    order : sequence of str
        All sections in order, for the position of a new one.
    """
    whole = path.read_text(encoding="utf-8") if path.exists() else HEAD
    begin, end = markers(name)
    if begin not in whole:
        whole = insert_markers(whole, name, order)
    before, rest = whole.split(begin, 1)
    if end not in rest:
        raise TrundleError(
            f"{path}: the line {begin!r} is not followed by {end!r}: restore that line, or remove both"
        )
    after = rest.split(end, 1)[1]
    write_text(path, f"{before}{begin}\n\n{text.strip()}\n\n{end}{after}")


def markers(name: str) -> tuple[str, str]:
    """Return the lines before and after a section."""
    return f"<!-- trundle paper {name} -->", f"<!-- end of {name} -->"


def insert_markers(whole: str, name: str, order: Sequence[str]) -> str:
    """Return the document with an empty section for `name` at its position."""
    empty = "\n".join(markers(name)) + "\n"
    later = [markers(other)[0] for other in order[list(order).index(name) + 1 :]]
    for marker in later:
        if marker in whole:
            return whole.replace(marker, f"{empty}\n{marker}", 1)
    return f"{whole.rstrip()}\n\n{empty}"
