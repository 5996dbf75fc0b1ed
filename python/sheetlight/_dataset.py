"""Datasets that were written, in a folder or a bucket."""

from __future__ import annotations

import contextlib
import errno
import html
import hashlib
import json
import os
import shutil
import sys
import tempfile
import threading
import time
import uuid
import weakref
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path, PurePosixPath
from typing import Any

from sheetlight import _sheetlight
from sheetlight._arguments import is_url, local, whole
from sheetlight._errors import DatasetError
from sheetlight._need import needed
from sheetlight._sample import Facts, Sample

SPLITS = ("train", "validation", "test")

ATTEMPTS = 5
"""How often a request of a store is tried."""

PAUSE_S = 0.25
"""Pause before the second attempt [s]; each further one is twice as long."""

FULL = tuple(getattr(errno, name) for name in ("ENOSPC", "EDQUOT", "EROFS", "EFBIG") if hasattr(errno, name))
"""Faults of this machine's disk."""

REQUESTS = 16
"""Manifests that are asked for at the same time."""

SHARDS_AT_ONCE = 4096
"""Manifests that may wait in memory."""


class Dataset(Sequence[Sample]):
    """The finished samples of a dataset, or of one of its splits; get one by `open`.

    A sequence: `len(dataset)`, `dataset[k]`, `for sample in dataset`; `sample(index)` goes by the number of the sample instead.
    Maps are read when they are asked for, from the EXR file where the dataset has one, else from the table.
    """

    def __init__(self, place: str | os.PathLike[str], split: str | None, dark: bool, cache: str | os.PathLike[str] | None):
        if split is not None and split not in SPLITS:
            raise ValueError(f"split: {split!r} is none, these are {', '.join(SPLITS)}, or None for all")
        self._remote: _Remote | None = None
        # Where the working directory changes, or a worker has another one, it is the same folder.
        if cache is not None:
            cache = os.path.abspath(local("cache", cache, "name a folder on this machine"))
        if isinstance(place, str) and is_url(place):
            self._place, self._remote = place, _Remote(place, cache)
        else:
            self._place = os.path.abspath(local("place", place, "give it as a text with both slashes, such as 's3://bucket/boards'"))
        self._split, self._dark, self._cache = split, dark, cache
        self._reading = self._remote.reading if self._remote else contextlib.nullcontext
        with self._reading():
            self._stored = _sheetlight.StoredDataset.open(self._remote.folder if self._remote else self._place)
        self._facts = Facts(json.loads(self._stored.head()))
        listed = self._stored.samples()
        self._indices = [index for index, part, _ in listed if split in (None, part)]

    def __reduce__(self) -> tuple[Any, ...]:
        return Dataset, (self._place, self._split, self._dark, self._cache)

    def __repr__(self) -> str:
        of = f" of {self._split}" if self._split else ""
        return f"<Dataset {self.name} at {self._place}: {len(self)} samples{of}>"

    def _repr_html_(self) -> str:
        from sheetlight._result import as_html

        facts = {"samples": len(self), "classes": self.classes, "rows, columns [px]": list(self.shape), "seed": self.seed}
        first = self[0]._repr_html_() if len(self) else ""
        return f"<div>{html.escape(repr(self))}</div>{as_html(facts)}{first}"

    @property
    def name(self) -> str:
        """Name of its recipe."""
        return self.head["recipe"]["name"]

    @property
    def seed(self) -> int:
        """Seed of all draws."""
        return self.head["seed"]

    @property
    def head(self) -> dict[str, Any]:
        """`dataset.json`: recipe, seed, sizes, classes, columns; output_schema/README.md explains it."""
        return self._facts.head

    @property
    def classes(self) -> list[str]:
        """Names of the classes that samples are drawn from."""
        return self.head["classes"]

    @property
    def pixel_classes(self) -> list[str]:
        """Names of the classes of pixels; the position is the value in `Sample.label`."""
        return self.head["pixel_classes"]

    @property
    def shape(self) -> tuple[int, int]:
        """Rows (along the scan) and columns (along the laser line) of the maps [px]."""
        return self.head["images"]["rows"], self.head["images"]["cols"]

    @property
    def indices(self) -> list[int]:
        """Numbers of the samples that are here."""
        return self._indices

    def __len__(self) -> int:
        return len(self._indices)

    def __getitem__(self, place: int) -> Sample:  # type: ignore[override]
        if isinstance(place, slice):
            raise TypeError("slices are not read at once: ask for one sample after the other")
        place = whole("place", place)
        if not -len(self) <= place < len(self):
            raise IndexError(f"place: {place}: {self!r} has no such place")
        return self.sample(self._indices[place])

    def __iter__(self) -> Iterator[Sample]:
        return self.samples(self._indices)

    def sample(self, index: int, *, dark: bool | None = None) -> Sample:
        """Reads the sample of that number, of whatever split.

        Args:
            index: number of the sample, from 0
            dark: whether Reflectance and Scatter keep the sensor's dark level; None as the dataset was opened

        Raises:
            DatasetError: it is not there, or damaged.
            IndexError, TypeError: `index` is no number of a sample.
        """
        index = whole("index", index)
        if index < 0:
            raise IndexError(f"index: {index} is no number of a sample, these begin at 0")
        with self._reading():
            if self._remote:
                self._remote.fetch(self._stored.files(index))
            raw = self._stored.sample(index)
        return Sample(raw, self._facts, dark=self._dark if dark is None else dark, reading=self._reading)

    def samples(self, numbers: Iterable[int], *, dark: bool | None = None) -> Iterator[Sample]:
        """Reads samples one after the other.

        Args:
            numbers: their numbers
            dark: as for `sample`
        """
        return (self.sample(index, dark=dark) for index in numbers)


