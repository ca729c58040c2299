"""The metadata of the package, of the crates and of the citation agree with each other and with the code."""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

import trundle

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).resolve().parents[2]
CARGO = tomllib.loads((ROOT / "Cargo.toml").read_text(encoding="utf-8"))
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
VERSION = CARGO["workspace"]["package"]["version"]
DISTRIBUTIONS = {
    "PIL": "pillow",
    "gym_pusht": "gym-pusht",
    "pygame": "pygame-ce",
    "pymunk": "gym-pusht",
    "rerun": "rerun-sdk",
    "sb3_contrib": "sb3-contrib",
    "stable_baselines3": "stable-baselines3",
    "torch": "stable-baselines3",
}
"""Packages that install a module of another name."""


def package(requirement: str) -> str:
    """Return the name of the package in a requirement."""
    return re.split(r"[\[<>=!~; ]", requirement)[0]


def required() -> Iterator[tuple[str, str, str]]:
    """Yield file, module and extra of every call of `require` with literal arguments."""
    for path in sorted((ROOT / "python" / "trundle").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "require":
                modules = [node.args[0]] if isinstance(node.args[0], ast.Constant) else looped(path)
                for module in modules:
                    yield path.name, module.value.partition(".")[0], node.args[1].value  # type: ignore


def looped(path: Path) -> list[Any]:
    """Return the modules of a loop `for module in ("a", "b"): require(module, ...)`."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    loops = (
        node for node in ast.walk(tree) if isinstance(node, ast.For) and isinstance(node.iter, ast.Tuple)
    )
    return next(loop.iter.elts for loop in loops if "require" in ast.dump(loop))  # type: ignore[attr-defined]


def test_there_is_one_version() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert re.fullmatch(r"\d+\.\d+\.\d+(-[a-z0-9.]+)?", VERSION)
    assert (trundle.__version__, citation["version"]) == (VERSION, VERSION)
    assert "version" in PROJECT["dynamic"]
    own = [each for name, each in CARGO["workspace"]["dependencies"].items() if name.startswith("trundle-")]
    assert {each.get("version", VERSION) for each in own} == {VERSION}


def test_the_changelog_has_a_section_for_changes_to_come() -> None:
    headings = re.findall(
        r"^## \[([^\]]+)\]", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), flags=re.M
    )
    assert headings[0] == "Unreleased"
    assert len(set(headings)) == len(headings)


def test_the_core_dependencies_are_those_of_a_first_diagnosis() -> None:
    names = {package(requirement) for requirement in PROJECT["dependencies"]}
    assert names == {"gymnasium", "jinja2", "markupsafe", "numpy", "tomli", "tomli-w", "tqdm"}


def test_every_required_module_is_in_the_extra_that_the_message_names() -> None:
    extras = PROJECT["optional-dependencies"]
    found = list(required())
    assert len(found) > 15
    for file, module, extra in found:
        packages = {package(requirement) for requirement in extras[extra]}
        assert DISTRIBUTIONS.get(module, module) in packages, f"{file}: {module} is not in [{extra}]"


def test_the_extra_all_has_every_extra_for_users_but_the_largest_and_one_that_conflicts() -> None:
    extras = PROJECT["optional-dependencies"]
    (everything,) = extras["all"]
    named = set(re.search(r"\[(.*)\]", everything)[1].split(","))  # type: ignore[index]
    assert named == set(extras) - {"all", "arena", "dev", "docs", "ray", "rl"}


@pytest.mark.parametrize("folder", [*CARGO["workspace"]["members"]])
def test_a_crate_is_described(folder: str) -> None:
    crate = tomllib.loads((ROOT / folder / "Cargo.toml").read_text(encoding="utf-8"))["package"]
    assert crate["description"].endswith(".")
    for key in ("version", "license", "authors", "repository", "readme", "keywords", "categories"):
        assert crate[key] == {"workspace": True}, key


def test_package_and_crates_have_the_same_addresses() -> None:
    repository = CARGO["workspace"]["package"]["repository"]
    urls = PROJECT["urls"]
    assert urls["Repository"] == repository
    assert all(urls[name].startswith(repository) for name in ("Homepage", "Issues", "Changelog"))


def test_lock_files_name_no_host() -> None:
    for lock in ("requirements.lock", "requirements-docs.lock", "requirements-rl.lock"):
        text = (ROOT / lock).read_text(encoding="utf-8")
        assert "--hash=sha256:" in text
        assert "://" not in text
