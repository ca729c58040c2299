import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.command import interruptible
from trundle.cli.exits import run_guarded


def raising(error: BaseException) -> Callable[[], int]:
    def work() -> int:
        raise error

    return work


@pytest.mark.parametrize(
    ("error", "status", "words"),
    [
        (ValueError("a.csv, row 3: no number"), 2, "trundle: a.csv, row 3: no number\n"),
        (
            FileNotFoundError(2, "No such file or directory", "x/y"),
            2,
            "trundle: x/y: No such file or directory\n",
        ),
        (OSError(28, "No space left on device"), 1, "No space left"),
        (OSError(28, "No space left on device", "p.png"), 1, "trundle: p.png: No space left on device\n"),
        (ValueError("a\x1b[31mb\u202e: no"), 2, "trundle: a\\x1b[31mb\\u202e: no\n"),
        (RuntimeError("wrong"), 1, "trundle: RuntimeError: wrong (set TRUNDLE_DEBUG=1 for a traceback)\n"),
        (KeyboardInterrupt(), 130, "trundle: interrupted\n"),
    ],
)
def test_each_error_has_its_exit_status(
    error: BaseException, status: int, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run_guarded(raising(error)) == status
    assert words in capsys.readouterr().err


def test_an_exit_status_is_passed_on() -> None:
    assert run_guarded(lambda: 7) == 7


def test_ctrl_c_interrupts_a_verb_immediately() -> None:
    script = (
        "import sys, time; from trundle.cli.exits import run_guarded\n"
        "sys.exit(run_guarded(lambda: print('began', flush=True) or time.sleep(60)))"
    )
    with interruptible([sys.executable, "-c", script]) as process:
        assert process.stdout is not None
        process.stdout.readline()
        process.send_signal(signal.SIGINT)
        _, complaint = process.communicate(timeout=10)
    assert process.returncode == 130
    assert complaint == "trundle: interrupted\n"


def test_a_closed_pipe_is_no_error(tmp_path: Path) -> None:
    script = (
        "import sys; from trundle.cli.exits import run_guarded\n"
        "sys.exit(run_guarded(lambda: print('line\\n' * 200_000) or 0))"
    )
    complaints = tmp_path / "stderr"
    with (
        complaints.open("w") as stderr,
        subprocess.Popen([sys.executable, "-c", script], stdout=-1, stderr=stderr) as process,
    ):
        assert process.stdout is not None
        process.stdout.readline()
        process.stdout.close()
    assert process.returncode == 141
    assert complaints.read_text() == ""