def open(
    place: str | os.PathLike[str],
    *,
    split: str | None = None,
    dark: bool = True,
    cache: str | os.PathLike[str] | None = None,
) -> Dataset:
    """Opens a dataset that `gen` wrote, in a folder or at a URL (`s3://`, `gs://`, `https://`, ...).

    Args:
        place: the folder; or a URL that fsspec knows (`pip install "sheetlight[remote]"`, and the package that fsspec names for it)
        split: "train", "validation" or "test"; None for all
        dark: whether Reflectance and Scatter keep the sensor's dark level, as the camera has it
        cache: folder for the files of URLs, which are fetched whole, a shard's table when one of its samples is asked for; each
            dataset has a folder of its own in it, whose files are fetched anew where they changed at the URL. None for a temporary
            one that is removed at the end

    Raises:
        DatasetError: there is no dataset, it cannot be read here, or none of its shards is at the URL; or the cache cannot be
            written.
        TypeError, ValueError: an argument is nothing that can be opened.
    """
    return Dataset(place, split, dark, cache)


class _Remote:
    """Files of a dataset at a URL, fetched into a folder."""

    def __init__(self, url: str, cache: str | os.PathLike[str] | None):
        self._url, self._cache = url.rstrip("/"), cache
        protocol, _, rest = url.partition("://")
        if "@" in rest.partition("/")[0] or "?" in rest:
            raise DatasetError(
                f"{protocol}://...: the URL holds credentials or a query; give the plain URL, and credentials in the environment, "
                "where the store's own tools look for them"
            )
        with needed("fsspec", "remote"):
            import fsspec.asyn
        self._shared: Any = None
        self._lock = threading.Lock()
        _REMOTES.add(self)
        try:
            self._files()
        except (ImportError, ValueError) as fault:
            raise DatasetError(f"{url}: {_words(fault)}") from None
        document = self._read("dataset.json")
        if document is None:
            raise DatasetError(f"cannot use {url}: it holds no dataset.json; name the place of a dataset")
        head = self._head(document)
        if cache is None:
            self.folder = Path(tempfile.mkdtemp(prefix="sheetlight-"))
            weakref.finalize(self, _remove, self.folder, os.getpid())
        else:
            # Another URL, or what was made anew at this one, has other files of the same names.
            made_of = [self._url, head["recipe"]["hash"], head["seed"], head["generator"], head["samples_per_shard"]]
            self.folder = Path(cache) / hashlib.sha256(json.dumps(made_of, sort_keys=True).encode()).hexdigest()[:16]
        # The documents change while a dataset is made or grows: they are fetched anew.
        with self._writing():
            _put(self.folder / "dataset.json", document)
        if not self._fetch_manifests(head["shards"]):
            raise DatasetError(
                f"{self._url}: none of its {head['shards']} shards has a manifest there, such as {_sheetlight.manifest_path(0)}; "
                "finish the dataset, or copy its whole folder there"
            )

    @contextlib.contextmanager
    def reading(self) -> Iterator[None]:
        """Faults of files name the URL that these are from, and the cache if there is one."""
        try:
            yield
        except DatasetError as fault:
            words = str(fault)
            if str(self.folder) not in words:
                raise
            kept = f"; what was fetched of it is in {self.folder}" if self._cache else ""
            raise DatasetError(words.replace(str(self.folder), self._url) + kept) from None

    @contextlib.contextmanager
    def _writing(self) -> Iterator[None]:
        """Around what is written into the folder."""
        try:
            yield
        except OSError as fault:
            raise self._unwritable(fault) from None

    def _unwritable(self, fault: OSError) -> DatasetError:
        why = fault.strerror or _words(fault)
        if self._cache:
            return DatasetError(f"cache: cannot write in {self._cache} ({why}); free space there, or name another folder that is yours")
        return DatasetError(f"cannot write in {self.folder} ({why}); free space there, or name a folder by `cache`")

    def after_fork(self) -> None:
        """In a forked process: connections and threads are the parent's, and somebody may have held the lock."""
        self._shared, self._lock = None, threading.Lock()

    def _files(self) -> tuple[Any, str]:
        """File system and root. Asynchronous ones serve all threads; of others fsspec keeps one for each thread."""
        import fsspec.core

        if self._shared is not None:
            return self._shared
        files, root = fsspec.core.url_to_fs(self._url)
        if files.async_impl:
            self._shared = files, root
        return files, root

    def _head(self, document: bytes) -> dict[str, Any]:
        with tempfile.TemporaryDirectory(prefix="sheetlight-") as folder:
            (Path(folder) / "dataset.json").write_bytes(document)
            try:
                return json.loads(_sheetlight.StoredDataset.read_head(folder))
            except DatasetError as fault:
                raise DatasetError(str(fault).replace(folder, self._url)) from None

    def _fetch_manifests(self, shards: int) -> int:
        """Fetches all that are there, by name, since not every server lists; how many these are."""
        from concurrent.futures import ThreadPoolExecutor

        found = 0
        with ThreadPoolExecutor(REQUESTS) as pool:
            for first in range(0, shards, SHARDS_AT_ONCE):
                paths = [_sheetlight.manifest_path(shard) for shard in range(first, min(first + SHARDS_AT_ONCE, shards))]
                for path, document in zip(paths, pool.map(self._read, paths)):
                    self._renew(self.folder / path, document)
                    found += document is not None
        return found

    def _renew(self, manifest: Path, document: bytes | None) -> None:
        """Puts a manifest in place of the one that the folder has, without files of the old one that are others by now."""
        try:
            before = manifest.read_bytes()
        except FileNotFoundError:
            before = None
        if document == before:
            return
        kept = {} if document is None else _sums(document)
        with self._writing():
            for file, sha256 in ({} if before is None else _sums(before)).items():
                if kept.get(file) != sha256:
                    self._here(file).unlink(missing_ok=True)
            if document is None:
                manifest.unlink(missing_ok=True)
            else:
                _put(manifest, document)

    def fetch(self, files: Iterable[tuple[str, int]]) -> None:
        """Fetches the files that are not here yet, each of so many bytes."""
        with self._lock:
            for file, size in files:
                self._get(file, size)

    def _get(self, file: str, size: int) -> None:
        """Fetches a file unless it is here; what is missing there is told by who reads it."""
        here = self._here(file)
        if _size(here) == size:
            return
        with self._writing(), _replacing(here) as part:
            # What the store then raises is the store's.
            here.parent.mkdir(parents=True, exist_ok=True)
            part.touch()
            try:
                self._again(file, lambda: self._download(file, part))
            except FileNotFoundError:
                here.unlink(missing_ok=True)
                return
            if (got := _size(part)) != size:
                raise DatasetError(
                    f"{self._url}/{file}: it has {got} bytes, and the manifest of its shard says {size}; open the dataset again if it "
                    "has grown meanwhile, or else have its shard made again"
                )
            os.replace(part, here)

    def _download(self, file: str, part: Path) -> None:
        files, root = self._files()
        files.get_file(f"{root}/{file}", str(part))

    def _read(self, file: str) -> bytes | None:
        """A document; None where there is none."""

        def read() -> bytes:
            files, root = self._files()
            return files.cat_file(f"{root}/{file}")

        try:
            return self._again(file, read)
        except FileNotFoundError:
            return None

    def _here(self, file: str) -> Path:
        parts = PurePosixPath(file).parts
        if not parts or any(part in ("..", "/") or ":" in part or "\\" in part for part in parts):
            raise DatasetError(f"{self._url}: it names the file {file!r}, which lies outside of it")
        return self.folder.joinpath(*parts)

    def _again(self, file: str, attempt: Callable[[], Any]) -> Any:
        """Tries to read a file until it works or trying does not help."""
        for number in range(ATTEMPTS):
            try:
                return attempt()
            except FileNotFoundError:
                raise
            except Exception as fault:  # every store has its own
                if isinstance(fault, OSError) and fault.errno in FULL:
                    raise self._unwritable(fault) from None
                place, is_last = f"{self._url}/{file}", number + 1 == ATTEMPTS
                if isinstance(fault, PermissionError) or "Credential" in type(fault).__name__:
                    remedy = "check the credentials in the environment, and that they may read there"
                    raise DatasetError(f"{place}: cannot read it: {_words(fault)}; {remedy}") from None
                if is_last:
                    remedy = "check the store and the network, then try again"
                    raise DatasetError(f"{place}: cannot read it: {_words(fault)}; {remedy}") from None
                time.sleep(PAUSE_S * 2**number)
        raise AssertionError("the last attempt returns or raises")


