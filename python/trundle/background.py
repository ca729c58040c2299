"""Long work on a thread of its own, while decisions go on."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

from trundle import _native

__all__ = ["Background", "CancelledError"]

Result = TypeVar("Result")


class CancelledError(Exception):
    """Raised within cancelled work."""


class Background(Generic[Result]):
    """Work on a thread of its own.

    Native work of the thread runs in a pool of one thread of its own, so that it does not delay native work
    of other threads.

    Parameters
    ----------
    work : callable
        Called with a function that long work must call now and then. That function raises `CancelledError`
        after `cancel`.
    """

    def __init__(self, work: Callable[[Callable[[], None]], Result]) -> None:
        self._work = work
        self._is_cancelled = threading.Event()
        self._outcome: Result | None = None
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name="trundle-background", daemon=False)
        self._thread.start()

    def _run(self) -> None:
        try:
            _native._work_in_own_pool()
            self._outcome = self._work(self._check)
        except CancelledError:
            pass
        except BaseException as error:  # `result` raises it in the thread that waits
            self._error = error

    def _check(self) -> None:
        # The interpreter waits for this thread when it exits.
        if self._is_cancelled.is_set() or not threading.main_thread().is_alive():
            raise CancelledError

    @property
    def is_finished(self) -> bool:
        """Whether `result` returns at once."""
        return not self._thread.is_alive()

    def result(self) -> Result | None:
        """Wait for the work and return its result, or raise its exception; None after `cancel`."""
        self._thread.join()
        if self._error is not None:
            raise self._error
        return self._outcome

    def cancel(self) -> None:
        """Stop the work at its next check, without waiting for that."""
        self._is_cancelled.set()
