"""The command line in a process of its own, as a person starts it."""

import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

COMMAND = (sys.executable, "-m", "trundle")


def trundle(folder: Path, *arguments: str | Path, **environment: str) -> "subprocess.CompletedProcess[str]":
    """Run `trundle` in `folder` and return how it ended and what it printed."""
    return subprocess.run(
        [*COMMAND, *map(str, arguments)],
        cwd=folder,
        env=os.environ | {"COLUMNS": "100"} | environment,
        capture_output=True,
        text=True,
        timeout=300,
    )


def interruptible(line: Sequence[str | Path], folder: Path | None = None) -> "subprocess.Popen[str]":
    """Start `line` as a terminal does: background jobs of a shell ignore Ctrl-C, and so do their children."""
    return subprocess.Popen(
        line,
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
