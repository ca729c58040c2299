"""Handling of Ctrl-C while the `trundle` command imports its modules: a one-line message, no traceback.

`trundle` imports this module first. It has no effect in programs that use `trundle` as a library.
"""

from __future__ import annotations

import os
import signal
import sys
from types import FrameType

__all__ = ["restore_interrupt"]

MAIN_MODULE_PATH = os.path.join("trundle", "__main__.py")
"""End of `sys.argv[0]` in `python -m trundle`, once the package is imported."""


def _is_command() -> bool:
    """Return whether this process is the `trundle` script, `python -m trundle`, or a worker of either."""
    name = sys.argv[0] if sys.argv else ""
    if name == "-m":
        return "trundle" in sys.orig_argv
    return os.path.splitext(os.path.basename(name))[0] == "trundle" or name.endswith(MAIN_MODULE_PATH)


def _is_worker() -> bool:
    processes = sys.modules.get("multiprocessing.process")
    return processes is not None and processes.parent_process() is not None


def _interrupted(number: int, frame: FrameType | None) -> None:
    # No work has begun. An exception would surface inside whichever module is being imported.
    os.write(2, b"trundle: interrupted\n")
    os._exit(128 + number)


def restore_interrupt() -> None:
    """Restore KeyboardInterrupt on Ctrl-C, once the command line handles it."""
    if signal.getsignal(signal.SIGINT) is _interrupted:
        signal.signal(signal.SIGINT, signal.default_int_handler)


if _is_command() and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
    # Workers ignore Ctrl-C: their parent process terminates them.
    signal.signal(signal.SIGINT, signal.SIG_IGN if _is_worker() else _interrupted)
