"""Start of the Rerun viewer in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from trundle.recording import TrundleError

__all__ = ["open_viewer", "require_display"]

DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY")


def require_display() -> None:
    """Raise `TrundleError` on Linux without a display, where the viewer cannot open a window."""
    if sys.platform == "linux" and not any(os.environ.get(name) for name in DISPLAYS):
        raise TrundleError(
            "--open: this machine has no display; write the file without --open and open it with "
            "`rerun FILE` on another machine"
        )


def open_viewer(path: Path) -> None:
    """Open a file in the Rerun viewer, which continues when this process ends."""
    subprocess.Popen(
        [sys.executable, "-m", "rerun", str(path)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
