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
from sheetlight._result import Result

Progress = Callable[[int, int], None]
"""Is told samples that are done, and all that shall be."""

COPY = "copy the dataset to this machine, or read it there by sheetlight.open"
"""What to do with a dataset at a URL."""


def generate(
    recipe: Recipe | str | os.PathLike[str] | Mapping[str, Any],
    n: int,
    out: str | os.PathLike[str],
    *,
    overrides: Mapping[str, Any] | None = None,
    seed: int | None = None,
    threads: int | None = None,
    part: tuple[int, int] | None = None,
    samples_per_shard: int | None = None,
    strict: bool = False,
    progress: Progress | bool | None = None,
) -> Result:
    """Makes a dataset of `n` samples in the folder `out`, or goes on with the one that is there.

    Args:
        recipe: a loaded one, or what `Recipe.load` takes, a dict too; a file is read again
        n: samples that the dataset shall have; a larger number later extends it
        out: folder of the dataset; `sheetlight.scale.generate` makes datasets at URLs
        overrides: changes to the recipe, by the path of the key
        seed: seed of all draws; None for that of the dataset whose folder the recipe was loaded from (`Recipe.seed`), else that of
            the dataset in `out`, else 0
        threads: None for all cores
        part: (k, m) makes every m-th shard from the k-th on, for several machines
        samples_per_shard: None for what stays under about 500 MB and about a minute's work of two cores
        strict: take warnings as errors
        progress: True for a bar of tqdm, in notebooks too; or a function that is called with samples that are done and samples of
            this run, by another thread

    Returns:
        What was made: `out`, `recipe`, `recipe_hash`, `seed`, `samples`, `made_samples`, `made_shards`, `warnings`, ...

    Raises:
        GenError: in the program's words; finished shards are kept, and the same call goes on. Ctrl-C keeps them too.
        TypeError, ValueError: an argument cannot be used, such as a URL for `out`.
    """
    arguments, text = _asked(recipe, n, out, overrides, seed, threads, part, samples_per_shard, strict)
    if progress is True:
        from sheetlight._need import needed

        with needed("tqdm", "plot"):
            from tqdm.auto import tqdm
        with tqdm(total=n, unit="sample", desc=os.fspath(out)) as bar:
            return Result(_gen.run_json([*arguments, "--events"], on_event=_watched(_bar(bar)), text=text))
    told = _watched(progress or None)
    return Result(_gen.run_json([*arguments, "--events"], on_event=told, text=text))


def estimate(
    recipe: Recipe | str | os.PathLike[str] | Mapping[str, Any],
    n: int,
    out: str | os.PathLike[str] | None = None,
    *,
    overrides: Mapping[str, Any] | None = None,
    seed: int | None = None,
    threads: int | None = None,
    part: tuple[int, int] | None = None,
    samples_per_shard: int | None = None,
    strict: bool = False,
) -> Result:
    """Says what `generate` would take: time, disk, memory, shards, samples of each class. Nothing is written.

    Args:
        recipe, n, out, overrides, seed, threads, part, samples_per_shard, strict: as for `generate`; `out` may be left out

    Returns:
        The estimate.

    Raises:
        GenError: in the program's words.
        TypeError, ValueError: an argument cannot be used.
    """
    arguments, text = _asked(recipe, n, out, overrides, seed, threads, part, samples_per_shard, strict)
    return Result(_gen.run_json([*arguments, "--estimate"], text=text))


