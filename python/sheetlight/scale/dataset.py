"""One dataset at a URL: begun, made shard by shard, looked at, finished. Engines call `make_shard` alone."""

import hashlib
import json
import operator
import os
import socket
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sheetlight._arguments import local
from sheetlight._gen import Stop
from sheetlight._program import _seed as known_seed
from sheetlight._recipe import Recipe, reload_arguments

from . import program
from .errors import Interruption, Refusal, Unfinished, check_number
from .scratch import scratch_folder
from .store import TEMPORARY, Store

DATASET = "dataset.json"
SHARDS = "shards"
DOCUMENTS = ("README.md", "croissant.json")

TOGETHER = 500
"""Manifests that are held in memory at a time."""


def begin(
    recipe: Recipe | str | os.PathLike[str],
    n: int,
    url: str | os.PathLike[str],
    *,
    seed: int | None = None,
    samples_per_shard: int | None = None,
    overrides: Mapping[str, Any] | Sequence[str] = (),
    scratch: str | os.PathLike[str] | None = None,
) -> dict[str, Any]:
    """Begins a dataset, or takes up the one that is there: a larger `n` extends it, a smaller one changes nothing.

    `dataset.json` is created only where there is none; where there is one, `gen` compares. Several may do this at once.

    Args:
        recipe: a loaded one, or what `Recipe.load` takes: a YAML file, the name of a built-in recipe
        n: samples of the whole dataset
        url: a folder, or `s3://`, `gs://`, `az://`, `hf://buckets/`
        seed: seed of all draws; None for that of the dataset whose folder the recipe was loaded from (`Recipe.seed`), else that
            of the dataset that is there, else 0
        samples_per_shard: samples in a shard; None leaves it to the dataset that is there, or to the recipe
        overrides: changed keys of the recipe, for instance {"camera.tilt_deg": 30}, or as `gen --set` takes them,
            ["camera.tilt_deg=30"]
        scratch: folder for scratch folders; None for $SHEETLIGHT_SCRATCH, or else the system's temporary folder

    Returns:
        `dataset.json`: "samples", "shards", "samples_per_shard", "seed", "recipe", "generator" and more.

    Raises:
        Refusal: faults of the recipe; another dataset lies there, with each difference; the place cannot be written, or lies in
            a dataset.
        Interruption: the store does not answer, or the scratch folder is full.
    """
    store = Store(url)
    changes, texts = (overrides, ()) if isinstance(overrides, Mapping) else ({}, overrides)
    try:
        if not isinstance(recipe, Recipe):
            recipe = local("recipe", recipe, "copy the recipe to this machine")
        of_recipe, said = reload_arguments(recipe, changes)
        asked = [*of_recipe, *(word for text in texts for word in ("--set", text))]
    except (TypeError, ValueError) as fault:
        raise Refusal(str(fault)) from None
    asked += ["--n", str(n), "--part", program.NO_SHARD]
    if samples_per_shard is not None:
        asked += ["--samples-per-shard", str(samples_per_shard)]
    while True:
        there = store.read(DATASET)
        if there is None:
            store.refuse_inside_dataset()
        with scratch_folder(scratch) as folder:
            if there is not None:
                (folder / DATASET).write_bytes(there)
            drawn = known_seed(recipe, str(folder)) if seed is None else seed
            of_seed = [] if drawn is None else ["--seed", str(drawn)]
            try:
                program.run([*asked, *of_seed, "--out", str(folder)], folder, store.url, text=said)
            except Interruption as fault:
                # Nothing was rendered: what it says is of the recipe, or of the dataset that is there.
                raise Refusal(str(fault)) from None
            if not (folder / DATASET).is_file():
                raise program.no_gen()
            document = (folder / DATASET).read_bytes()
            head = json.loads(document)
            if document == there:
                return head
            # What the document names is there before it is.
            store.upload(folder, [asset["path"] for asset in head.get("assets", [])])
            if there is None:
                if not store.create(DATASET, document):
                    continue  # somebody was faster: compare with theirs
            elif store.read(DATASET) == there:
                store.write(DATASET, document)
                _remove_last(store, json.loads(there))
            else:
                continue  # somebody extends it too, maybe further than we do
            store.upload(folder, DOCUMENTS)
            # Who read it before we wrote may have written a smaller number over ours.
            if store.read(DATASET) == document:
                return head


def _remove_last(store: Store, before: dict[str, Any]) -> None:
    """Where the last shard of a dataset was not full before it grew, it is to be made again."""
    if before["samples"] % before["samples_per_shard"]:
        last = before["shards"] - 1
        store.remove(manifest_path(last))


