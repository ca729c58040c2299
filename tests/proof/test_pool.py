"""Work in parallel processes, and Ctrl-C while it is under way."""

import signal
import sys
import time
from pathlib import Path

import pytest

from tests.command import interruptible
from trundle.proof.pool import in_parallel

SCRIPT = """
import sys, time
from trundle.cli.exits import guarded
from trundle.proof.pool import in_parallel

def work() -> int:
    for number, _ in in_parallel(time.sleep, [(0.0,), (60.0,), (60.0,), (60.0,)], 2):
        print(number, flush=True)
    return 0

if __name__ == "__main__":
    sys.exit(guarded(work))
"""


def test_results_come_with_the_number_of_their_call() -> None:
    assert sorted(in_parallel(abs, [(-3,), (4,), (-5,)], 2)) == [(0, 3), (1, 4), (2, 5)]


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="the system has no signal masks")
def test_ctrl_c_never_reaches_the_processes_even_while_they_start() -> None:
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ())
    masks = dict(in_parallel(signal.pthread_sigmask, [(signal.SIG_BLOCK, ())] * 2, 2))
    assert all(signal.SIGINT in mask for mask in masks.values())
    assert signal.pthread_sigmask(signal.SIG_BLOCK, ()) == before


def test_ctrl_c_does_not_wait_for_what_the_processes_are_at(tmp_path: Path) -> None:
    script = tmp_path / "long.py"
    script.write_text(SCRIPT)
    with interruptible([sys.executable, str(script)]) as process:
        assert process.stdout is not None
        process.stdout.readline()
        begun = time.monotonic()
        process.send_signal(signal.SIGINT)
        _, complaint = process.communicate(timeout=50)
    assert process.returncode == 130
    assert complaint == "trundle: interrupted\n"
    assert time.monotonic() - begun < 20
