"""The sentences of the document, one file a section, with names in braces for what the results say."""

from __future__ import annotations

from importlib.resources import files

__all__ = ["fill"]


def fill(name: str, **values: object) -> str:
    """Return a section's text with its values in place.

    Parameters
    ----------
    name : str
        Which section: a file of `prose/`, without `.md`.
    values : object
        What stands for each name in braces.
    """
    text = files("trundle.paper").joinpath("prose", f"{name}.md").read_text(encoding="utf-8")
    return text.format(**values)
