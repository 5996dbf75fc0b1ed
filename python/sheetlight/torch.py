"""Scans for PyTorch's DataLoader: rendered on the fly, or read from a dataset.

    import sheetlight, sheetlight.torch
    from torch.utils.data import DataLoader

    recipe = sheetlight.Recipe.load("wood-train")
    scans = sheetlight.torch.Scans(recipe, 10_000, crop=128)
    for batch in DataLoader(scans, batch_size=16, shuffle=True, num_workers=2):
        batch["maps"], batch["label"]       # float32 [16, 3, 128, 128], int64 [16, 128, 128]

An item follows from the recipe (or dataset), the seed, its number and the options alone: it is the same for any number of workers
and ranks, and in any order.
"""

from __future__ import annotations

import math
import numbers
import os
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from sheetlight._arguments import whole
from sheetlight._dataset import Dataset
from sheetlight._need import needed
from sheetlight._recipe import MOST_SAMPLES, Recipe
from sheetlight._sample import TRUTH, Sample

with needed("torch", "torch"):
    import torch
    import torch.distributed
    import torch.utils.data

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

MEASURED = ("range", "reflectance", "scatter")
"""Channels that are measured: "range" is in mm, or in px of uncalibrated scans."""

LAMPLIT = ("grey",)
"""Channels that are measured under lamps, by recipes that have them."""

LABELS = ("label", "instance")
"""What is true of each pixel, which an item has where the dataset keeps it."""

ROUNDING = 1e-9
"""Part of a square pixel that the rounding of its side against the scan may take away."""


