"""Links that lead out of the documentation: to pages of the root, and to files of the repository."""

from __future__ import annotations

import posixpath
import re
from collections.abc import Iterator
from pathlib import Path

__all__ = ["ROOT", "listing_path", "rewrite", "root_pages", "source_files"]

ROOT = Path(__file__).resolve().parents[1]
LINK = re.compile(r"(\]\()([^)\s]+)(\))")
HOME = "index.md"
LANGUAGES = {".py": "python", ".rs": "rust", ".toml": "toml", ".json": "json", ".sh": "bash"}


def root_pages() -> dict[str, str]:
    """Return the documents of the repository's root that are pages of the site, with their paths in it."""
    names = ("ARCHITECTURE", "CHANGELOG", "CODE_OF_CONDUCT", "CONTRIBUTING", "SECURITY")
    existing = [name for name in names if (ROOT / f"{name}.md").exists()]
    return {f"{name}.md": f"project/{name.lower().replace('_', '-')}.md" for name in existing}


def rewrite(text: str, origin: str, page: str) -> str:
    """Return a document whose links lead to pages of the site.

    Parameters
    ----------
    text : str
        Markdown.
    origin : str
        Path of the document in the repository; its links are relative to it.
    page : str
        Path of the page in the site.
    """

    def replace(found: re.Match[str]) -> str:
        target = destination(found[2], origin)
        return found[0] if target is None else f"{found[1]}{relative(target, page)}{found[3]}"

    return LINK.sub(replace, text)


def destination(link: str, origin: str) -> str | None:
    """Return the path in the site to which a link leads; None for links that stay as they are."""
    if "://" in link or link.startswith(("#", "mailto:")):
        return None
    path, mark, anchor = link.partition("#")
    target = posixpath.normpath(posixpath.join(posixpath.dirname(origin), path))
    if target in root_pages():
        target = root_pages()[target]
    elif target == "README.md":
        target = HOME
    elif target.startswith("docs/") and not (ROOT / target).is_dir():
        target = target.removeprefix("docs/")
    else:
        target = listing_path(target)
    return f"{target}{mark}{anchor}"


def relative(target: str, page: str) -> str:
    """Return a path in the site relative to a page."""
    return posixpath.relpath(target, posixpath.dirname(page) or ".")


def listing_path(source: str) -> str:
    """Return the page that shows a file or folder of the repository."""
    return f"source/{source}.md"


def source_files(documents: dict[str, str]) -> Iterator[tuple[str, str]]:
    """Yield path and text of a page for each file or folder of the repository that documents link to.

    Parameters
    ----------
    documents : dict of str to str
        Markdown by path in the repository.
    """
    linked = {
        target.partition("#")[0]
        for origin, text in documents.items()
        for _, link, _ in LINK.findall(text)
        if (target := destination(link, origin)) is not None
    }
    for page in sorted(linked):
        if page.startswith("source/"):
            yield page, listing(page.removeprefix("source/").removesuffix(".md"))


def listing(source: str) -> str:
    """Return a page with the content of a file, or the names in a folder."""
    path = ROOT / source
    head = f"---\nsearch:\n  exclude: true\n---\n\n# {path.name}\n\n`{source}` in the repository.\n\n"
    if path.is_dir():
        return head + "\n".join(f"- `{child.name}`" for child in sorted(path.iterdir())) + "\n"
    language = LANGUAGES.get(path.suffix, "text")
    return f"{head}````{language}\n{path.read_text(encoding='utf-8')}\n````\n"
