"""Exit statuses of the command line, and the conversion of exceptions to one-line messages."""

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
"""Status of a program that SIGINT ended, as shells report it."""
BROKEN_PIPE = 141
"""Status of a program that SIGPIPE ended, as shells report it."""

UNPRINTABLE_CATEGORIES = ("Cc", "Cf", "Cs", "Zl", "Zp")
"""Unicode categories of control characters, format characters, surrogates and line breaks."""
PATH_ERRORS = (FileNotFoundError, FileExistsError, NotADirectoryError, IsADirectoryError, PermissionError)


def run_guarded(work: Callable[[], int]) -> int:
    """Run `work` and return its exit status, or that of the exception it raises.

    Parameters
    ----------
    work : callable
        Returns an exit status.

    Returns
    -------
    int
        The status of `work`; 2 for unusable input, 130 if interrupted, 141 if the reader of standard
        output has closed it, 1 for any other exception. A one-line message goes to standard error.
    """
    try:
        restore_interrupt()
        status = work()
        sys.stdout.flush()  # raises BrokenPipeError here, where it is handled
        return status
    except KeyboardInterrupt:
        return _report("interrupted", INTERRUPTED)
    except BrokenPipeError:
        # Python flushes standard output once more at exit: redirect it so that this cannot fail.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE
    except PATH_ERRORS as error:
        return _report(f"{error.filename}: {error.strerror}" if error.filename else str(error), USAGE)
    except OSError as error:
        # A full disk or a limit of the system, not an error of the input.
        return _report(f"{error.filename}: {error.strerror}" if error.filename else str(error), FAILED)
    except ValueError as error:
        return _report(str(error), USAGE)
    except Exception as error:
        hint = "" if _debugging() else " (set TRUNDLE_DEBUG=1 for a traceback)"
        return _report(f"{type(error).__name__}: {error}{hint}", FAILED)


def _report(message: str, status: int) -> int:
    if _debugging():
        traceback.print_exc()
    print(f"trundle: {escape_controls(message)}", file=sys.stderr)
    return status


def escape_controls(text: str) -> str:
    """Escape characters that control a terminal: names and contents of files may contain them."""
    return "".join(
        c if c in "\n\t" or category(c) not in UNPRINTABLE_CATEGORIES else ascii(c)[1:-1] for c in text
    )


def _debugging() -> bool:
    return os.environ.get("TRUNDLE_DEBUG", "") not in ("", "0")
