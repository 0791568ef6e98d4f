"""Flies the runs of a sweep on an executor: all cores of this machine, or a Dask cluster; the numbers are the same."""

import os
import signal
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from typing import Any

from kite_analysis.console.optional_packages import ExtraMissingError
from sim_bridge.errors import ScenarioError
from sim_bridge.runs.fingerprint import code_fingerprint
from sim_bridge.sweeps.worker import fly_batch

Run = tuple[int, dict[str, Any]]  # number, scenario as a dictionary
_BATCH_S = 0.5
_MOST_RUNS = 32  # in a batch
_AT_ONCE = 2  # batches for each worker: one that is flown, one that waits


@contextmanager
def make_executor(jobs: int | None, scheduler: str | None) -> Iterator[tuple[Executor, int]]:
    """A pool of `jobs` processes (as many as there are cores), or the Dask cluster at `scheduler`, with its size.

    Raises:
        ExtraMissingError: dask.distributed is not installed.
        ScenarioError: there is no cluster there.
    """
    if scheduler is None:
        workers = jobs or _cores()
        pool = ProcessPoolExecutor(workers, initializer=_leave_interrupts_to_the_parent)
        try:
            yield pool, workers
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
        threads: Any = client.nthreads()  # by worker
        yield client.get_executor(pure=False), max(1, sum(threads.values()))


def fly_all(executor: Executor, workers: int, runs: Sequence[Run], interpreted: bool,
            take: Callable[[dict[str, Any]], None]) -> None:
    """Fly `runs` on the `workers` of an `executor`, and give `take` each row as it comes in.

    Workers get the runs in batches, so that short flights cost little beside the flying, and hand back what they have
    after _BATCH_S, so that rows of long ones come in as they are flown. Each worker has a second batch waiting.
    """
    code = code_fingerprint()
    waiting = deque(runs)
    flying: dict[Future[list[dict[str, Any]]], list[Run]] = {}
    try:
        while waiting or flying:
            while waiting and len(flying) < _AT_ONCE * workers:
                size = max(1, min(_MOST_RUNS, len(waiting) // (_AT_ONCE * workers)))
                batch = [waiting.popleft() for _ in range(size)]
                flying[executor.submit(fly_batch, batch, code, interpreted, _BATCH_S)] = batch
            ended, _ = wait(flying, return_when=FIRST_COMPLETED)
            for future in ended:
                batch = flying.pop(future)
                rows = future.result()
                for row in rows:
                    take(row)
                waiting.extendleft(reversed(batch[len(rows) :]))
    except BaseException:
        for future in flying:
            future.cancel()
        raise


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _leave_interrupts_to_the_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
