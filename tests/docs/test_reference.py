"""Every public name is in the reference of the site, and its docstring has an example that works."""

from __future__ import annotations

import doctest
import importlib
import inspect
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import trundle
from website import api

ROOT = Path(__file__).resolve().parents[2]
OPTIONS = doctest.ELLIPSIS | doctest.IGNORE_EXCEPTION_DETAIL | doctest.NORMALIZE_WHITESPACE


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


PUBLIC = public_objects()
DOCUMENTED = [name for names in api.documented_names().values() for name in names]


@pytest.mark.parametrize("name", PUBLIC)
def test_a_public_name_is_in_the_reference(name: str) -> None:
    assert DOCUMENTED.count(name) == 1
    pages = dict(api.api_pages())
    assert sum(f"\n::: {name}\n" in page for page in pages.values()) == 1
    assert f"[`{name}`]" in pages["reference/python/index.md"]


@pytest.mark.parametrize("name", PUBLIC)
def test_a_public_name_has_an_example(name: str) -> None:
    assert ">>> " in (inspect.getdoc(PUBLIC[name]) or ""), f"{name}: no example in its docstring"


@pytest.mark.parametrize("name", PUBLIC)
def test_an_example_works(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    text = inspect.getdoc(PUBLIC[name]) or ""
    test = doctest.DocTestParser().get_doctest(text, {"trundle": trundle}, name, None, 0)
    runner = doctest.DocTestRunner(optionflags=OPTIONS, verbose=False)
    report: list[str] = []
    runner.run(test, out=report.append)
    assert runner.summarize(verbose=False).failed == 0, "".join(report)


def test_modules_of_the_public_api_exist() -> None:
    modules = [value for name in trundle.__all__ if isinstance(value := getattr(trundle, name), ModuleType)]
    assert {module.__name__.rpartition(".")[2] for module in modules} <= set(api.public_modules())