class Scans(torch.utils.data.Dataset[dict[str, Any]]):  # type: ignore[misc, unused-ignore]
    """Scans by number. An item is a dict:

    - `maps`: float32 `[channels, rows, cols]`; Range and truth in mm (or px, deg), Reflectance, Scatter and Grey in DN; `missing` where a
      pixel is not measured (or off the object, in maps of truth)
    - `valid`: bool `[rows, cols]`, whether a pixel is measured
    - `label`: int64 `[rows, cols]`, class of what each pixel really shows, a position in `pixel_classes`
    - `instance`: int64 `[rows, cols]`, which object each pixel really shows, 0 for none
    - `class`: position of the sample's class among `classes`
    - `index`: number of the sample
    - `corner`: int64 `[2]`, first row and first column of the crop
    - `pixel_mm`: float64 `[2]`, distance between two rows and between two columns [mm]

    Of a dataset that does not keep `label` or `instance` (`output.png` and `output.exr` of its recipe), or nothing measured for
    `valid`, no item has that key.
    """

    def __init__(
        self,
        scans: Recipe | Dataset,
        n: int | None = None,
        *,
        crop: int | tuple[int, int] | None = None,
        channels: Sequence[str] = MEASURED,
        square_pixels: bool | float = False,
        seed: int | None = None,
        first: int = 0,
        dark: bool | None = None,
        missing: float = 0.0,
    ):
        """
        Args:
            scans: a recipe, whose samples are rendered as they are asked for; or a dataset, whose samples are read
            n: how many; None for all of a dataset
            crop: rows and columns of a window at a place that follows from seed and number [px]; None for whole scans
            channels: "range", "reflectance", "scatter", "grey", and maps of `Sample.truth`
            square_pixels: True for pixels as long as wide, of the longer of the two sides; a number for pixels of that side [mm].
                Maps are averaged over the area of a pixel, labels are taken at its middle. Sides of pixels are drawn, so that scans
                become of unlike size: `crop` makes them alike for batches, and must fit the smallest.
            seed: of the places of crops, and of a recipe's draws; None for that of the recipe or dataset
            first: number of the first sample of a recipe; another epoch of fresh samples begins at n, 2 n, ...
            dark: whether Reflectance, Scatter and Grey keep the sensor's dark level; None as the dataset was opened, and True for a recipe
            missing: what maps hold where nothing is measured; `math.nan` is possible

        Raises:
            TypeError, ValueError: an argument cannot be used; where only a sample tells, when it is asked for.
        """
        first = whole("first", first, 0)
        if isinstance(scans, Dataset):
            if first:
                raise ValueError("first: the samples of a dataset are those that it has; open one split of it, or take a Subset")
            n = len(scans) if n is None else whole("n", n, 0)
            if n > len(scans):
                raise ValueError(f"n: {n} samples are asked for and {scans!r} has {len(scans)}")
            self._kept = {*scans.head["images"]["png"], *scans.head["images"]["exr"]}
        elif isinstance(scans, Recipe):
            if n is None:
                raise ValueError("n: a recipe has any number of samples; say how many")
            n = whole("n", n, 0)
            if first + n > MOST_SAMPLES:
                raise ValueError(f"first, n: {first} + {n} is more than the {MOST_SAMPLES} samples that a recipe has")
            self._kept = {*MEASURED, *LABELS}
        else:
            raise TypeError(f"scans: give a Recipe or a Dataset, not {type(scans).__name__}")
        if isinstance(channels, str) or not isinstance(channels, Sequence):
            raise TypeError(f"channels: {channels!r}: give a list of names, such as ['range', 'scatter']")
        unknown = [str(name) for name in channels if name not in (*MEASURED, *LAMPLIT, *TRUTH)]
        if unknown or not channels:
            raise ValueError(
                f"channels: {', '.join(unknown) or 'none'}; there are {', '.join((*MEASURED, *LAMPLIT, *TRUTH))}; range is in mm, or in px of "
                "uncalibrated scans"
            )
        absent = [name for name in channels if name in MEASURED and name not in self._kept]
        if absent:
            held = ", ".join(name for name in MEASURED if name in self._kept) or "none of those that are measured"
            raise ValueError(f"channels: {scans!r} has no {', '.join(absent)}; it has {held}")
        self.scans, self.n, self.first = scans, n, first
        self.seed = scans._seed(seed) if isinstance(scans, Recipe) else scans.seed if seed is None else whole("seed", seed, 0)
        self.dark = (scans._dark if isinstance(scans, Dataset) else True) if dark is None else dark
        self.channels, self.missing = tuple(channels), missing
        if isinstance(square_pixels, (bool, np.bool_)):
            self.square_pixels: bool | float = bool(square_pixels)
        elif isinstance(square_pixels, numbers.Real) and 0 < square_pixels < math.inf:
            self.square_pixels = float(square_pixels)
        else:
            raise ValueError(
                f"square_pixels: {square_pixels}: give the side of a pixel in mm, above 0; or True for the longer side that pixels have, "
                "False for pixels as they are"
            )
        self.crop = None if crop is None else _crop(crop)
        # With True, pixels only grow; with a side of their own, how many there are is known of each sample alone.
        if self.crop is not None and isinstance(self.square_pixels, bool):
            self._check_crop(scans.shape, repr(scans))

    @property
    def classes(self) -> list[str]:
        """Names of the classes that samples are drawn from."""
        return self.scans.classes

    @property
    def pixel_classes(self) -> list[str]:
        """Names of the classes of pixels."""
        return self.scans.pixel_classes

    def __len__(self) -> int:
        return self.n

    def __getitem__(self, number: int) -> dict[str, Any]:
        number = whole("number", number)
        if not 0 <= number < self.n:
            raise IndexError(f"{number}: there are scans 0 to {self.n - 1}")
        return self.item(self.sample(number))

    def sample(self, number: int) -> Sample:
        """The whole sample of that number."""
        if isinstance(self.scans, Dataset):
            return self.scans.sample(self.scans.indices[number], dark=self.dark)
        # Workers are the parallelism; threads of each would only compete.
        threads = 1 if torch.utils.data.get_worker_info() else None
        return self.scans.sample(self.first + number, self.seed, threads=threads, dark=self.dark)

    def item(self, sample: Sample) -> dict[str, Any]:
        """What an item holds of a sample."""
        grid = _Grid(sample, self.square_pixels)
        window = self._window(sample.index, grid.shape)
        grid.look_at(window)
        kept: dict[str, Any] = {}
        valid = share = None
        if not self._kept.isdisjoint(MEASURED):
            valid = sample.valid
            share = grid.averaged(valid.astype(np.float32))
            kept["valid"] = torch.from_numpy(share >= 0.5)
        for name in LABELS:
            if name in self._kept:
                kept[name] = torch.from_numpy(grid.nearest(getattr(sample, name)).astype(np.int64))
        maps = [self._channel(sample, name, grid, valid, share) for name in self.channels]
        return {
            "maps": torch.from_numpy(np.stack(maps)),
            **kept,
            "class": sample.class_index,
            "index": sample.index,
            "corner": torch.tensor([part.start for part in window]),
            "pixel_mm": torch.tensor(grid.pixel_mm, dtype=torch.float64),
        }

    def _channel(
        self, sample: Sample, name: str, grid: _Grid, valid: NDArray[np.bool_] | None, share: NDArray[np.float32] | None
    ) -> NDArray[np.float32]:
        """A map of which `share` of each pixel is there, if that is what is measured."""
        key = f"range_{sample.range_unit}" if name == "range" else name
        try:
            values = sample.maps[key]
        except KeyError:
            raise ValueError(f"channels: sample {sample.index} has no {name}; it has {', '.join(sample.maps)}") from None
        there = ~np.isnan(values)
        if valid is None or share is None or not np.array_equal(there, valid):
            share = grid.averaged(there.astype(np.float32))
        mean = grid.averaged(np.where(there, values, np.float32(0)))
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(share >= 0.5, mean / share, np.float32(self.missing)).astype(np.float32)

    def _window(self, index: int, shape: tuple[int, int]) -> tuple[range, range]:
        if self.crop is None:
            return range(shape[0]), range(shape[1])
        self._check_crop(shape, f"scan {index}")
        place = np.random.default_rng([self.seed, index])
        starts = [int(place.integers(0, length - side + 1)) for side, length in zip(self.crop, shape)]
        rows, cols = (range(start, start + side) for start, side in zip(starts, self.crop))
        return rows, cols

    def _check_crop(self, shape: tuple[int, int], name: str) -> None:
        """Refuses a crop that does not fit a scan of that shape."""
        if self.crop is None or all(side <= length for side, length in zip(self.crop, shape)):
            return
        pixels = f"square pixels ({self.square_pixels})" if self.square_pixels else "px"
        longer = ", or a smaller side of pixels" if self.square_pixels else ""
        raise ValueError(f"crop: {self.crop} does not fit {name} of {shape[0]} x {shape[1]} {pixels}; give a smaller one{longer}")


