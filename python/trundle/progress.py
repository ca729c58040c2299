"""Progress bars of long calls, in terminals and notebooks, drawn by tqdm."""

from __future__ import annotations

import importlib
import math
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Any, TextIO, TypeAlias

__all__ = ["Progress", "ProgressOption", "format_duration", "report_progress"]

ShareCallback: TypeAlias = Callable[[str, float], object]
ProgressOption: TypeAlias = "bool | ShareCallback | None"
"""True: a bar; False: none; None: a bar in notebooks; a function: receives stage and finished share."""

PERCENT = 100
SHARE_FORMAT = "{desc}: {percentage:3.0f}%|{bar}| {elapsed}<{remaining}{postfix}"
STEP_FORMAT = "{desc}: {n_fmt}/{total_fmt}|{bar}| {elapsed}<{remaining}{postfix}"
"""Formats of tqdm: finished part, bar, elapsed and remaining time, stage."""


class Progress:
    """A progress bar that is removed at the end.

    Parameters
    ----------
    label : str
        Name of the task, such as "fitting".
    total : int, optional
        Number of steps, if known.
    quiet : bool
        Show nothing.
    stream : text stream, optional
        By default standard error. Nothing is shown unless it is a terminal or the cell of a notebook.

    Examples
    --------
    >>> with Progress("fitting", total=3) as progress:
    ...     for start in range(3):
    ...         progress.step(f"start {start + 1}")
    """

    def __init__(
        self, label: str, total: int | None = None, *, quiet: bool = False, stream: TextIO | None = None
    ) -> None:
        self._label, self._total = label, total
        self._stream = sys.stderr if stream is None else stream
        self._shown = not quiet and (self._stream.isatty() or (stream is None and in_notebook()))
        self._bar: Any = None

    def __enter__(self) -> Progress:
        if self._shown:
            self._bar = make_bar(self._label, self._total, self._stream)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar is not None:
            self._bar.close()

    def step(self, detail: str = "") -> None:
        """Count one step and show `detail`."""
        if self._bar is not None:
            self._bar.n += 1
            self.show(detail)

    def share(self, detail: str, done: float) -> None:
        """Show `detail` and the share `done` of the work, 0 to 1. The displayed share never decreases."""
        if self._bar is not None:
            self._bar.total, self._bar.bar_format = PERCENT, SHARE_FORMAT
            # Rounded down, so that unfinished work is never at 100 %.
            self._bar.n = max(self._bar.n, math.floor(PERCENT * min(done, 1.0)))
            self.show(detail)

    def show(self, detail: str) -> None:
        """Show `detail` without counting a step."""
        if self._bar is not None:
            self._bar.set_postfix_str(detail)


@contextmanager
def report_progress(option: ProgressOption, label: str) -> Iterator[ShareCallback | None]:
    """Yield the function to which a long call reports its progress, or None.

    Parameters
    ----------
    option : bool, callable or None
        True shows a bar on a terminal and in notebooks; None only in notebooks; False none. A function is
        called with the stage of the work and the finished share of all work, 0 to 1.
    label : str
        Name of the task in front of the bar.
    """
    if callable(option):
        yield option
    elif option or (option is None and in_notebook()):
        with Progress(label) as progress:
            yield progress.share
    else:
        yield None


def in_notebook() -> bool:
    """Return whether the code runs in the kernel of a notebook."""
    shell = sys.modules.get("IPython")
    instance = None if shell is None else shell.get_ipython()
    return instance is not None and "IPKernelApp" in getattr(instance, "config", {})


def make_bar(label: str, total: int | None, stream: TextIO) -> Any:
    """Return a bar of tqdm: a widget in notebooks that have ipywidgets, otherwise text."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # tqdm recommends ipywidgets
        tqdm = importlib.import_module("tqdm.auto").tqdm
        # Without its thread, which a fork would not copy.
        bar = type("Bar", (tqdm,), {"monitor_interval": 0})
        text = "{desc} [{elapsed}]{postfix}" if total is None else STEP_FORMAT
        # Without smoothing, the remaining time is that at the mean speed so far.
        return bar(
            desc=label,
            total=total,
            file=stream,
            leave=False,
            smoothing=0,
            bar_format=text,
            dynamic_ncols=True,
        )


def format_duration(seconds: float) -> str:
    """Format a duration, such as "2 h 05 min"."""
    minutes = round(seconds / 60)
    if minutes < 1:
        return f"{seconds:.0f} s"
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60:02} min"
