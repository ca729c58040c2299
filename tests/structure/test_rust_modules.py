"""No cycle between the files of a crate.

A file depends on the files in which the items that it names are defined; re-exports are followed. `mod`
declarations and test modules do not count.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SOURCES = [
    file.parent / "src" for file in sorted(ROOT.glob("*/Cargo.toml")) + sorted(ROOT.glob("*/*/Cargo.toml"))
]

COMMENT = re.compile(r"//[^\n]*")
TEST_MODULE = re.compile(
    r"#\[cfg\(test\)\](?:\s*#\[[^\n]*\])*\s*(?:pub(?:\(crate\))? )?mod \w+ \{.*?\n\}", re.S
)
USE = re.compile(r"\buse\s+([^;]+);")
PATH = re.compile(r"(?<![\w:])\w+(?:::\w+)+")
DEFINITION = r"\b(?:fn|struct|enum|trait|type|const|static|union|macro_rules!)\s+{name}\b"

Name = tuple[str, ...]


@dataclass
class Module:
    """A file: its text, the paths that it names, and the names that it imports."""

    text: str
    paths: list[Name] = field(default_factory=list)
    imported: dict[str, Name] = field(default_factory=dict)
    globs: list[Name] = field(default_factory=list)


def use_tree(tree: str, prefix: str = "") -> Iterator[tuple[str, str]]:
    """Yield the path and the local name of every item of a `use` declaration."""
    tree = re.sub(r"\s+", " ", tree).strip()
    if tree.endswith("}"):
        head, _, body = tree[:-1].partition("{")
        depth, start = 0, 0
        for index, sign in enumerate(body + ","):
            depth += (sign == "{") - (sign == "}")
            if sign == "," and depth == 0:
                if body[start:index].strip():
                    yield from use_tree(body[start:index], prefix + head.strip())
                start = index + 1
        return
    path, _, alias = tree.partition(" as ")
    path = (prefix + path.strip()).removesuffix("::self")
    yield path, alias.strip() or path.rpartition("::")[2]


class Crate:
    """The files of a crate by their module paths."""

    def __init__(self, source: Path) -> None:
        self.modules = {}
        for file in source.rglob("*.rs"):
            name = file.relative_to(source).with_suffix("").parts
            name = name[:-1] if name[-1] in ("lib", "main", "mod") else name
            if "tests" not in name:
                self.modules[name] = Module(TEST_MODULE.sub("", COMMENT.sub("", file.read_text("utf-8"))))
        for name in self.modules:
            self.read(name)

    def read(self, name: Name) -> None:
        """Collect the paths in a module."""
        module = self.modules[name]
        for tree in USE.findall(module.text):
            for path, local in use_tree(tree):
                target = self.absolute(name, path)
                if target is None:
                    continue
                module.paths.append(target)
                if local == "*":
                    module.globs.append(target[:-1])
                else:
                    module.imported[local] = target
        for path in PATH.findall(USE.sub("", module.text)):
            target = self.absolute(name, path)
            if target is not None:
                module.paths.append(target)

    def absolute(self, module: Name, path: str) -> Name | None:
        """Return a path from the root of the crate; None if it leads out of the crate."""
        first, *rest = path.split("::")
        if first == "crate":
            return tuple(rest)
        if first == "self":
            return (*module, *rest)
        if first == "super":
            parent = module[:-1]
            while rest and rest[0] == "super":
                parent, rest = parent[:-1], rest[1:]
            return (*parent, *rest)
        return (*module, first, *rest) if (*module, first) in self.modules else None

    def owner(self, path: Name, depth: int = 0) -> Name:
        """Return the module that defines the item at a path."""
        current: Name = ()
        for index, name in enumerate(path):
            if (*current, name) in self.modules:
                current = (*current, name)
                continue
            module = self.modules[current]
            imported = module.imported.get(name)
            if imported is not None and imported != path[: index + 1] and depth < len(self.modules):
                return self.owner((*imported, *path[index + 1 :]), depth + 1)
            if name == "*" or re.search(DEFINITION.format(name=name), module.text):
                return current
            found = (self.owner((*one, *path[index:]), depth + 1) for one in module.globs if depth < 9)
            return next((one for one in found if one != current), current)
        return current

    def graph(self) -> dict[str, set[str]]:
        """Return the files that every file depends on, by their module paths."""
        spelled = "::".join
        return {
            spelled(name): {spelled(self.owner(path)) for path in module.paths} - {spelled(name)}
            for name, module in self.modules.items()
        }


@cache
def crate(source: Path) -> Crate:
    """Read a crate once."""
    return Crate(source)


@pytest.mark.parametrize("source", SOURCES, ids=lambda source: str(source.relative_to(ROOT)))
def test_files_of_a_crate_do_not_depend_on_each_other_in_a_cycle(source: Path) -> None:
    TopologicalSorter(crate(source).graph()).prepare()  # raises CycleError, which names the cycle


def test_dependencies_are_found_through_re_exports() -> None:
    graph = crate(ROOT / "adaptive/infer/src").graph()
    assert {"likelihood", "target", "optimum", "watch"} <= graph["levenberg"]
    assert graph["optimum"] == {"likelihood"}
    assert "filter" in graph["filter::linear"] and "filter::linear" not in graph["filter"]


def test_a_cycle_is_found(tmp_path: Path) -> None:
    files = {
        "lib.rs": "mod a;\nmod b;\npub use a::A;\n",
        "a.rs": "use crate::b::{self, B};\npub struct A(B);\n",
        "b.rs": "pub struct B;\n#[cfg(test)]\nmod tests {\n    use crate::A;\n}\n",
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    TopologicalSorter(Crate(tmp_path).graph()).prepare()
    (tmp_path / "b.rs").write_text("pub struct B;\nfn a() -> crate::A { loop {} }\n", encoding="utf-8")
    with pytest.raises(ValueError, match="cycle"):
        TopologicalSorter(Crate(tmp_path).graph()).prepare()
