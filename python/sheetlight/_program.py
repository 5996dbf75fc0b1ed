"""What `gen` does with datasets, as functions: the same program in a process of its own."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from sheetlight import _gen, _sheetlight
from sheetlight._arguments import local
from sheetlight._errors import DatasetError
from sheetlight._recipe import Recipe, reload_arguments

Progress = Callable[[int, int], None]
"""Is told samples that are done, and all that shall be."""

COPY = "copy the dataset to this machine, or read it there by sheetlight.open"
"""What to do with a dataset at a URL."""


def generate(
    recipe: Recipe | str | os.PathLike[str],
    n: int,
    out: str | os.PathLike[str],
    *,
    overrides: Mapping[str, Any] | None = None,
    seed: int | None = None,
    threads: int | None = None,
    part: tuple[int, int] | None = None,
    samples_per_shard: int | None = None,
    strict: bool = False,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Makes a dataset of `n` samples in the folder `out`, or goes on with the one that is there.

    Args:
        recipe: a loaded one, or what `Recipe.load` takes; a file is read again
        n: samples that the dataset shall have; a larger number later extends it
        out: folder of the dataset; `sheetlight.scale.generate` makes datasets at URLs
        overrides: changes to the recipe, by the path of the key
        seed: seed of all draws; None for that of the dataset whose folder the recipe was loaded from (`Recipe.seed`), else that of
            the dataset in `out`, else 0
        threads: None for all cores
        part: (k, m) makes every m-th shard from the k-th on, for several machines
        samples_per_shard: None for what stays under about 500 MB and about a minute's work of two cores
        strict: take warnings as errors
        progress: is called with samples that are done and samples of this run, by another thread

    Returns:
        What was made: `out`, `recipe`, `recipe_hash`, `seed`, `samples`, `made_samples`, `made_shards`, `warnings`, ...

    Raises:
        GenError: in the program's words; finished shards are kept, and the same call goes on. Ctrl-C keeps them too.
        TypeError, ValueError: an argument cannot be used, such as a URL for `out`.
    """
    folder = local("out", out, "sheetlight.scale.generate makes datasets there")
    if not isinstance(recipe, Recipe):
        recipe = local("recipe", recipe, "copy the recipe to this machine")
    arguments = [*reload_arguments(recipe, overrides), "--n", str(n), "--out", folder]
    options = {"--seed": _seed(recipe, folder) if seed is None else seed, "--threads": threads, "--samples-per-shard": samples_per_shard}
    for option, value in options.items():
        if value is not None:
            arguments += [option, str(value)]
    if part is not None:
        if not isinstance(part, (tuple, list)) or len(part) != 2:
            raise ValueError(f"part: {part!r}: give (k, m), the k-th of m parts")
        arguments += ["--part", f"{part[0]}/{part[1]}"]
    if strict:
        arguments.append("--strict")
    return _gen.run_json([*arguments, "--events"], on_event=_watched(progress))


def validate(
    folder: str | os.PathLike[str],
    *,
    rerender: int | None = None,
    rows: int | None = None,
    threads: int | None = None,
    strict: bool = False,
    save: bool = False,
) -> dict[str, Any]:
    """Checks a dataset: files, draws, images, labels, statistics, and samples that are rendered again.

    Args:
        folder: the dataset's
        rerender: samples to render again and compare byte for byte; None for one
        rows: places in each sample to expose again; None for one in each 1000 rows
        threads: None for all cores
        strict: take samples of little use as faults
        save: keep the report in the dataset's folder

    Returns:
        The report; `faults` is empty where nothing is wrong. docs/guide/faults.md explains every fault.

    Raises:
        GenError: it could not be checked, or its report not be kept, in the program's words.
        ValueError: `folder` is a URL.
    """
    arguments = ["validate", local("folder", folder, COPY)]
    for option, value in {"--rerender": rerender, "--rows": rows, "--threads": threads}.items():
        if value is not None:
            arguments += [option, str(value)]
    arguments += [option for option, asked in {"--strict": strict, "--save": save}.items() if asked]
    try:
        return _gen.run_json(arguments)
    except _gen.GenError as error:
        # Status 1 with a report tells of the faults in it; a refusal, or a report that was not kept, has none.
        with contextlib.suppress(ValueError):
            found = json.loads(error.output)
            if isinstance(found, dict) and "faults" in found:
                return found
        raise


def report(
    folder: str | os.PathLike[str], *, out: str | os.PathLike[str] | None = None, samples: int = 24, threads: int | None = None
) -> Path:
    """Shows a dataset as one HTML page.

    Args:
        folder: the dataset's
        out: where the page goes; None for `reports/report.html` in the folder
        samples: samples that it shows at most
        threads: None for all cores

    Returns:
        The page.

    Raises:
        GenError: in the program's words.
        ValueError: `folder` or `out` is a URL.
    """
    folder = local("folder", folder, COPY)
    page = Path(folder) / "reports" / "report.html" if out is None else Path(local("out", out, "name a file on this machine"))
    arguments = ["report", folder, "--samples", str(samples)]
    arguments += [] if out is None else ["--out", str(page)]
    arguments += [] if threads is None else ["--threads", str(threads)]
    said = _gen.run(arguments)
    if not page.is_file():
        raise _gen.no_gen(said, arguments)
    return page


def _seed(recipe: Recipe | str, out: str) -> int | None:
    """The seed of the dataset that the recipe is of, else that of the dataset in `out`; None where there is neither."""
    known = recipe._recipe.dataset_seed if isinstance(recipe, Recipe) else _seed_there(recipe)
    return _seed_there(out) if known is None else known


def _seed_there(folder: str) -> int | None:
    if not os.path.lexists(os.path.join(folder, "dataset.json")):
        return None
    try:
        return json.loads(_sheetlight.StoredDataset.read_head(folder))["seed"]
    except DatasetError:
        # The program refuses it too, in its own words.
        return None


def _watched(progress: Progress | None) -> Callable[[dict[str, Any]], None] | None:
    if progress is None:
        return None
    counts = {"done": 0, "all": 0}

    def watch(event: dict[str, Any]) -> None:
        if event["event"] == "begin":
            counts["all"] = event["samples"]
        elif event["event"] == "sample":
            counts["done"] += 1
        else:
            return
        progress(counts["done"], counts["all"])

    return watch
