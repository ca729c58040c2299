"""The command line in a process of its own, as a person starts it."""

import os
import subprocess
import sys
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
