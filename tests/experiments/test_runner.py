"""The runner of experiments: each unit once, resumable, the same bytes in any order."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Literal

import pytest

from trundle import TrundleError, _native
from trundle.experiments import versions
from trundle.experiments.backends import Local
from trundle.experiments.blind.benchmark import code_versions
from trundle.experiments.runner import Runner, Unit
from trundle.experiments.versions import code_version, of_diagnosis, of_module


def square(number: int, log: Path) -> dict[str, Any]:
    """Return a square, and log the call."""
    with log.open("a") as file:
        file.write(f"{number}\n")
    if number < 0:
        raise ValueError("negative")
    return {"square": number * number + 0.1234567891}


def units(log: Path, *numbers: int) -> list[Unit]:
    return [Unit(f"unit_{number}", square, {"number": number}, {"log": log}) for number in numbers]


def test_each_unit_runs_once_and_results_keep_the_order(tmp_path: Path) -> None:
    log, runner = tmp_path / "log", Runner(tmp_path / "store", "v1", quiet=True)
    assert [one["square"] for one in runner.run("squares", units(log, 3, 1, 2))] == [
        9.12346,
        1.12346,
        4.12346,
    ]
    assert [one["square"] for one in runner.run("squares", units(log, 1, 2, 3, 4))][:3] == [
        1.12346,
        4.12346,
        9.12346,
    ]
    assert log.read_text().split() == ["3", "1", "2", "4"]


def test_another_version_or_argument_is_another_unit(tmp_path: Path) -> None:
    log = tmp_path / "log"
    Runner(tmp_path / "store", "v1", quiet=True).run("squares", units(log, 2))
    Runner(tmp_path / "store", "v2", quiet=True).run("squares", units(log, 2))
    assert log.read_text().split() == ["2", "2"]


def test_only_failed_units_are_repeated(tmp_path: Path) -> None:
    log, runner = tmp_path / "log", Runner(tmp_path / "store", "v1", quiet=True)
    with pytest.raises(ValueError, match="negative"):
        runner.run("squares", units(log, 1, -1, 2))
    runner.run("squares", units(log, 1, 2))
    assert log.read_text().split() == ["1", "-1", "2"]


def test_a_failed_unit_is_reported_and_others_are_kept(tmp_path: Path) -> None:
    stream = io.StringIO()
    runner = Runner(tmp_path / "store", "v1", stream=stream)
    many = [Unit(f"unit {k}", refuses_one, {"number": k}) for k in range(3)]
    with pytest.raises(TrundleError, match="squares: 1 of 3 failed; first unit 1: one is refused"):
        runner.run("squares", many)
    assert "unit 1: one is refused\n" in stream.getvalue()
    assert [runner.is_done(unit) for unit in many] == [True, False, True]


def refuses_one(number: int) -> int:
    """Refuse a number."""
    if number == 1:
        raise TrundleError("one is refused")
    return number


def test_two_processes_give_the_same_bytes(tmp_path: Path) -> None:
    stores = []
    for jobs, numbers in ((1, (1, 2, 3, 4)), (2, (4, 3, 2, 1))):
        store = tmp_path / f"store{jobs}"
        Runner(store, "v1", Local(jobs), quiet=True).run("squares", units(tmp_path / "log", *numbers))
        stores.append({path.name: path.read_bytes() for path in store.iterdir()})
    assert stores[0] == stores[1]
    assert len(stores[0]) == 4


def test_lost_output_of_a_unit_is_made_again(tmp_path: Path) -> None:
    runner, made = Runner(tmp_path / "store", "v1", quiet=True), tmp_path / "made"
    unit = [Unit("writes", writes, {}, {"path": made}, made)]
    runner.run("writing", unit)
    made.unlink()
    runner.run("writing", unit)
    assert made.read_text() == "made"


def writes(path: Path) -> dict[str, Any]:
    """Write a file."""
    path.write_text("made")
    return {"digest": "1"}


SLOW = """
import sys, time
from pathlib import Path
from trundle.experiments.runner import Runner, Unit
from tests_slow import slow
Runner(Path(sys.argv[1]), "v1", quiet=True).run("slow", [Unit(f"{k}", slow, {"k": k}) for k in range(3)])
print("finished", flush=True)
"""


def test_it_continues_after_a_kill(tmp_path: Path) -> None:
    (tmp_path / "tests_slow.py").write_text(
        "import time\ndef slow(k):\n    time.sleep(0.0 if k == 0 else 60.0)\n    return k\n"
    )
    store = tmp_path / "store"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])}
    process = subprocess.Popen([sys.executable, "-c", SLOW, str(store)], env=environment)
    try:
        wait_for(lambda: store.exists() and len(list(store.glob("*.json"))) == 1)
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
    (tmp_path / "tests_slow.py").write_text("def slow(k):\n    assert k > 0, 'done twice'\n    return k\n")
    done = subprocess.run(
        [sys.executable, "-c", SLOW, str(store)], env=environment, capture_output=True, text=True, check=False
    )
    assert "finished" in done.stdout, done.stderr
    assert len(list(store.glob("*.json"))) == 3


def wait_for(condition: Any) -> None:
    for _ in range(600):
        if condition():
            return
        time.sleep(0.1)
    raise AssertionError("waited for a minute")


def test_progress_shows_the_remaining_units(tmp_path: Path) -> None:
    stream = io.StringIO()
    Runner(tmp_path / "store", "v1", stream=stream).run("squares", units(tmp_path / "log", 1, 2))
    assert "squares: 2 of 2 (unit_2), about 0 s left" in stream.getvalue()


def test_the_version_of_code_ignores_comments_only(tmp_path: Path) -> None:
    source = tmp_path / "one.py"
    source.write_text('"""One."""\n\ndef f(x):\n    return x + 1\n')
    before = code_version(tmp_path)
    source.write_text('"""Another."""\ndef f(x):  # a comment\n    """Add."""\n    return x + 1\n')
    assert code_version(tmp_path) == before
    source.write_text("def f(x):\n    return x + 2\n")
    assert code_version(tmp_path) != before


def test_the_version_of_a_module_includes_what_it_imports() -> None:
    assert of_module("blind/case") == of_module("blind/case") != of_module("blind/wide/generator")
    assert of_module("blind/tables") != of_module("blind/score")


def test_the_diagnosis_of_pushed_objects_does_not_depend_on_that_of_joints(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(versions, "PACKAGE", tmp_path)
    source = tmp_path / "joint_diagnosis" / "engine.py"
    source.parent.mkdir()
    (tmp_path / "mechanism").mkdir()
    source.write_text("STEPS = 1\n")
    before = of_diagnosis("planar"), of_diagnosis("joints")
    source.write_text("STEPS = 2\n")
    after = of_diagnosis("planar"), of_diagnosis("joints")
    assert after[0] == before[0] and after[1] != before[1]
    assert _native._sources("planar") != _native._sources("joints") != _native._sources("all")


@pytest.mark.parametrize(
    ("generator", "kind"), [("furniture", "planar"), ("wide", "planar"), ("mechanism", "joints")]
)
def test_a_benchmark_states_the_version_of_its_own_diagnosis(
    generator: str, kind: Literal["planar", "joints"]
) -> None:
    settings: Any = SimpleNamespace(generator=generator)
    assert code_versions(settings)["diagnosis"] == of_diagnosis(kind)
