"""A progress line on standard error, shown only on a terminal."""

from __future__ import annotations

import math
import shutil
import sys
import time
from types import TracebackType
from typing import TextIO

__all__ = ["Progress", "format_duration"]

MIN_SHARE_FOR_ESTIMATE = 0.02
"""The remaining time is estimated once this share of the work is done."""


class Progress:
    """A progress line that is rewritten in place and erased at the end.

    Parameters
    ----------
    label : str
        Name of the task, such as "fitting".
    total : int, optional
        Number of steps, if known.
    quiet : bool
        Print nothing.
    stream : text stream, optional
        By default standard error. Nothing is printed unless it is a terminal.

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
        self._share = 0.0
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
        """Count one step and show `detail`."""
        self._done += 1
        self.show(detail)

    def share(self, detail: str, done: float) -> None:
        """Show `detail` and the share `done` of the work, 0 to 1. The displayed share never decreases."""
        self._share = max(self._share, done)
        self.show(detail)

    def show(self, detail: str) -> None:
        """Show `detail` without counting a step."""
        if self._shown:
            width = shutil.get_terminal_size().columns - 1
            print(f"\r\033[K{self.line(detail)[:width]}", end="", file=self._stream, flush=True)

    def line(self, detail: str) -> str:
        """Return the line: label, count or share, elapsed and remaining time, detail."""
        elapsed = time.monotonic() - self._began
        share = self._done / self._total if self._total else self._share
        done = ""
        if self._total is not None:
            done = f" {self._done}/{self._total}"
        elif share > 0.0:
            # Rounded down, so that unfinished work is never at 100 %.
            done = f" {math.floor(100 * share)} %"
        left = ""
        if MIN_SHARE_FOR_ESTIMATE <= share < 1.0:
            left = f", about {format_duration(elapsed * (1.0 - share) / share)} left"
        return f"{self._label}{done} ({elapsed:.0f} s{left}){' · ' if detail else ''}{detail}"


def format_duration(seconds: float) -> str:
    """Format a duration, such as "2 h 05 min"."""
    minutes = round(seconds / 60)
    if minutes < 1:
        return f"{seconds:.0f} s"
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60:02} min"
