"""Ctrl-C while the `trundle` command is still importing: one sentence, as later, and no traceback.

Imported before all else by `trundle`, and of no effect where that is a library.
"""

from __future__ import annotations

import os
import signal
import sys
from types import FrameType

__all__ = ["restore_interrupt"]

MAIN_MODULE_PATH = os.path.join("trundle", "__main__.py")
"""What `python -m trundle` calls itself once it is imported."""


def _is_command() -> bool:
    """Whether this process is the command, by its script or as `python -m trundle`, or a worker of one."""
    name = sys.argv[0] if sys.argv else ""
    if name == "-m":
        return "trundle" in sys.orig_argv
    return os.path.splitext(os.path.basename(name))[0] == "trundle" or name.endswith(MAIN_MODULE_PATH)


def _is_worker() -> bool:
    processes = sys.modules.get("multiprocessing.process")
    return processes is not None and processes.parent_process() is not None


def _interrupted(number: int, frame: FrameType | None) -> None:
    # Nothing is under way yet; an exception would be reported from within whatever is being imported.
    os.write(2, b"trundle: interrupted\n")
    os._exit(128 + number)


def restore_interrupt() -> None:
    """Let Ctrl-C raise KeyboardInterrupt again: from now on that is handled."""
    if signal.getsignal(signal.SIGINT) is _interrupted:
        signal.signal(signal.SIGINT, signal.default_int_handler)


if _is_command() and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
    # Who started a worker ends it.
    signal.signal(signal.SIGINT, signal.SIG_IGN if _is_worker() else _interrupted)
