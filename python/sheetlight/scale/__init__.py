"""Datasets by many machines, into a folder or a bucket.

>>> import sheetlight.scale
>>> sheetlight.scale.generate("wood-small", 10_000, "s3://bucket/planks", engine="ray")       # doctest: +SKIP

A shard follows from recipe, seed, number and version alone, so there is nothing to coordinate: a task renders one in a scratch
folder, uploads its files and its manifest last; what has no manifest is made when the same call runs again. Ray, Slurm and
Kubernetes repeat what fails. `python -m sheetlight.scale` is the same for scripts.
"""

import contextlib
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from sheetlight._recipe import Recipe

from . import dataset
from .dataset import begin, finish, make, make_shard, status
from .engines import Outcome, Tasks
from .engines import engine as _engine
from .errors import Interruption, Refusal, ScaleError, Unfinished, check_number
from .progress import Progress, ProgressLine
from .store import Store

__all__ = [
    "Interruption", "Progress", "ProgressLine", "Refusal", "ScaleError", "Unfinished",
    "begin", "finish", "generate", "make", "make_shard", "status",
]  # fmt: skip

ROUNDS = 3
"""How often a run looks for shards that are to be made: others may extend the dataset, or files may be lost."""


def generate(
    recipe: Recipe | str | os.PathLike[str],
    n: int,
    url: str | os.PathLike[str],
    engine: str = "ray",
    seed: int | None = None,
    samples_per_shard: int | None = None,
    *,
    overrides: Mapping[str, Any] | Sequence[str] = (),
    threads: int = 1,
    retries: int = 5,
    scratch: str | os.PathLike[str] | None = None,
    progress: Callable[[Progress], None] | None = None,
    engine_options: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Makes a dataset, or what is missing of it, and finishes it. The bytes are those of `gen` on one machine.

    Args:
        recipe: a loaded one, or what `Recipe.load` takes: a YAML file, the name of a built-in recipe
        n: samples of the whole dataset; a larger number later extends it, a smaller one of an unfinished dataset is refused
        url: a folder (that all machines see), `s3://`, `gs://`, `az://` or `hf://buckets/`. Credentials come from the
            environment of each machine, as the store's own tools find them
        engine: "ray", or "local" for the processes of one machine
        seed: seed of all draws; None for that of the dataset whose folder the recipe was loaded from (`Recipe.seed`), else that
            of the dataset that is there, else 0
        samples_per_shard: samples of a shard, which is a task: minutes are right. None leaves it to the dataset that is there,
            or to the recipe
        overrides: changed keys of the recipe, for instance {"camera.tilt_deg": 30}, or as `gen --set` takes them
        threads: threads, and for Ray cores, of a task
        retries: how often a task is repeated at most
        scratch: folder for scratch folders, on the machine of the task; None for $SHEETLIGHT_SCRATCH, or else the system's
            temporary folder
        progress: is called when something changed; None for lines on standard error
        engine_options: what only this engine understands: for Ray the options of `ray.remote`, else "workers"

    Returns:
        "url", "samples", "shards", "bytes" of the dataset; "made_shards", "made_samples" of this run; "render_s" and
        "other_s", the time of its tasks in `gen` and outside [s].

    Raises:
        Refusal: trying again changes nothing; before any task starts where recipe, place or engine are at fault.
        Unfinished: shards were given up; the same call makes them.
        Interruption: the store does not answer, or the scratch folder is full.
    """
    engine_module = _engine(engine)
    threads, retries = check_number("threads", threads, 1), check_number("retries", retries, 0)
    show = progress or ProgressLine()
    seen = Progress(Store(url).url, 0, 0)
    for left in reversed(range(ROUNDS)):
        # Somebody may have extended it meanwhile, or written a smaller number over ours.
        head = begin(recipe, n, url, seed=seed, samples_per_shard=samples_per_shard, overrides=overrides, scratch=scratch)
        store = Store(url)
        missing = dataset.missing_shards(store, head)
        if missing and head["samples"] > n and left == ROUNDS - 1:
            raise Refusal(
                f"{store.url}: was begun with {head['samples']} samples, of which {len(missing)} shards are missing, and {n} are "
                f"asked for; ask for {head['samples']}, or choose another place"
            )
        there = head["shards"] - len(missing)
        seen.shards, seen.finished, seen.failed = head["shards"], there, 0
        show(seen)
        tasks = Tasks(store.url, missing, threads, retries, None if scratch is None else str(scratch), engine_options or {})
        if missing:
            with contextlib.closing(engine_module.run(tasks)) as outcomes:
                _count(outcomes, seen, show)
        try:
            done = finish(url, scratch=scratch)
        except Unfinished:
            if not left:
                raise
            continue
        if done["samples"] >= n:
            break
    return done | {
        "made_shards": seen.made, "made_samples": seen.samples, "render_s": seen.render_s, "other_s": seen.other_s
    }  # fmt: skip


def _count(outcomes: Iterable[Outcome], seen: Progress, show: Callable[[Progress], None]) -> None:
    """Counts what the engine makes.

    Raises:
        Unfinished: shards were given up.
    """
    faults: dict[int, str] = {}
    for outcome in outcomes:
        if outcome.report is None:
            faults[outcome.shard] = outcome.fault
            seen.failed += 1
        else:
            seen.finished += 1
            seen.made += outcome.report["made"]
            seen.samples += outcome.report["samples"] if outcome.report["made"] else 0
            seen.bytes += outcome.report["bytes"]
            seen.render_s += outcome.report["render_s"]
            seen.other_s += outcome.report["other_s"]
        show(seen)
    if faults:
        shard = min(faults)
        raise Unfinished(
            f"{seen.url}: {len(faults)} of {seen.shards} shards were given up; shard {shard}: {faults[shard]}; "
            "the same call goes on with them",
            sorted(faults),
        )