def validate(
    folder: str | os.PathLike[str],
    *,
    rerender: int | None = None,
    rerender_seed: int | None = None,
    rows: int | None = None,
    rows_seed: int | None = None,
    threads: int | None = None,
    strict: bool = False,
    save: bool = False,
) -> Result:
    """Checks a dataset: files, draws, images, labels, statistics, and samples that are rendered again.

    Args:
        folder: the dataset's
        rerender: samples to render again and compare byte for byte; None for one
        rerender_seed: chooses them; None for 0
        rows: places in each sample to expose again; None for one in each 1000 rows
        rows_seed: chooses them; None for others at each call
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
    options = {"--rerender": rerender, "--rerender-seed": rerender_seed, "--rows": rows, "--rows-seed": rows_seed, "--threads": threads}
    arguments += _options(options)
    arguments += [option for option, asked in {"--strict": strict, "--save": save}.items() if asked]
    try:
        return Result(_gen.run_json(arguments))
    except _gen.GenError as error:
        # Status 1 with a report tells of the faults in it; a refusal, or a report that was not kept, has none.
        with contextlib.suppress(ValueError):
            found = json.loads(error.output)
            if isinstance(found, dict) and "faults" in found:
                return Result(found)
        raise


def report(
    folder: str | os.PathLike[str],
    *,
    out: str | os.PathLike[str] | None = None,
    samples: int = 24,
    frames: int | None = None,
    no_timing: bool = False,
    threads: int | None = None,
) -> Path:
    """Shows a dataset as one HTML page.

    Args:
        folder: the dataset's
        out: where the page goes; None for `reports/report.html` in the folder
        samples: samples that it shows at most
        frames: sensor frames that it shows at most; None for 6
        no_timing: leave out how long reading took, so that the page depends on the dataset alone
        threads: None for all cores

    Returns:
        The page.

    Raises:
        GenError: in the program's words.
        ValueError: `folder` or `out` is a URL.
    """
    folder = local("folder", folder, COPY)
    page = Path(folder) / "reports" / "report.html" if out is None else Path(local("out", out, "name a file on this machine"))
    arguments = ["report", folder, *_options({"--samples": samples, "--frames": frames, "--threads": threads})]
    arguments += [] if out is None else ["--out", str(page)]
    arguments += ["--no-timing"] if no_timing else []
    said = _gen.run(arguments)
    if not page.is_file():
        raise _gen.no_gen(said, arguments)
    return page


def _options(options: Mapping[str, Any]) -> list[str]:
    """Options with a value each; None leaves one out."""
    return [word for option, value in options.items() if value is not None for word in (option, str(value))]


def _asked(
    recipe: Recipe | str | os.PathLike[str] | Mapping[str, Any],
    n: int,
    out: str | os.PathLike[str] | None,
    overrides: Mapping[str, Any] | None,
    seed: int | None,
    threads: int | None,
    part: tuple[int, int] | None,
    samples_per_shard: int | None,
    strict: bool,
) -> tuple[list[str], str | None]:
    """Arguments of a generating run, and what it reads on standard input."""
    folder = None if out is None else local("out", out, "sheetlight.scale.generate makes datasets there")
    if isinstance(recipe, Mapping):
        recipe = Recipe.load(recipe)
    if not isinstance(recipe, Recipe):
        recipe = local("recipe", recipe, "copy the recipe to this machine")
    of_recipe, text = reload_arguments(recipe, overrides)
    arguments = [*of_recipe, "--n", str(n), *([] if folder is None else ["--out", folder])]
    drawn = _seed(recipe, folder) if seed is None else seed
    arguments += _options({"--seed": drawn, "--threads": threads, "--samples-per-shard": samples_per_shard})
    if part is not None:
        if not isinstance(part, (tuple, list)) or len(part) != 2:
            raise ValueError(f"part: {part!r}: give (k, m), the k-th of m parts")
        arguments += ["--part", f"{part[0]}/{part[1]}"]
    return [*arguments, *(["--strict"] if strict else [])], text


def _bar(bar: Any) -> Progress:
    """Tells a bar of tqdm what is done."""

    def told(done: int, of: int) -> None:
        bar.total = of
        bar.update(done - bar.n)

    return told


def _seed(recipe: Recipe | str, out: str | None) -> int | None:
    """The seed of the dataset that the recipe is of, else that of the dataset in `out`; None where there is neither."""
    known = recipe._recipe.dataset_seed if isinstance(recipe, Recipe) else _seed_there(recipe)
    return _seed_there(out) if known is None and out is not None else known


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
