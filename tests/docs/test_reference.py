"""Every public name is in the reference of the site, and names of public modules have examples."""

from __future__ import annotations

import importlib
import inspect
from typing import Any

import pytest

from trundle import _native
from website import api


def public_objects() -> dict[str, Any]:
    """Return the public functions and classes by name, each under one name."""
    found: dict[int, tuple[str, Any]] = {}
    for module in ["trundle", *(f"trundle.{name}" for name in api.public_modules())]:
        loaded = importlib.import_module(module)
        for name in loaded.__all__:
            value = getattr(loaded, name)
            if inspect.isclass(value) or inspect.isroutine(value):
                found.setdefault(id(value), (f"{module}.{name}", value))
    return dict(found.values())


def compiled(name: str) -> bool:
    """Return whether the compiled module defines a name."""
    return getattr(_native, name.rpartition(".")[2], None) is PUBLIC[name]


PUBLIC = public_objects()
DOCUMENTED = [name for names in api.documented_names().values() for name in names]


@pytest.mark.parametrize("name", PUBLIC)
def test_a_public_name_is_in_the_reference(name: str) -> None:
    assert DOCUMENTED.count(name) == 1
    pages = dict(api.api_pages())
    assert sum(f"\n::: {name}\n" in page for page in pages.values()) == 1
    assert f"[`{name}`]" in pages["reference/python/index.md"]


@pytest.mark.parametrize("name", [name for name in PUBLIC if name.count(".") > 1 and not compiled(name)])
def test_a_name_of_a_public_module_has_an_example(name: str) -> None:
    assert ">>> " in (inspect.getdoc(PUBLIC[name]) or ""), f"{name}: no example in its docstring"


def test_every_public_module_has_a_page() -> None:
    pages = {path for path, _ in api.api_pages()}
    assert {f"reference/python/{name}.md" for name in api.public_modules()} <= pages
    assert {"envs", "objects", "importers", "export", "baselines", "report"} <= set(api.public_modules())
