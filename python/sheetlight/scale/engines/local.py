"""Processes of this machine, side by side: each thread here starts a `gen` and waits for it."""

import concurrent.futures
import os
from collections.abc import Generator
from typing import Any

from sheetlight import _gen

from ..dataset import make_one
from ..errors import Interruption, Refusal, check_number
from . import Outcome, Tasks

PAUSE_S = 0.5
"""Pause before a task is repeated [s]."""


def run(tasks: Tasks) -> Generator[Outcome, None, None]:
    """Makes shards. Option "workers": tasks side by side, else as many as the cores allow."""
    options = dict(tasks.options)
    workers = options.pop("workers", None)
    workers = max(1, _cores() // tasks.threads) if workers is None else check_number("workers", workers, 1)
    if options:
        raise Refusal(f"engine_options: the local engine knows \"workers\" and not {', '.join(map(repr, options))}")
    stop = _gen.Stop()

    def task(shard: int) -> dict[str, Any]:
        left = tasks.retries
        while True:
            try:
                return make_one(tasks.url, shard, tasks.threads, tasks.scratch, stop)
            except Interruption:
                # Ctrl-C stops `gen` too, perhaps before it is known here.
                if not left or stop.wait(PAUSE_S):
                    raise
                left -= 1

    with concurrent.futures.ThreadPoolExecutor(workers) as pool:
        shards = {pool.submit(task, shard): shard for shard in tasks.shards}
        try:
            for done in concurrent.futures.as_completed(shards):
                try:
                    yield Outcome(shards[done], done.result())
                except Interruption as fault:
                    yield Outcome(shards[done], None, str(fault))
        finally:
            # First what waits, then what runs: a signal reaches this thread alone.
            pool.shutdown(wait=False, cancel_futures=True)
            stop.set()


def _cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
