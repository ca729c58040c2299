"""Work on many cases in parallel processes that end with the one that started them."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import Any, TypeVar

__all__ = ["in_parallel"]

T = TypeVar("T")


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
    pool = ProcessPoolExecutor(jobs, context, initializer=prepared, initargs=(os.getpid(), threads))
    try:
        futures = {pool.submit(work, *call): number for number, call in enumerate(calls)}
        for future in as_completed(futures):
            yield futures[future], future.result()
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def prepared(parent: int, threads: int) -> None:
    """Prepare a process: few threads, no answer to Ctrl-C, gone when its parent is."""
    os.environ["RAYON_NUM_THREADS"] = str(threads)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=watch, args=(parent,), daemon=True).start()


def watch(parent: int) -> None:
    """End this process when it has lost its parent."""
    while os.getppid() == parent:
        time.sleep(1.0)
    os._exit(1)
