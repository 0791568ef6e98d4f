"""Flies the runs of a sweep on an executor: all cores of this machine, or a Dask cluster; the numbers are the same."""

import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from typing import Any

from kite_analysis.console.optional_packages import ExtraMissingError
from sim_bridge.errors import ScenarioError
from sim_bridge.runs.fingerprint import code_fingerprint
from sim_bridge.sweeps.worker import fly_run


@contextmanager
def make_executor(jobs: int | None, scheduler: str | None) -> Iterator[Executor]:
    """A pool of `jobs` processes (as many as there are cores), or the Dask cluster at `scheduler`.

    Raises:
        ExtraMissingError: dask.distributed is not installed.
        ScenarioError: there is no cluster there.
    """
    if scheduler is None:
        workers = jobs or len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else jobs
        pool = ProcessPoolExecutor(workers, initializer=_leave_interrupts_to_the_parent)
        try:
            yield pool
        finally:
            pool.shutdown(wait=True, cancel_futures=True)
        return
    try:
        from distributed import Client  # noqa: PLC0415  an extra, and slow to load
    except ImportError:
        raise ExtraMissingError("--scheduler needs dask.distributed: pip install 'kitepilot[cluster]'") from None
    try:
        client = Client(scheduler, timeout="10s")
    except (OSError, ValueError) as error:
        raise ScenarioError(f"--scheduler {scheduler}: no Dask scheduler there ({error})") from error
    with client:
        yield client.get_executor(pure=False)


def fly_all(executor: Executor, runs: Sequence[tuple[int, dict[str, Any]]], take: Callable[[dict[str, Any]], None]
            ) -> None:
    """Fly `runs` (number, scenario as a dictionary) and give `take` each row as it comes in."""
    futures = [executor.submit(fly_run, number, content, code_fingerprint()) for number, content in runs]
    try:
        for future in as_completed(futures):
            take(future.result())
    except BaseException:
        for future in futures:
            future.cancel()
        raise


def _leave_interrupts_to_the_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
