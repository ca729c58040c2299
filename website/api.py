"""Pages of the Python API: one for each public module."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Iterator
from types import ModuleType

import trundle

__all__ = ["api_pages", "documented_names", "public_modules"]

SUBMODULES = ("export", "importers", "mechanism", "plots", "report")
"""Public modules that `import trundle` does not load."""


def api_pages() -> Iterator[tuple[str, str]]:
    """Yield path and text of the list of names and of the page of each module."""
    pages = documented_names()
    yield "reference/python/index.md", index_page(pages)
    for module, names in pages.items():
        yield f"reference/python/{slug(module)}.md", module_page(module, names)


def public_modules() -> list[str]:
    """Return the public submodules: those in `trundle.__all__`, and those to import separately."""
    loaded = [name for name in trundle.__all__ if isinstance(getattr(trundle, name), ModuleType)]
    existing = {module.name for module in pkgutil.iter_modules(trundle.__path__)}
    return sorted({*loaded, *existing.intersection(SUBMODULES)})


def documented_names() -> dict[str, list[str]]:
    """Return the public names by the module whose page documents them.

    A name of `trundle` is documented with the module that defines it, under its short name.
    """
    exported = {name: getattr(trundle, name) for name in trundle.__all__}
    top = {name: value for name, value in exported.items() if not isinstance(value, (ModuleType, str))}
    pages: dict[str, list[str]] = {}
    for module in sorted(module.name for module in pkgutil.iter_modules(trundle.__path__)):
        if module.startswith("_") or module in public_modules():
            continue
        found = [name for name in own_names(f"trundle.{module}", top) if name not in flat(pages)]
        if found:
            pages[f"trundle.{module}"] = [f"trundle.{name}" for name in found]
    others = [f"trundle.{name}" for name in top if f"trundle.{name}" not in flat(pages)]
    if others:
        pages["trundle"] = others
    for module in public_modules():
        loaded = importlib.import_module(f"trundle.{module}")
        again = own_names(f"trundle.{module}", top)
        pages[f"trundle.{module}"] = [
            f"trundle.{module}.{name}" for name in loaded.__all__ if name not in again
        ]
    return pages


def own_names(module: str, top: dict[str, object]) -> list[str]:
    """Return those names of `trundle` that a module exports."""
    loaded = importlib.import_module(module)
    exported = getattr(loaded, "__all__", [])
    return [name for name, value in top.items() if name in exported and getattr(loaded, name) is value]


def flat(pages: dict[str, list[str]]) -> set[str]:
    """Return all names of all pages."""
    return {name for names in pages.values() for name in names}


def slug(module: str) -> str:
    """Return the name of the page of a module."""
    return module.rpartition(".")[2]


def index_page(pages: dict[str, list[str]]) -> str:
    """Return the list of all public names."""
    parts = [
        "# Python",
        "Everything below is public. Other names, and modules that begin with an underscore, may change.",
    ]
    for module, names in pages.items():
        rows = "\n".join(
            f"| [`{name}`]({slug(module)}.md#{name}) | {first_sentence(name)} |" for name in names
        )
        parts.append(f"## {title(module)}\n\n| name | purpose |\n| --- | --- |\n{rows}")
    return "\n\n".join(parts) + "\n"


def module_page(module: str, names: list[str]) -> str:
    """Return the page of a module: its docstring and the directives of its names."""
    text = inspect.getdoc(importlib.import_module(module)) or ""
    first = text.partition("\n\n")[0]
    parts = [
        f"# {title(module)}",
        *([] if module == "trundle" else [first]),
        *(f"::: {name}" for name in names),
    ]
    return "\n\n".join(parts) + "\n"


def title(module: str) -> str:
    """Return the title of the page of a module."""
    return "Other names of trundle" if module == "trundle" else module


def first_sentence(name: str) -> str:
    """Return the first paragraph of the docstring of a name; constants have none."""
    path, _, attribute = name.rpartition(".")
    found = getattr(importlib.import_module(path), attribute)
    if not (inspect.isclass(found) or callable(found)):
        return "A constant."
    paragraph = (inspect.getdoc(found) or "").partition("\n\n")[0]
    return paragraph.replace("\n", " ").replace("|", "\\|")
