"""Importing trundle needs no optional package, and an absent one is named with its extra."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import gymnasium
import pytest

import trundle
from trundle._optional import require
from trundle._registration import TASKS

OPTIONAL = (
    "PIL",
    "arviz",
    "gym_pusht",
    "h5netcdf",
    "h5py",
    "joblib",
    "matplotlib",
    "mujoco",
    "pandas",
    "pyarrow",
    "pygame",
    "pymunk",
    "ray",
    "rerun",
    "rosbags",
    "scipy",
    "stable_baselines3",
    "torch",
    "xarray",
)
"""Modules of the packages that the extras install."""

BLOCK = f"""
import sys

class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {OPTIONAL!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Absent())
"""
"""Beginning of a program in which no optional package can be imported."""

NEEDS_EXTRA = (
    "trundle.envs.sb3",
    "trundle.export.callback",
    "trundle.export.mjcf_patch.callback",
    "trundle.importers.hdf5_child",
    "trundle.plots.notebook_figure",
)
"""Modules that are useless without an optional package: their users name its extra, or they run alone."""

IMPORT_ALL = """
import importlib, pkgutil, trundle

for found in pkgutil.walk_packages(trundle.__path__, "trundle."):
    if not found.name.startswith("trundle.experiments.") and found.name not in NEEDS_EXTRA:
        importlib.import_module(found.name)
"""


def run(program: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    line = [sys.executable, "-c", program, *arguments]
    return subprocess.run(line, capture_output=True, text=True, timeout=300, check=False)


def test_import_loads_no_optional_package() -> None:
    ran = run(f"import sys, trundle; print(*sorted(set({OPTIONAL!r}) & set(sys.modules)))")
    assert (ran.stdout.split(), ran.stderr) == ([], "")


def test_every_module_outside_the_experiments_loads_without_optional_packages() -> None:
    ran = run(f"{BLOCK}\nNEEDS_EXTRA = {NEEDS_EXTRA!r}\n{IMPORT_ALL}")
    assert ran.returncode == 0, ran.stderr


def optional_imports(node: ast.AST) -> Iterator[str]:
    """Yield the optional packages that the statements below a node import, except for type checkers."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.If) and "TYPE_CHECKING" in ast.dump(child.test):
            continue
        names = [alias.name for alias in child.names] if isinstance(child, ast.Import) else []
        if isinstance(child, ast.ImportFrom) and child.module:
            names = [child.module]
        yield from (name for name in names if name.partition(".")[0] in OPTIONAL)
        yield from optional_imports(child)


def test_optional_packages_are_imported_through_require() -> None:
    package = Path(trundle.__file__).parent
    found = {
        str(path.relative_to(package)): names
        for path in package.rglob("*.py")
        if (names := list(optional_imports(ast.parse(path.read_text(encoding="utf-8")))))
    }
    allowed = {name.removeprefix("trundle.").replace(".", "/") + ".py" for name in NEEDS_EXTRA}
    assert {file for file in found if not file.startswith("experiments/")} <= allowed


def test_every_verb_shows_its_help_without_optional_packages() -> None:
    verbs = run(f"{BLOCK}\nfrom trundle.cli.commands import discover; print(*discover())").stdout.split()
    assert "diagnose" in verbs
    program = f"{BLOCK}\nfrom trundle.cli import main\nfor verb in sys.argv[1:]:\n"
    program += (
        "    try:\n        main([verb, '--help'])\n    except SystemExit as end:\n        assert not end.code"
    )
    ran = run(program, *verbs)
    assert ran.returncode == 0, ran.stderr


@pytest.mark.parametrize(
    ("line", "extra"),
    [
        ("import trundle; trundle.demo().frame('episode_00')", "pandas"),
        ("import trundle; trundle.sample(trundle.demo())", "arviz"),
        ("import trundle; trundle.export.write_mcap(trundle.demo(), 'never.mcap')", "ros"),
        ("import trundle; trundle.plots.recording(trundle.demo())", "plots"),
        ("import trundle.envs.sb3", "rl"),
        ("import trundle; trundle.mechanism.Mechanism.load('<mujoco/>', ['elbow'])", "mujoco"),
        ("from trundle.experiments.backends import backend; backend('joblib', jobs=2)", "joblib"),
    ],
)
def test_an_absent_package_is_named_with_its_extra(line: str, extra: str) -> None:
    ran = run(f"{BLOCK}\n{line}")
    assert ran.returncode == 1
    last = ran.stderr.strip().splitlines()[-1]
    assert last.startswith("trundle.TrundleError: ")
    assert last.endswith(f": pip install 'trundle[{extra}]'")


@pytest.mark.parametrize(
    ("arguments", "extra"),
    [
        (("compare", "configs/experiments/compare_small.toml"), "experiments"),
        (("paper", "fig5"), "experiments"),
        (("prove",), "experiments"),
        (("calibrate", "configs/experiments/calibrate.toml", "--figure", "x.png"), "plots"),
    ],
)
def test_a_verb_names_the_extra_before_it_works(arguments: tuple[str, ...], extra: str) -> None:
    ran = run(f"{BLOCK}\nfrom trundle.cli import main; sys.exit(main(sys.argv[1:]))", *arguments)
    assert ran.returncode == 2
    assert f"pip install 'trundle[{extra}]'" in ran.stderr


def test_an_installed_package_that_is_broken_raises_its_own_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "broken_package.py").write_text("import missing_dependency\n")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ModuleNotFoundError, match="missing_dependency"):
        require("broken_package", "plots", "plots")


def test_import_registers_every_environment() -> None:
    for module, names in TASKS.items():
        for name in names:
            assert gymnasium.spec(f"trundle/{name}-v0").entry_point == f"{module}:{name}"
            assert isinstance(getattr(trundle.envs, name), type)
    flat = {task.__name__ for task in trundle.envs.FLAT}
    assert flat == set(TASKS["trundle.envs.tasks"])


def test_public_names_are_complete_and_unknown_ones_are_refused() -> None:
    ran = run("import trundle; print(*dir(trundle)); [getattr(trundle, name) for name in trundle.__all__]")
    assert ran.stderr == ""
    assert set(trundle.__all__) <= set(ran.stdout.split())
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        trundle.nonsense  # noqa: B018
