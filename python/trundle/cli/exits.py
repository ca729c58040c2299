"""How a run of the command line ends: what went wrong becomes one sentence and an exit status."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Callable
from unicodedata import category

from trundle._startup import restore_interrupt

__all__ = ["BROKEN_PIPE", "FAILED", "INTERRUPTED", "USAGE", "escape_controls", "run_guarded"]

FAILED = 1
USAGE = 2
INTERRUPTED = 130
"""What a shell reports for a program that SIGINT ended."""
BROKEN_PIPE = 141
"""What a shell reports for a program that SIGPIPE ended."""

UNPRINTABLE_CATEGORIES = ("Cc", "Cf", "Cs", "Zl", "Zp")
"""Unicode's categories of control characters, of invisible ones, and of line breaks."""
PATH_ERRORS = (FileNotFoundError, FileExistsError, NotADirectoryError, IsADirectoryError, PermissionError)


def run_guarded(work: Callable[[], int]) -> int:
    """Return the exit status of `work`, whatever it raises.

    Parameters
    ----------
    work : callable
        Does everything and returns its own exit status.

    Returns
    -------
    int
        Its status; 2 if the input was unusable, 130 if interrupted, 141 if the reader of standard output
        went away, 1 for anything else. The reason stands on standard error in one sentence.
    """
    try:
        restore_interrupt()
        status = work()
        sys.stdout.flush()  # here, where a reader that went away can still be handled
        return status
    except KeyboardInterrupt:
        return _report("interrupted", INTERRUPTED)
    except BrokenPipeError:
        # Python flushes standard output once more at exit: give it somewhere to go.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE
    except PATH_ERRORS as error:
        return _report(f"{error.filename}: {error.strerror}" if error.filename else str(error), USAGE)
    except OSError as error:
        # A full disk, a limit: not a matter of what was asked.
        return _report(f"{error.filename}: {error.strerror}" if error.filename else str(error), FAILED)
    except ValueError as error:
        return _report(str(error), USAGE)
    except Exception as error:
        hint = "" if _debugging() else " (TRUNDLE_DEBUG=1 shows where)"
        return _report(f"{type(error).__name__}: {error}{hint}", FAILED)


def _report(sentence: str, status: int) -> int:
    if _debugging():
        traceback.print_exc()
    print(f"trundle: {escape_controls(sentence)}", file=sys.stderr)
    return status


def escape_controls(text: str) -> str:
    """Return a text with all that steers a terminal escaped: names and contents of files may hold it."""
    return "".join(
        c if c in "\n\t" or category(c) not in UNPRINTABLE_CATEGORIES else ascii(c)[1:-1] for c in text
    )


def _debugging() -> bool:
    return os.environ.get("TRUNDLE_DEBUG", "") not in ("", "0")
