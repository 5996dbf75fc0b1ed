"""Datasets that were written, in a folder or a bucket."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
import threading
import time
import uuid
import weakref
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path, PurePosixPath
from typing import Any

from sheetlight import _sheetlight
from sheetlight._errors import DatasetError
from sheetlight._need import needed
from sheetlight._sample import Facts, Sample

SPLITS = ("train", "validation", "test")

ATTEMPTS = 5
"""How often a request of a store is tried."""

PAUSE_S = 0.25
"""Pause before the second attempt [s]; each further one is twice as long."""


class Dataset(Sequence[Sample]):
    """The finished samples of a dataset, or of one of its splits; get one by `open`.

    A sequence: `len(dataset)`, `dataset[k]`, `for sample in dataset`; `sample(index)` goes by the number of the sample instead.
    Maps are read when they are asked for, from the EXR file where the dataset has one, else from the table.
    """

    def __init__(self, place: str | os.PathLike[str], split: str | None, dark: bool, cache: str | os.PathLike[str] | None):
        if split is not None and split not in SPLITS:
            raise ValueError(f"split: {split!r} is none, these are {', '.join(SPLITS)}, or None for all")
        self._place, self._split, self._dark, self._cache = os.fspath(place), split, dark, cache
        self._remote = _Remote(self._place, cache) if _is_url(self._place) else None
        self._stored = _sheetlight.StoredDataset.open(self._remote.folder if self._remote else self._place)
        self._facts = Facts(json.loads(self._stored.head()))
        listed = self._stored.samples()
        self._indices = [index for index, part, _ in listed if split in (None, part)]

    def __reduce__(self) -> tuple[Any, ...]:
        return Dataset, (self._place, self._split, self._dark, self._cache)

    def __repr__(self) -> str:
        of = f" of {self._split}" if self._split else ""
        return f"<Dataset {self.name} at {self._place}: {len(self)} samples{of}>"

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
        """
        index = index.__index__()
        if index < 0:
            raise IndexError(f"index: {index} is no number of a sample, these begin at 0")
        if self._remote:
            self._remote.fetch(self._stored.files(index))
        return Sample(self._stored.sample(index), self._facts, dark=self._dark if dark is None else dark)

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
        cache: folder for the files of a URL, which are fetched whole, a shard's table when one of its samples is asked for; None for
            a temporary one that is removed at the end

    Raises:
        DatasetError: there is no dataset, or it cannot be read here.
    """
    return Dataset(place, split, dark, cache)


def _is_url(place: str) -> bool:
    # A drive letter of Windows is no protocol.
    protocol, separator, _ = place.partition("://")
    return bool(separator) and len(protocol) > 1


class _Remote:
    """Files of a dataset at a URL, fetched into a folder."""

    def __init__(self, url: str, cache: str | os.PathLike[str] | None):
        self._url = url.rstrip("/")
        protocol, _, rest = url.partition("://")
        if "@" in rest.partition("/")[0] or "?" in rest:
            raise DatasetError(
                f"{protocol}://...: the URL holds credentials or a query; give the plain URL, and credentials in the environment, "
                "where the store's own tools look for them"
            )
        with needed("fsspec", "remote"):
            import fsspec
        try:
            self._files, self._root = fsspec.core.url_to_fs(self._url)
        except (ImportError, ValueError) as fault:
            raise DatasetError(f"{url}: {_words(fault)}") from None
        if cache is None:
            self.folder = Path(tempfile.mkdtemp(prefix="sheetlight-"))
            weakref.finalize(self, _remove, self.folder, os.getpid())
        else:
            self.folder = Path(cache)
            self.folder.mkdir(parents=True, exist_ok=True)
        self._lock = threading.Lock()
        # The documents grow while a dataset is being made: they are fetched anew.
        if not self._get("dataset.json", anew=True):
            raise DatasetError(f"cannot use {url}: it holds no dataset.json; name the place of a dataset")
        for manifest in self._manifests():
            self._get(manifest, anew=True)

    def _manifests(self) -> list[str]:
        try:
            found = self._again("list", "shards", lambda: self._files.find(f"{self._root}/shards"))
        except FileNotFoundError:
            return []
        start = self._root.strip("/") + "/"
        relative = [str(path).lstrip("/").removeprefix(start) for path in found]
        return [path for path in relative if path.startswith("shards/") and path.endswith(".json")]

    def fetch(self, files: Iterable[str]) -> None:
        """Fetches the files that are not here yet."""
        with self._lock:
            for file in files:
                self._get(file)

    def _get(self, file: str, anew: bool = False) -> bool:
        """Whether the file is here now; what is missing there is told by who reads it."""
        parts = PurePosixPath(file).parts
        if not parts or any(part in ("..", "/") or ":" in part or "\\" in part for part in parts):
            raise DatasetError(f"{self._url}: it names the file {file!r}, which lies outside of it")
        here = self.folder.joinpath(*parts)
        if here.exists() and not anew:
            return True
        here.parent.mkdir(parents=True, exist_ok=True)
        # Another process may fetch the same; whoever ends first gives the file its name.
        part = here.with_name(f".{here.name}.{uuid.uuid4().hex[:8]}.part")
        try:
            self._again("read", file, lambda: self._files.get_file(f"{self._root}/{file}", str(part)))
            os.replace(part, here)
        except FileNotFoundError:
            return False
        finally:
            part.unlink(missing_ok=True)
        return True

    def _again(self, what: str, file: str, attempt: Callable[[], Any]) -> Any:
        """Tries until it works or trying does not help."""
        for number in range(ATTEMPTS):
            try:
                return attempt()
            except FileNotFoundError:
                raise
            except Exception as fault:  # every store has its own
                place, is_last = f"{self._url}/{file}", number + 1 == ATTEMPTS
                if isinstance(fault, PermissionError) or "Credential" in type(fault).__name__:
                    remedy = "check the credentials in the environment, and that they may list and read there"
                    raise DatasetError(f"{place}: cannot {what} it: {_words(fault)}; {remedy}") from None
                if is_last:
                    remedy = "check the store and the network, then try again"
                    raise DatasetError(f"{place}: cannot {what} it: {_words(fault)}; {remedy}") from None
                time.sleep(PAUSE_S * 2**number)
        raise AssertionError("the last attempt returns or raises")


def _words(fault: BaseException) -> str:
    """What an exception says, on one line."""
    return " ".join(str(fault).split()) or type(fault).__name__


def _remove(folder: Path, owner: int) -> None:
    # A forked worker must not remove what the others read.
    if os.getpid() == owner:
        shutil.rmtree(folder, ignore_errors=True)
