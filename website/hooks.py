"""Hooks of mkdocs: add the generated pages, expand the navigation, and check that nothing needs a network."""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files, InclusionLevel
from mkdocs.structure.pages import Page

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from website import api, commands, effects, environments
from website.links import ROOT, rewrite, root_pages, source_files
from website.navigation import expand
from website.offline import remote_resources, without_remote_scripts

RUST_DOCS = ROOT / "target" / "doc"
TUTORIALS = "<!-- tutorials -->"


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the generated pages and pictures, and expand the navigation."""
    documents = repository_documents()
    for path, content in generated(documents):
        if path not in files.src_uris:
            level = InclusionLevel.NOT_IN_NAV if path.startswith("source/") else InclusionLevel.UNDEFINED
            files.append(File.generated(config, path, content=content, inclusion=level))
    pages = [file.src_uri for file in files.documentation_pages()]
    config.nav = expand(config.nav or [], [page for page in pages if not page.startswith("source/")])
    return files


def repository_documents() -> dict[str, str]:
    """Return the hand-written documents of the site by path in the repository."""
    paths = [*(ROOT / "docs").rglob("*.md"), *(ROOT / name for name in root_pages())]
    return {path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8") for path in sorted(paths)}


def generated(documents: dict[str, str]) -> Iterator[tuple[str, str | bytes]]:
    """Yield path and content of each generated page and picture."""
    yield from ((page, rewrite(documents[origin], origin, page)) for origin, page in root_pages().items())
    yield from source_files(documents)
    yield from api.api_pages()
    yield "reference/command-line.md", commands.command_page()
    yield from effects.effect_pages()
    yield from environments.environment_pages()
    yield from environments.environment_pictures()


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Rewrite links that leave the documentation, and list the tutorials."""
    if page.file.generated_by is not None:
        return markdown
    origin = f"docs/{page.file.src_uri}"
    return rewrite(markdown, origin, page.file.src_uri).replace(TUTORIALS, tutorial_list(files))


def tutorial_list(files: Files) -> str:
    """Return links to the tutorials."""
    found = [
        file for file in files if file.src_uri.startswith("tutorials/") and file.src_uri.endswith(".ipynb")
    ]
    return "\n".join(f"- [{notebook_title(Path(str(file.abs_src_path)))}]({file.src_uri})" for file in found)


def notebook_title(path: Path) -> str:
    """Return the first heading of a notebook."""
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    lines = [line.strip() for cell in cells if cell["cell_type"] == "markdown" for line in cell["source"]]
    return next((line[2:] for line in lines if line.startswith("# ")), path.stem)


def on_post_page(output: str, page: Page, config: MkDocsConfig) -> str:
    """Remove the scripts that notebooks would load from other hosts: none of them needs those."""
    return without_remote_scripts(output) if page.file.src_uri.endswith(".ipynb") else output


def on_post_build(config: MkDocsConfig) -> None:
    """Add the documentation of the Rust crates, and fail if a page loads something from another host."""
    site = Path(config.site_dir)
    remote = [
        f"{path.relative_to(site)}: {url}"
        for path in sorted(site.rglob("*.html"))
        for url in remote_resources(path.read_text(encoding="utf-8"))
    ]
    if remote:
        raise PluginError("pages load from other hosts:\n  " + "\n  ".join(remote))
    if RUST_DOCS.is_dir():
        shutil.copytree(RUST_DOCS, site / "rust", dirs_exist_ok=True)
