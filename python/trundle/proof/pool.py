"""Work on many cases in parallel processes that end with the one that started them."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from multiprocessing.synchronize import Event
from typing import Any, TypeVar

__all__ = ["in_parallel"]

T = TypeVar("T")

LOOK = 1.0
"""How often a process looks for its parent, s."""


def in_parallel(
    work: Callable[..., T], calls: Sequence[tuple[Any, ...]], jobs: int
) -> Iterator[tuple[int, T]]:
    """Yield the number of each call and what it returned, as they end.

    Parameters
    ----------
    work : callable
        A function of a module, so that another process finds it.
    calls : sequence of tuple
        Its arguments.
    jobs : int
        Processes; with one, the work is done in this process.
    """
    if jobs == 1:
        for number, call in enumerate(calls):
            yield number, work(*call)
        return
    threads = max(1, (os.cpu_count() or 1) // jobs)
    context = multiprocessing.get_context("spawn")
    stop = context.Event()
    pool = ProcessPoolExecutor(jobs, context, initializer=prepared, initargs=(os.getpid(), stop, threads))
    try:
        with interrupts_held():
            futures = {pool.submit(work, *call): number for number, call in enumerate(calls)}
        for future in as_completed(futures):
            yield futures[future], future.result()
    except BaseException:
        # This process waits at its end for what the others are at.
        stop.set()
        raise
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


@contextmanager
def interrupts_held() -> Iterator[None]:
    """Hold back Ctrl-C. Processes that start meanwhile never get it: each would print a traceback."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def prepared(parent: int, stop: Event, threads: int) -> None:
    """Prepare a process: few threads, no answer to Ctrl-C, gone when its parent is or wants it to stop."""
    os.environ["RAYON_NUM_THREADS"] = str(threads)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=watch, args=(parent, stop), daemon=True).start()


def watch(parent: int, stop: Event) -> None:
    """End this process when it has lost its parent, or this wants it to stop."""
    while os.getppid() == parent and not stop.wait(LOOK):
        pass
    os._exit(1)
