"""No import cycle between files."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

PYTHON = Path(__file__).resolve().parents[2] / "python"


def modules() -> dict[str, Path]:
    """Return the files of the package by module name."""
    found = {}
    for path in (PYTHON / "trundle").rglob("*.py"):
        name = ".".join(path.relative_to(PYTHON).with_suffix("").parts)
        found[name.removesuffix(".__init__")] = path
    return found


def imported_on_loading(tree: ast.AST) -> Iterator[str]:
    """Yield the names that a file imports when it is loaded: outside functions, not for type checkers."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            continue
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
            continue
        if isinstance(node, ast.ImportFrom) and node.module:
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        else:
            yield from imported_on_loading(node)


def file_of(name: str, known: dict[str, Path]) -> str | None:
    """Return the module that an imported name is, or is in."""
    if name in known:
        return name
    parent = name.rpartition(".")[0]
    return parent if parent in known else None


def test_python_files_import_each_other_without_cycles() -> None:
    known = modules() | {"trundle._native": PYTHON}
    graph = {}
    for name, path in known.items():
        if path.suffix == ".py":
            names = imported_on_loading(ast.parse(path.read_text(encoding="utf-8")))
            graph[name] = {one for one in (file_of(each, known) for each in names) if one not in (None, name)}
    assert len(graph) > 200
    TopologicalSorter(graph).prepare()  # raises CycleError, which names the cycle


def test_tests_do_not_import_from_benches() -> None:
    tests = Path(__file__).resolve().parents[1]
    names = [
        name
        for path in tests.rglob("*.py")
        for name in imported_on_loading(ast.parse(path.read_text(encoding="utf-8")))
    ]
    assert not [name for name in names if name.startswith("benches")]
