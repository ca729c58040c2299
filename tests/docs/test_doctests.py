"""The examples in docstrings of the public API run, and every public function and class has one."""

from __future__ import annotations

import doctest
import inspect
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import trundle

FLAGS = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS


def members(owner: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Yield an object and, of a class, its public methods and properties, by their paths."""
    yield path, owner
    if isinstance(owner, type):
        for name, value in vars(owner).items():
            if not name.startswith("_") and (callable(value) or isinstance(value, property)):
                yield f"{path}.{name}", value


def documented() -> Iterator[tuple[str, Any]]:
    """Yield the public objects by their paths."""
    for name in trundle.__all__:
        value = getattr(trundle, name)
        if not isinstance(value, ModuleType):
            yield from members(value, f"trundle.{name}")
            continue
        yield f"trundle.{name}", value
        for inner in value.__all__:
            yield from members(getattr(value, inner), f"trundle.{name}.{inner}")


DOCUMENTED = dict(documented())
WITH_EXAMPLES = [path for path, value in DOCUMENTED.items() if ">>>" in (inspect.getdoc(value) or "")]


@pytest.mark.parametrize("path", WITH_EXAMPLES)
def test_the_examples_run(
    path: str, examples: tuple[Path, dict[str, Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, names = examples
    monkeypatch.chdir(folder)
    text = inspect.getdoc(DOCUMENTED[path]) or ""
    example = doctest.DocTestParser().get_doctest(text, dict(names), path, None, None)
    printed: list[str] = []
    result = doctest.DocTestRunner(optionflags=FLAGS).run(example, out=printed.append)
    assert result.attempted > 0
    assert result.failed == 0, "".join(printed)


@pytest.mark.parametrize(
    "name", [name for name in trundle.__all__ if name not in ("__version__", "TrundleError")]
)
def test_every_public_name_has_an_example(name: str) -> None:
    """The example of a module may be that of one of its members."""
    paths = [
        path for path in WITH_EXAMPLES if path == f"trundle.{name}" or path.startswith(f"trundle.{name}.")
    ]
    assert paths, f"trundle.{name}: add an `Examples` section to its docstring"
