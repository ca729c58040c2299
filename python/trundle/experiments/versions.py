"""Versions of the code that results depend on: hashes of sources without comments and docstrings."""

from __future__ import annotations

import ast
import functools
import hashlib
from collections.abc import Iterable
from pathlib import Path
from typing import Literal

import trundle
from trundle import _native, diagnosis, findings, input_checks, inspection
from trundle.experiments.blind import diagnose

__all__ = ["PACKAGE", "code_version", "of_diagnosis", "of_module", "of_package"]

PACKAGE = Path(trundle.__file__).parent


def of_package() -> str:
    """Return the version of this package and of the Rust sources of its native module."""
    return f"{_native._sources('all')}-{code_version(PACKAGE)[:16]}"


def of_diagnosis(kind: Literal["planar", "joints"]) -> str:
    """Return the version of the code that a diagnosis of pushed objects or of joints depends on."""
    modules = (diagnosis, input_checks, findings, inspection, diagnose)
    sources = [Path(str(module.__file__)) for module in modules]
    if kind == "joints":
        sources += [PACKAGE / name for name in ("joint_diagnosis", "mechanism")]
    return f"{_native._sources(kind)}-{code_version(*sources)[:16]}"


def of_module(name: str) -> str:
    """Return the version of a module of the experiments and of all experiment modules that it imports."""
    root = PACKAGE / "experiments"
    waiting, found = [root / f"{name}.py"], set()
    while waiting:
        path = waiting.pop()
        if path.exists() and path not in found:
            found.add(path)
            waiting += imported(path, root)
    return code_version(*sorted(found))


def imported(path: Path, root: Path) -> list[Path]:
    """Return the files below `root` that the imports of a file may refer to."""
    prefix, found = "trundle.experiments.", []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
        names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        for name in (name for name in names if f"{name}.".startswith(prefix)):
            place = root.joinpath(*f"{name}.".removeprefix(prefix).split("."))
            found += [place.with_suffix(".py"), place / "__init__.py"]
            if isinstance(node, ast.ImportFrom):
                found += [place / f"{alias.name}.py" for alias in node.names]
    return found


def code_version(*sources: Path) -> str:
    """Return the SHA-256 of Python files, and of all Python files below folders.

    Comments, docstrings and layout have no effect.
    """
    digest = hashlib.sha256()
    for source in sources:
        for path in sorted(python_files(source)):
            digest.update(f"{path.relative_to(source.parent).as_posix()}\0".encode())
            state = path.stat()
            digest.update(file_digest(path, state.st_mtime_ns, state.st_size))
    return digest.hexdigest()


def python_files(source: Path) -> Iterable[Path]:
    """Return the file itself, or the Python files below a folder."""
    return source.rglob("*.py") if source.is_dir() else [source]


@functools.cache
def file_digest(path: Path, modified_ns: int, size: int) -> bytes:
    """Return the SHA-256 of a Python file without docstrings, computed once for each state of the file."""
    return hashlib.sha256(without_text(path)).digest()


def without_text(path: Path) -> bytes:
    """Return the syntax tree of a file without its docstrings."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            node.body = [one for one in body if not is_docstring(one)]  # type: ignore[attr-defined]
    return ast.dump(tree).encode()


def is_docstring(node: ast.AST) -> bool:
    """Return whether a statement is only a string."""
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
