"""The command line in a separate process."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

COMMAND = (sys.executable, "-m", "trundle")


def trundle(folder: Path, *arguments: str | Path, **environment: str) -> "subprocess.CompletedProcess[str]":
    """Run `trundle` in `folder` and return its exit status and output."""
    return subprocess.run(
        [*COMMAND, *map(str, arguments)],
        cwd=folder,
        env=os.environ | {"COLUMNS": "100"} | environment,
        capture_output=True,
        text=True,
        timeout=300,
    )


def at_work(process: "subprocess.Popen[str]", seconds: float) -> None:
    """Wait until a process has used some seconds of CPU time."""
    stat = Path(f"/proc/{process.pid}/stat")
    if not stat.exists():
        time.sleep(seconds)
        return
    while process.poll() is None:
        spent = stat.read_text().rpartition(")")[2].split()
        if (int(spent[11]) + int(spent[12])) / os.sysconf("SC_CLK_TCK") > seconds:
            return
        time.sleep(0.02)


def interruptible(line: Sequence[str | Path], folder: Path | None = None) -> "subprocess.Popen[str]":
    """Start `line` so that it receives Ctrl-C, which background jobs of a shell ignore."""
    return subprocess.Popen(
        line,
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
