"""Ray: one task for each shard, with Ray's own retries and resources."""

from collections.abc import Generator

import ray

from ..dataset import make_shard
from ..errors import Interruption, Refusal, check_number
from . import Outcome, Tasks

WINDOW = 2000
"""Tasks that Ray knows of at a time: enough to make a cluster grow, few enough to hold."""


def run(tasks: Tasks) -> Generator[Outcome, None, None]:
    """Makes shards on the cluster that this process is connected to, or else on the one that `ray.init()` finds or starts.

    Options are those of `ray.remote`, for instance {"memory": 2e9, "resources": {"render": 1}}.
    """
    if "max_retries" in tasks.options:
        check_number("max_retries", tasks.options["max_retries"], 0)  # for Ray -1 is without end
    starts = not ray.is_initialized()
    if starts:
        ray.init(log_to_driver=False)
    try:
        yield from _run(tasks)
    finally:
        if starts:
            ray.shutdown()


def _run(tasks: Tasks) -> Generator[Outcome, None, None]:
    asked = {"num_cpus": tasks.threads, "max_retries": tasks.retries, "retry_exceptions": [Interruption]}
    try:
        task = ray.remote(make_shard).options(name="sheetlight shard", **(asked | dict(tasks.options)))
    except (TypeError, ValueError) as fault:
        raise Refusal(f"engine_options: {fault}") from None
    waiting = iter(tasks.shards)
    running: dict[ray.ObjectRef, int] = {}
    try:
        while True:
            while len(running) < WINDOW and (shard := next(waiting, None)) is not None:
                running[task.remote(tasks.url, shard, threads=tasks.threads, scratch=tasks.scratch)] = shard
            if not running:
                return
            (done, *_), _ = ray.wait(list(running), num_returns=1)
            yield _outcome(running.pop(done), done)
    finally:
        for left in running:
            ray.cancel(left)


def _outcome(shard: int, done: ray.ObjectRef) -> Outcome:
    try:
        return Outcome(shard, ray.get(done))
    except ray.exceptions.RayTaskError as fault:
        if isinstance(fault.cause, Refusal):
            raise Refusal(str(fault.cause)) from None
        if not isinstance(fault.cause, Interruption):
            raise
        return Outcome(shard, None, str(fault.cause))
    except ray.exceptions.RayError as fault:
        return Outcome(shard, None, f"Ray gave up: {' '.join(str(fault).split())}")