def _crop(crop: Any) -> tuple[int, int]:
    """Rows and columns of a crop; one number is both."""
    sides = tuple(crop) if isinstance(crop, (tuple, list)) else (crop, crop)
    remedy = "give a whole number, or two as (rows, columns) [px]"
    if len(sides) != 2:
        raise ValueError(f"crop: {crop!r}: {remedy}")
    try:
        rows, cols = (whole("crop", side) for side in sides)
    except TypeError:
        raise TypeError(f"crop: {crop!r}: {remedy}") from None
    if min(rows, cols) < 1:
        raise ValueError(f"crop: {crop}: give rows and columns of 1 or more")
    return rows, cols


class ScansStream(torch.utils.data.IterableDataset[dict[str, Any]]):  # type: ignore[misc, unused-ignore]
    """The same as a stream, in the order of numbers, without end where a recipe is given no `n`.

    Workers of a DataLoader and ranks of torch.distributed share it: worker w of W on rank r of R gives scans r + R w, then each
    R W-th one. Together they give every scan once.
    """

    def __init__(self, scans: Recipe | Dataset, n: int | None = None, **options: Any):
        """
        Args:
            scans: as for `Scans`
            n: how many; None for all of a dataset, and without end for a recipe
            **options: those of `Scans`
        """
        self._is_endless = n is None and isinstance(scans, Recipe)
        most = MOST_SAMPLES - whole("first", options.get("first", 0), 0) if self._is_endless else n
        self.scans = Scans(scans, most, **options)

    def __len__(self) -> int:
        if self._is_endless:
            raise TypeError("the stream has no end")
        return len(self.scans)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        start, step = _share()
        scans = self.scans
        if isinstance(scans.scans, Dataset):
            yield from (scans[number] for number in range(start, len(scans), step))
            return
        shared = range(scans.first + start, scans.first + len(scans), step)
        threads = 1 if torch.utils.data.get_worker_info() else None
        for sample in scans.scans.samples(shared, scans.seed, threads=threads, dark=scans.dark):
            yield scans.item(sample)