def read_head(store: Store) -> tuple[dict[str, Any], bytes]:
    """`dataset.json` of a dataset that is there, and its bytes.

    Raises:
        Refusal: there is none, or it is another document.
    """
    document = store.read(DATASET)
    if document is None:
        raise Refusal(f"{store.url}: there is no {DATASET}; begin the dataset first, or correct the URL")
    try:
        head = json.loads(document)
        _ = head["generator"]["version"], head["samples"], head["shards"], head["samples_per_shard"], head["recipe"]["hash"]
        _ = head["target"]
    except (ValueError, KeyError, TypeError):
        raise Refusal(f"{store.at(DATASET)}: is no document of a dataset; choose another place") from None
    return head, document


def make_shard(
    url: str, shard: int, *, threads: int = 1, scratch: str | os.PathLike[str] | None = None
) -> dict[str, Any]:
    """Makes one shard of a dataset that was begun: renders it in a scratch folder, uploads its files, its manifest last.

    May be repeated, interrupted, and run twice at once: the bytes are the same. A shard that has its manifest is left as it is.

    Args:
        url: where the dataset is
        shard: its number
        threads: threads that render
        scratch: as for `begin`

    Returns:
        "shard"; "made", False where it was there already; "samples"; "bytes" that were uploaded; "render_s", the time in
        `gen` [s]; "other_s", that before and after it [s]; "host".

    Raises:
        Refusal: there is no such dataset or shard, or another version of `gen` on this machine.
        Interruption: rendering or uploading failed.
    """
    return make_one(url, shard, check_number("threads", threads, 1), scratch, None)


def make_one(
    url: str, shard: int, threads: int, scratch: str | os.PathLike[str] | None, stop: Stop | None
) -> dict[str, Any]:
    """The same for a thread that another one may stop, which is an Interruption."""
    start = time.monotonic()
    store = Store(url, stop)
    head, document = read_head(store)
    program.check_writer(head, store.url, scratch)
    if not 0 <= shard < head["shards"]:
        raise Refusal(f"{store.url}: has shards 0 to {head['shards'] - 1}, and shard {shard} was asked for")
    report = {"shard": shard, "samples": span(head, shard)[1], "host": socket.gethostname()}
    if store.has(manifest_path(shard)):
        return report | {"made": False, "bytes": 0, "render_s": 0.0, "other_s": time.monotonic() - start}
    with scratch_folder(scratch) as folder:
        (folder / DATASET).write_bytes(document)
        fetch_assets(store, head, folder)
        begun = time.monotonic()
        asked = ["--recipe", str(folder), "--n", str(head["samples"]), "--threads", str(threads)]
        place = f"the scratch folder {folder} on {report['host']}"
        program.run([*asked, "--part", f"{shard}/{head['shards']}"], folder, place, stop)
        rendered = time.monotonic()
        (manifest,) = (folder / SHARDS).rglob("*.json")
        files = json.loads(manifest.read_bytes())["files"]
        store.upload(folder, [file["path"] for file in files])
        store.upload(folder, [manifest.relative_to(folder).as_posix()])
        size = sum(file["bytes"] for file in files) + manifest.stat().st_size
    render_s = rendered - begun
    return report | {"made": True, "bytes": size, "render_s": render_s, "other_s": time.monotonic() - start - render_s}


def make(
    url: str | os.PathLike[str],
    part: tuple[int, int] = (0, 1),
    *,
    threads: int = 1,
    scratch: str | os.PathLike[str] | None = None,
) -> list[dict[str, Any]]:
    """Makes the missing shards of a part of a dataset that was begun, one after another: what a task of an array does.

    Args:
        url: where the dataset is
        part: (k, m) for the shards k, k + m, k + 2 m ...
        threads: threads that render
        scratch: as for `begin`

    Returns:
        What `make_shard` returns for each shard that was missing.

    Raises:
        Refusal, Interruption: as `make_shard`.
    """
    try:
        k, m = (operator.index(number) for number in part)
    except (TypeError, ValueError):
        raise Refusal(f"part {part!r}: give two whole numbers (k, m), for instance (0, 4) for the first of four parts") from None
    if not 0 <= k < m:
        raise Refusal(f"part {k}/{m}: give k/m with 0 <= k < m, for instance 0/4 for the first of four parts")
    store = Store(url)
    head, _ = read_head(store)
    return [
        make_shard(store.url, shard, threads=threads, scratch=scratch)
        for shard in missing_shards(store, head)
        if shard % m == k
    ]


def status(url: str | os.PathLike[str]) -> dict[str, Any]:
    """How far a dataset is, by one listing of its manifests.

    Args:
        url: where the dataset is

    Returns:
        "url", "recipe" (name), "seed", "version" (of `gen`), "samples", "samples_per_shard", "shards", "missing" (numbers of
        shards without manifest, ascending), "described" (whether the documents that finishing writes are there).

    Raises:
        Refusal, Interruption: it cannot be read.
    """
    store = Store(url)
    head, _ = read_head(store)
    return {
        "url": store.url,
        "recipe": head["recipe"]["name"],
        "seed": head["seed"],
        "version": head["generator"]["version"],
        "samples": head["samples"],
        "samples_per_shard": head["samples_per_shard"],
        "shards": head["shards"],
        "missing": missing_shards(store, head),
        "described": all(store.has(name) for name in DOCUMENTS),
    }


