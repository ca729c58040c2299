"""A line on standard error that says what takes the time; only where a person watches."""

from __future__ import annotations

import shutil
import sys
import time
from types import TracebackType
from typing import TextIO

__all__ = ["Progress"]


class Progress:
    """A progress line, rewritten in place, gone at the end.

    Parameters
    ----------
    label : str
        What is being done, "fitting".
    total : int, optional
        Number of steps, if known.
    quiet : bool
        Print nothing.
    stream : text stream, optional
        Where to; standard error by default. Nothing is printed unless it is a terminal.

    Examples
    --------
    >>> with Progress("fitting", total=3) as progress:
    ...     for start in range(3):
    ...         progress.step(f"start {start + 1}")
    """

    def __init__(
        self, label: str, total: int | None = None, *, quiet: bool = False, stream: TextIO | None = None
    ) -> None:
        self._label = label
        self._total = total
        self._stream = sys.stderr if stream is None else stream
        self._shown = not quiet and self._stream.isatty()
        self._done = 0
        self._began = time.monotonic()

    def __enter__(self) -> Progress:
        self.show("")
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._shown:
            print("\r\033[K", end="", file=self._stream, flush=True)

    def step(self, detail: str = "") -> None:
        """Count one step as done and show `detail`."""
        self._done += 1
        self.show(detail)

    def show(self, detail: str) -> None:
        """Show `detail` without counting a step."""
        if self._shown:
            width = shutil.get_terminal_size().columns - 1
            print(f"\r\033[K{self.line(detail)[:width]}", end="", file=self._stream, flush=True)

    def line(self, detail: str) -> str:
        """Return the line as it would be shown: label, count, seconds, detail."""
        count = f" {self._done}/{self._total}" if self._total is not None else ""
        elapsed = time.monotonic() - self._began
        return f"{self._label}{count} ({elapsed:.0f} s){' · ' if detail else ''}{detail}"