def _share() -> tuple[int, int]:
    """First number of this worker on this rank, and the step to the next."""
    rank, ranks = 0, 1
    if torch.distributed.is_available() and torch.distributed.is_initialized():
        rank, ranks = torch.distributed.get_rank(), torch.distributed.get_world_size()
    elif "WORLD_SIZE" in os.environ and "RANK" in os.environ:
        # A worker that was spawned is no member of its parent's group.
        rank, ranks = int(os.environ["RANK"]), int(os.environ["WORLD_SIZE"])
    worker = torch.utils.data.get_worker_info()
    w, workers = (worker.id, worker.num_workers) if worker else (0, 1)
    return rank + ranks * w, ranks * workers


class _Grid:
    """The pixels of a window of a sample, or square ones over the same field."""

    def __init__(self, sample: Sample, square_pixels: bool | float):
        rows, cols = sample.shape
        self.pixel_mm = (sample.row_mm, sample.col_mm)
        self._whole = (rows, cols)
        self._steps: tuple[float, float] | None = None
        self.shape = (rows, cols)
        if square_pixels is False:
            return
        side = max(self.pixel_mm) if square_pixels is True else float(square_pixels)
        # Pixels of the sample in a square one, along rows and columns.
        self._steps = side / sample.row_mm, side / sample.col_mm
        self.pixel_mm = (side, side)
        # A pixel that lacks a rounding error of its area is whole.
        self.shape = int(rows / self._steps[0] + ROUNDING), int(cols / self._steps[1] + ROUNDING)
        if min(self.shape) < 1:
            raise ValueError(f"square_pixels: {side} mm is more than sample {sample.index} is long or wide; give a smaller side")

    def look_at(self, window: tuple[range, range]) -> None:
        """From now on maps are of this window."""
        self._window = window
        if self._steps is not None:
            along, across = (
                _Overlaps(part, step, length) for part, step, length in zip(window, self._steps, self._whole)
            )
            self._overlaps = along, across

    def averaged(self, values: NDArray[np.float32]) -> NDArray[np.float32]:
        """Means over the areas of pixels, float32."""
        if self._steps is None:
            rows, cols = self._window
            return values[rows.start : rows.stop, cols.start : cols.stop]
        along, across = self._overlaps
        part = values[along.first : along.last, across.first : across.last]
        return across.means(along.means(part, axis=0), axis=1)

    def nearest(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values at the middles of pixels."""
        rows, cols = self._window
        if self._steps is None:
            return values[rows.start : rows.stop, cols.start : cols.stop]
        places = [((np.asarray(part) + 0.5) * step).astype(np.int64) for part, step in zip(self._window, self._steps)]
        return values[np.ix_(*places)]


class _Overlaps:
    """Pixels `part` of `step` pixels of a sample each, which lie on pixels `first` to `last` of its `length` in whole or in part."""

    def __init__(self, part: range, step: float, length: int):
        edges = np.minimum(np.asarray(range(part.start, part.stop + 1)) * step, length)
        lower, upper = edges[:-1], edges[1:]
        begin, end = lower.astype(np.int64), np.ceil(upper).astype(np.int64)
        self.first, self.last = int(begin[0]), int(end[-1])
        # The k-th pixel of the sample that each lies on, and how much of it that is, `[k, part]`.
        pixels = begin + np.arange(int((end - begin).max()))[:, None]
        shares = np.clip(np.minimum(upper, pixels + 1) - np.maximum(lower, pixels), 0, None) / step
        self._places = np.minimum(pixels, self.last - 1) - self.first
        self._shares = shares.astype(np.float32)

    def means(self, values: NDArray[np.float32], axis: int) -> NDArray[np.float32]:
        """Means over each, by area, of values from pixel `first` on along that axis."""
        return sum(
            np.take(values, places, axis=axis) * (shares if axis else shares[:, None])
            for places, shares in zip(self._places, self._shares)
        )