def finish(url: str | os.PathLike[str], *, scratch: str | os.PathLike[str] | None = None) -> dict[str, Any]:
    """Finishes a dataset whose shards are all there: checks every file's size against the manifests, then writes
    card and metadata, which count the samples. May be repeated.

    A manifest that promises files that are missing or have another size is removed: its shard is to be made again.

    Args:
        url: where the dataset is
        scratch: as for `begin`

    Returns:
        "url", "samples", "shards", "bytes" (of all its files).

    Raises:
        Unfinished: shards are missing, or are to be made again.
        Refusal, Interruption: it cannot be read or written.
    """
    store = Store(url)
    head, document = read_head(store)
    program.check_writer(head, store.url, scratch)
    _raise_missing(store, missing_shards(store, head), "have no manifest")
    sizes = store.sizes()
    total, wrong = len(document), []
    with scratch_folder(scratch) as folder:
        (folder / DATASET).write_bytes(document)
        for first in range(0, head["shards"], TOGETHER):
            shards = {manifest_path(shard): shard for shard in range(first, min(first + TOGETHER, head["shards"]))}
            manifests = store.read_all(shards)
            for path, shard in shards.items():
                of_files = _bytes_of(manifests.get(path, b""), head, shard, sizes)
                if of_files is None:
                    store.remove(path)
                    wrong.append(shard)
                    continue
                (folder / path).parent.mkdir(parents=True, exist_ok=True)
                (folder / path).write_bytes(manifests[path])
                total += of_files + len(manifests[path])
        _raise_missing(store, wrong, "were not as their manifests say, which are removed,")
        program.run(["finish", str(folder)], folder, store.url)
        store.upload(folder, DOCUMENTS)
    for path in sizes:
        # What a killed upload to a folder left. One that is under way meanwhile is tried again by its writer.
        if TEMPORARY.match(path.rpartition("/")[2]):
            store.remove(path)
    return {"url": store.url, "samples": head["samples"], "shards": head["shards"], "bytes": total}


def span(head: dict[str, Any], shard: int) -> tuple[int, int]:
    """First sample of a shard, and how many it holds."""
    first = shard * head["samples_per_shard"]
    return first, min(head["samples_per_shard"], head["samples"] - first)


def manifest_path(shard: int) -> str:
    """Path of a shard's manifest in its dataset: folders of a thousand, the first one without a folder of its own."""
    thousand = shard // 1000
    return f"{SHARDS}/{shard:05}.json" if thousand == 0 else f"{SHARDS}/{thousand:03}/{shard:05}.json"


def missing_shards(store: Store, head: dict[str, Any]) -> list[int]:
    """Numbers of shards without manifest, ascending: one listing."""
    there = store.sizes(SHARDS)
    return [shard for shard in range(head["shards"]) if manifest_path(shard) not in there]


def fetch_assets(store: Store, head: dict[str, Any], folder: Path) -> None:
    """Copies the files that the recipe names beside a `dataset.json` in a folder of this machine.

    Raises:
        Refusal: one is missing, or is not the one that the document names.
    """
    for asset in head.get("assets", []):
        path, content = asset["path"], store.read(asset["path"])
        if content is None or hashlib.sha256(content).hexdigest() != asset["sha256"]:
            what = "is missing" if content is None else "is not the file that the dataset was begun with"
            raise Refusal(f"{store.at(path)}: {what}; copy {asset['name']} there again, or begin at another place")
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(content)


def _bytes_of(content: bytes, head: dict[str, Any], shard: int, sizes: dict[str, int]) -> int | None:
    """Size of the files of a manifest [bytes]; None unless it is of this dataset as it is now, and they are there in full."""
    try:
        manifest = json.loads(content)
        files = {file["path"]: file["bytes"] for file in manifest["files"]}
        is_own = (
            manifest["recipe_hash"] == head["recipe"]["hash"]
            and manifest["seed"] == head["seed"]
            and manifest["generator"] == head["generator"]
            and (manifest["first"], manifest["count"]) == span(head, shard)
        )
    except (ValueError, KeyError, TypeError):
        return None
    return sum(files.values()) if is_own and all(sizes.get(path) == size for path, size in files.items()) else None


def _raise_missing(store: Store, missing: list[int], what: str) -> None:
    if missing:
        told = ", ".join(str(shard) for shard in missing[:8]) + (", ..." if len(missing) > 8 else "")
        raise Unfinished(
            f"{store.url}: {len(missing)} shards {what} and are to be made: {told}; run the same again", missing
        )
