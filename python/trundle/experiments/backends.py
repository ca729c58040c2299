"""Backends that run independent calls: local processes, joblib, or a Ray cluster.

A backend only decides where a call runs. Results do not depend on it: callers identify them by the number of
the call, and store them themselves.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.synchronize import Event
from typing import Any, Protocol, TypeVar

from trundle._native import TrundleError
from trundle._optional import require

__all__ = ["BACKENDS", "Backend", "Joblib", "Local", "Ray", "backend", "in_order"]

T = TypeVar("T")

BACKENDS = ("local", "joblib", "ray")
PARENT_CHECK_SECONDS = 1.0
"""Interval at which a worker process checks whether its parent still exists."""
RAY_TASKS_PER_CPU = 2
"""Tasks submitted at a time for each processor of the cluster, so that processors do not wait."""


class Backend(Protocol):
    """Runs independent calls."""

    def map(self, work: Callable[..., T], calls: Sequence[tuple[Any, ...]]) -> Iterator[tuple[int, T]]:
        """Yield the number of each call and its result, in the order in which they finish.

        Parameters
        ----------
        work : callable
            A module-level function, so that another process can import it.
        calls : sequence of tuple
            Positional arguments, one tuple for each call.
        """


def backend(name: str = "local", jobs: int | None = None, address: str | None = None) -> Backend:
    """Return a backend by name.

    Parameters
    ----------
    name : {"local", "joblib", "ray"}
    jobs : int, optional
        Processes; by default 1, or all processors of the cluster for "ray".
    address : str, optional
        Of a running Ray cluster, "auto" or "ray://host:10001". By default Ray starts one on this machine.

    Raises
    ------
    TrundleError
        If the name is unknown, its package is missing, or an address is given without "ray".
    """
    if name not in BACKENDS:
        raise TrundleError(f"backend = {name!r}: choose {', '.join(BACKENDS)}")
    if address is not None and name != "ray":
        raise TrundleError(f"address = {address!r}: only the backend ray takes an address, not {name}")
    if name == "ray":
        import_ray()
        return Ray(jobs, address)
    if name == "joblib":
        import_joblib()
        return Joblib(jobs or 1)
    return Local(jobs or 1)


def in_order(where: Backend, work: Callable[..., T], calls: Sequence[tuple[Any, ...]]) -> Iterator[T]:
    """Yield the results in the order of the calls, each as soon as all earlier calls are finished."""
    waiting: dict[int, T] = {}
    following = 0
    for number, result in where.map(work, calls):
        waiting[number] = result
        while following in waiting:
            yield waiting.pop(following)
            following += 1


def import_ray() -> Any:
    """Import Ray."""
    return require("ray", "ray", "clusters of --backend ray")


def import_joblib() -> Any:
    """Import joblib."""
    return require("joblib", "joblib", "processes of --backend joblib")


@dataclass(frozen=True)
class Local:
    """Processes of this machine. They end with the process that started them.

    Attributes
    ----------
    jobs : int
        Processes; with one, the calls run in this process.
    """

    jobs: int = 1

    def map(self, work: Callable[..., T], calls: Sequence[tuple[Any, ...]]) -> Iterator[tuple[int, T]]:
        """Yield the number of each call and its result, in the order in which they finish."""
        if self.jobs == 1:
            for number, call in enumerate(calls):
                yield number, work(*call)
            return
        context = multiprocessing.get_context("spawn")
        stop = context.Event()
        arguments = (os.getpid(), stop, threads_per_job(self.jobs))
        pool = ProcessPoolExecutor(self.jobs, context, initializer=start_worker, initargs=arguments)
        try:
            with interrupts_blocked():
                futures = {pool.submit(work, *call): number for number, call in enumerate(calls)}
            for future in as_completed(futures):
                yield futures[future], future.result()
        except BaseException:
            # Otherwise this process would wait for running calls when it exits.
            stop.set()
            pool.shutdown(wait=False, cancel_futures=True)
            raise
        pool.shutdown()


def threads_per_job(jobs: int) -> int:
    """Return how many threads each of several processes of this machine may use."""
    return max(1, (os.cpu_count() or 1) // jobs)


@contextmanager
def interrupts_blocked() -> Iterator[None]:
    """Block SIGINT. Processes that start in this context inherit the mask, so Ctrl-C prints no traceback."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def start_worker(parent: int, stop: Event, threads: int) -> None:
    """Prepare a worker process: limit its threads, ignore Ctrl-C, end with the parent or on `stop`."""
    os.environ["RAYON_NUM_THREADS"] = str(threads)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=end_with_parent, args=(parent, stop), daemon=True).start()


