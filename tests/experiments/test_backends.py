"""Calls on every backend: equal results, lost workers and nodes, and Ctrl-C."""

from __future__ import annotations

import json
import os
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import trundle
from tests.command import interruptible
from trundle.experiments.backends import BACKENDS, Local, Ray, backend, in_order
from trundle.experiments.runner import Runner, Unit

SCRIPT = """
import sys, time
from trundle.cli.exits import run_guarded
from trundle.experiments.backends import backend

def work() -> int:
    for number, _ in backend(sys.argv[1], 2).map(time.sleep, [(0.0,), (60.0,), (60.0,), (60.0,)]):
        print(number, flush=True)
    return 0

if __name__ == "__main__":
    sys.exit(run_guarded(work))
"""


TESTED = [pytest.param(name, marks=[pytest.mark.slow] * (name == "ray")) for name in BACKENDS]


@pytest.mark.parametrize("name", TESTED)
def test_results_have_the_index_of_their_call(name: str) -> None:
    pytest.importorskip(name) if name != "local" else None
    assert sorted(backend(name, 2).map(abs, [(-3,), (4,), (-5,)])) == [(0, 3), (1, 4), (2, 5)]


def test_results_in_order() -> None:
    assert list(in_order(Local(2), abs, [(-k,) for k in range(9)])) == list(range(9))


def test_an_error_of_a_call_is_raised() -> None:
    with pytest.raises(ZeroDivisionError):
        list(Local(2).map(divmod, [(1, 1), (1, 0)]))


@pytest.mark.parametrize(
    ("name", "address", "words"),
    [("dask", None, "choose local, joblib, ray"), ("local", "auto", "only the backend ray")],
)
def test_an_unusable_backend_is_refused(name: str, address: str | None, words: str) -> None:
    with pytest.raises(trundle.TrundleError, match=words):
        backend(name, address=address)


def test_a_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(trundle.TrundleError, match=r"pip install 'trundle\[ray\]'"):
        backend("ray")


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="the system has no signal masks")
def test_ctrl_c_does_not_reach_worker_processes() -> None:
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ())
    masks = dict(Local(2).map(signal.pthread_sigmask, [(signal.SIG_BLOCK, ())] * 2))
    assert all(signal.SIGINT in mask for mask in masks.values())
    assert signal.pthread_sigmask(signal.SIG_BLOCK, ()) == before


@pytest.mark.parametrize("name", TESTED)
def test_ctrl_c_does_not_wait_for_running_calls(name: str, tmp_path: Path) -> None:
    pytest.importorskip(name) if name != "local" else None
    script = tmp_path / "long.py"
    script.write_text(SCRIPT)
    with interruptible([sys.executable, str(script), name]) as process:
        assert process.stdout is not None
        process.stdout.readline()
        begun = time.monotonic()
        process.send_signal(signal.SIGINT)
        _, complaint = process.communicate(timeout=50)
    assert process.returncode == 130
    assert complaint.endswith("trundle: interrupted\n")
    assert "Traceback" not in complaint
    assert time.monotonic() - begun < 20


def dies_once(number: int, marks: Path) -> dict[str, Any]:
    """Kill this process in the first call of an odd number."""
    mark = marks / str(number)
    if number % 2 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return {"square": number * number, "cost": os.getpid()}


def takes_long(number: int) -> dict[str, Any]:
    """Take half a second, so that calls run on the node that is lost."""
    time.sleep(0.5)
    return {"square": number * number}


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    """Start a Ray cluster of two nodes on this machine, with one processor each."""
    ray: Any = pytest.importorskip("ray")
    from ray.cluster_utils import Cluster

    made: Any = Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
    made.add_node(num_cpus=1)
    yield made
    ray.shutdown()
    made.shutdown()


def squares(store: Path) -> list[int]:
    """Return the content of the store."""
    return sorted(json.loads(path.read_text())["result"]["square"] for path in store.iterdir())


def test_killed_workers_lose_no_result(cluster: Any, tmp_path: Path) -> None:
    units = [Unit(f"{k}", dies_once, {"number": k}, {"marks": tmp_path}) for k in range(6)]
    runner = Runner(tmp_path / "store", "v1", Ray(address=cluster.address), quiet=True)
    assert [one["square"] for one in runner.run("squares", units)] == [0, 1, 4, 9, 16, 25]
    assert sorted(int(path.name) for path in tmp_path.iterdir() if path.is_file()) == [1, 3, 5]
    assert squares(tmp_path / "store") == [0, 1, 4, 9, 16, 25]


def test_a_lost_node_loses_no_result(cluster: Any) -> None:
    found = {}
    for number, result in Ray(address=cluster.address).map(takes_long, [(k,) for k in range(8)]):
        found[number] = result["square"]
        if len(found) == 1:
            cluster.remove_node(cluster.list_all_nodes()[1], allow_graceful=False)
    assert found == {k: k * k for k in range(8)}