_REMOTES: weakref.WeakSet[_Remote] = weakref.WeakSet()
"""Those of this process."""


def _after_fork() -> None:
    # Releases of fsspec before 2025 keep the loop of the parent, whose thread is not here.
    asyn = sys.modules.get("fsspec.asyn")
    if asyn is not None and hasattr(asyn, "reset_lock"):
        asyn.reset_lock()
    for remote in list(_REMOTES):
        remote.after_fork()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)


def _sums(manifest: bytes) -> dict[str, str]:
    """SHA-256 of the files of a manifest; of a damaged one none, which is told by who reads it."""
    try:
        return {file["path"]: file["sha256"] for file in json.loads(manifest)["files"]}
    except (ValueError, KeyError, TypeError):
        return {}


def _size(file: Path) -> int | None:
    try:
        return file.stat().st_size
    except FileNotFoundError:
        return None


@contextlib.contextmanager
def _replacing(here: Path) -> Iterator[Path]:
    """A file beside `here` to take its place: another process may fetch the same, and whoever ends first gives it its name."""
    part = here.with_name(f".{here.name}.{uuid.uuid4().hex[:8]}.part")
    try:
        yield part
    finally:
        part.unlink(missing_ok=True)


def _put(here: Path, content: bytes) -> None:
    here.parent.mkdir(parents=True, exist_ok=True)
    with _replacing(here) as part:
        part.write_bytes(content)
        os.replace(part, here)


def _words(fault: BaseException) -> str:
    """What an exception says, on one line."""
    return " ".join(str(fault).split()) or type(fault).__name__


def _remove(folder: Path, owner: int) -> None:
    # A forked worker must not remove what the others read.
    if os.getpid() == owner:
        shutil.rmtree(folder, ignore_errors=True)