def end_with_parent(parent: int, stop: Event) -> None:
    """End this process when the parent has ended or `stop` is set."""
    while os.getppid() == parent and not stop.wait(PARENT_CHECK_SECONDS):
        pass
    os._exit(1)


@dataclass(frozen=True)
class Joblib:
    """joblib's processes, or those of the backend that `joblib.parallel_config` selects.

    Attributes
    ----------
    jobs : int
        Processes.
    """

    jobs: int = 1

    def map(self, work: Callable[..., T], calls: Sequence[tuple[Any, ...]]) -> Iterator[tuple[int, T]]:
        """Yield the number of each call and its result, in the order in which they finish."""
        joblib = import_joblib()
        parallel = joblib.Parallel(n_jobs=self.jobs, return_as="generator_unordered", pre_dispatch="all")
        threads = threads_per_job(self.jobs)
        with interrupts_blocked():
            results = parallel(
                joblib.delayed(numbered)(threads, number, work, call) for number, call in enumerate(calls)
            )
        yield from results


def numbered(threads: int, number: int, work: Callable[..., T], call: tuple[Any, ...]) -> tuple[int, T]:
    """Return the number of a call and its result, computed with at most so many threads."""
    os.environ["RAYON_NUM_THREADS"] = str(threads)
    return number, work(*call)


@dataclass(frozen=True)
class Ray:
    """A Ray cluster. A call whose worker or node is lost runs again elsewhere.

    Every node needs trundle of the same version, and the folders that the calls name, through a shared file
    system.

    Attributes
    ----------
    jobs : int, optional
        Processors of the cluster that is started on this machine; all by default.
    address : str, optional
        Of a running cluster, which is used instead.
    """

    jobs: int | None = None
    address: str | None = None

    def map(self, work: Callable[..., T], calls: Sequence[tuple[Any, ...]]) -> Iterator[tuple[int, T]]:
        """Yield the number of each call and its result, in the order in which they finish."""
        ray = import_ray()
        with self.connected(ray):
            task = ray.remote(num_cpus=1)(numbered)
            most = RAY_TASKS_PER_CPU * max(1, int(ray.cluster_resources().get("CPU", 1)))
            waiting, pending = iter(enumerate(calls)), set()
            try:
                while True:
                    for number, call in waiting:
                        pending.add(task.remote(1, number, work, call))
                        if len(pending) >= most:
                            break
                    if not pending:
                        return
                    done, _ = ray.wait(list(pending), num_returns=1)
                    pending -= set(done)
                    yield from ray.get(done)
            finally:
                for one in pending:
                    ray.cancel(one, force=True)

    @contextmanager
    def connected(self, ray: Any) -> Iterator[None]:
        """Connect to the cluster, or start one, unless the program has done so."""
        if ray.is_initialized():
            yield
            return
        cpus = {} if self.address is not None else {"num_cpus": self.jobs}
        try:
            ray.init(address=self.address, log_to_driver=False, logging_level="error", **cpus)
        except ConnectionError as error:
            raise TrundleError(
                f"address = {self.address!r}: no Ray cluster at this address: {error}"
            ) from error
        try:
            yield
        finally:
            with suppress(KeyboardInterrupt):
                ray.shutdown()
