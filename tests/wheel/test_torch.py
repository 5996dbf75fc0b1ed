"""Scans for DataLoader."""

import math
from fractions import Fraction

import numpy as np
import pytest
import sheetlight
import torch
from conftest import SMALL, write
from sheetlight.torch import Scans, ScansStream
from torch.utils.data import DataLoader

BANDS = {"scan.columns": 64, "scan.profiles": 1200}


@pytest.fixture(scope="module")
def recipe():
    return sheetlight.Recipe.load("wood-small", SMALL)


def same(a, b):
    """Whether two items or batches are the same, bit for bit."""
    return a.keys() == b.keys() and all(
        torch.equal(torch.nan_to_num(torch.as_tensor(a[key]), 7e30), torch.nan_to_num(torch.as_tensor(b[key]), 7e30)) for key in a
    )


def test_an_item_is_the_sample(recipe):
    sample = recipe.sample(2, seed=5)
    item = Scans(recipe, 3, seed=5, missing=math.nan)[2]
    for channel, name in enumerate(("range_mm", "reflectance", "scatter")):
        assert np.array_equal(item["maps"][channel].numpy(), sample.maps[name], equal_nan=True)
    assert item["maps"].dtype == torch.float32 and item["label"].dtype == item["instance"].dtype == torch.int64
    assert np.array_equal(item["label"].numpy(), sample.label) and np.array_equal(item["instance"].numpy(), sample.instance)
    assert np.array_equal(item["valid"].numpy(), sample.valid) and item["class"] == recipe.classes.index(sample.class_name)
    assert item["index"] == 2 and item["pixel_mm"].tolist() == [sample.row_mm, sample.col_mm]
    filled = Scans(recipe, 3, seed=5, missing=-1.0, channels=["height_mm", "scatter"])[2]
    assert np.array_equal(filled["maps"][1].numpy(), np.where(sample.valid, sample.scatter, -1))
    height = sample.truth["height_mm"]
    assert np.array_equal(filled["maps"][0].numpy(), np.where(np.isnan(height), -1, height))
    bare = Scans(recipe, 3, seed=5, dark=False)[2]["maps"][2]
    assert np.allclose(bare.numpy()[sample.valid], sample.scatter[sample.valid] - sample.dark_dn["scatter"])
    assert Scans(recipe, 3, first=2, seed=5)[0]["index"] == 2


def test_crops_are_windows_at_drawn_places(recipe):
    whole, crops = Scans(recipe, 40, seed=5), Scans(recipe, 40, crop=(16, 32), seed=5)
    corners = []
    for number in range(0, 40, 8):
        item, full = crops[number], whole[number]
        row, col = item["corner"].tolist()
        corners.append((row, col))
        assert torch.equal(item["maps"], full["maps"][:, row : row + 16, col : col + 32])
        assert torch.equal(item["label"], full["label"][row : row + 16, col : col + 32])
    assert len(set(corners)) > 2 and all(0 <= row <= 24 and 0 <= col <= 64 for row, col in corners)
    assert same(crops[8], Scans(recipe, 40, crop=(16, 32), seed=5)[8])


@pytest.mark.parametrize("context", ["fork", "spawn"])
def test_any_number_of_workers_gives_the_same(context):
    recipe = sheetlight.Recipe.load("wood-small", BANDS)
    # The parent has threads by then, which a fork loses.
    recipe.sample(0, threads=2)
    scans = Scans(recipe, 6, crop=48, seed=3)
    mine = [scans[number] for number in range(6)]
    # A worker that is spawned takes seconds to import PyTorch; one is enough.
    for workers in (0, 1, 2) if context == "fork" else (1,):
        loader = DataLoader(
            scans, batch_size=2, num_workers=workers, multiprocessing_context=context if workers else None, timeout=120 if workers else 0
        )
        found = [{key: value[at] for key, value in batch.items()} for batch in loader for at in range(2)]
        assert len(found) == 6 and all(same(a, b) for a, b in zip(found, mine))


def test_streams_share_all_scans_among_workers_and_ranks(recipe, monkeypatch):
    scans = Scans(recipe, 7, crop=16, seed=3)
    mine = [scans[number] for number in range(7)]
    for ranks in (1, 2):
        for workers in (0, 2):
            found = []
            for rank in range(ranks):
                monkeypatch.setenv("RANK", str(rank))
                monkeypatch.setenv("WORLD_SIZE", str(ranks))
                stream = ScansStream(recipe, 7, crop=16, seed=3)
                found += list(DataLoader(stream, batch_size=None, num_workers=workers))
            assert sorted(int(item["index"]) for item in found) == list(range(7)), (ranks, workers)
            assert all(same(item, mine[int(item["index"])]) for item in found)
    monkeypatch.undo()
    stream = iter(ScansStream(recipe, seed=3))
    assert [next(stream)["index"] for _ in range(9)] == list(range(9))
    with pytest.raises(TypeError, match="no end"):
        len(ScansStream(recipe))


def test_datasets_give_what_they_hold(recipe, boards):
    dataset = sheetlight.open(boards, split="train")
    scans = Scans(dataset, crop=16, seed=2)
    assert len(scans) == len(dataset) and scans.classes == dataset.classes
    batches = list(DataLoader(scans, batch_size=4, num_workers=2))
    assert torch.cat([batch["index"] for batch in batches]).tolist() == dataset.indices
    assert same(scans[1], {key: value[1] for key, value in batches[0].items()})
    stream = DataLoader(ScansStream(dataset, crop=16, seed=2), batch_size=None)
    assert [int(item["index"]) for item in stream] == dataset.indices
    rendered = Scans(sheetlight.Recipe.load(boards), 20, seed=7)[dataset.indices[0]]
    read = Scans(dataset)[0]
    # EXR files hold heights in steps of 2^-13 mm; all else is the same.
    assert torch.equal(read["maps"][1:], rendered["maps"][1:]) and torch.equal(read["label"], rendered["label"])
    assert (read["maps"][0] - rendered["maps"][0]).abs().max() <= 2**-14 + 1e-6


@pytest.mark.parametrize("of", [Scans, ScansStream])
def test_the_dark_level_is_as_the_dataset_was_opened(recipe, boards, of):
    lit, bare = sheetlight.open(boards), sheetlight.open(boards, dark=False)
    for dataset, dark, taken in [(lit, None, lit), (bare, None, bare), (bare, True, lit), (lit, False, bare)]:
        item = next(iter(of(dataset, 1, channels=["reflectance", "scatter"], missing=math.nan, **({} if dark is None else {"dark": dark}))))
        for channel, name in enumerate(("reflectance", "scatter")):
            assert np.array_equal(item["maps"][channel].numpy(), getattr(taken[0], name), equal_nan=True)
    assert not np.array_equal(lit[0].scatter, bare[0].scatter, equal_nan=True)
    item = next(iter(of(recipe, 1, channels=["scatter"], missing=math.nan)))
    assert np.array_equal(item["maps"][0].numpy(), recipe.sample(0).scatter, equal_nan=True)


@pytest.mark.parametrize(
    "changes, channels, labels",
    [
        ({}, ("range", "reflectance", "scatter"), {"label"}),
        ({"output.png": "[reflectance]"}, ("reflectance",), set()),
        ({"output.png": "[reflectance, label]", "output.exr": "[scatter, instance]"}, ("reflectance", "scatter"), {"label", "instance"}),
        ({"output.png": "[label]", "output.exr": "[instance]", "output.truth_maps": "true"}, ("height_mm",), {"label", "instance"}),
    ],
)
def test_items_have_what_the_dataset_keeps(changes, channels, labels, tmp_path):
    write("wood-train", 3, tmp_path / "out", {**SMALL, **changes})
    dataset = sheetlight.open(tmp_path / "out")
    scans = Scans(dataset, crop=16, seed=1, channels=channels)
    always = {"maps", "class", "index", "corner", "pixel_mm"}
    measured = set() if channels == ("height_mm",) else {"valid"}
    [batch] = DataLoader(scans, batch_size=3)
    assert set(batch) == always | labels | measured and batch["maps"].shape == (3, len(channels), 16, 16)
    for item, sample in zip(scans, dataset):
        row, col = item["corner"].tolist()
        for name in labels:
            assert np.array_equal(item[name].numpy(), sample.maps[name][row : row + 16, col : col + 16])
    absent = [name for name in ("range", "reflectance", "scatter") if name not in channels]
    for name in absent:
        with pytest.raises(ValueError, match=f"channels: <Dataset .* has no {name}; it has"):
            Scans(dataset, channels=[*channels, name])


@pytest.mark.parametrize("name, side", [("wood-small", True), ("wood-small", 0.31), ("wood-small", 0.02), ("blister-small", True)])
def test_square_pixels_keep_sums_and_places(name, side):
    recipe = sheetlight.Recipe.load(name, SMALL)
    sample = recipe.sample(0)
    item = Scans(recipe, 1, square_pixels=side, channels=["scatter", "height_mm"], missing=math.nan)[0]
    pixel = max(sample.row_mm, sample.col_mm) if side is True else side
    rows, cols = item["label"].shape
    assert item["pixel_mm"].tolist() == [pixel, pixel]
    sides = zip(sample.shape, (sample.row_mm, sample.col_mm))
    assert (rows, cols) == tuple(math.floor(count * pitch / pixel + 1e-9) for count, pitch in sides)
    # Each pixel, worked out one by one: the mean of what is measured, by area.
    rng = np.random.default_rng(4)
    for row, col in zip(rng.integers(0, rows, 60), rng.integers(0, cols, 60)):
        edges = [np.array([at, at + 1]) * pixel / pitch for at, pitch in ((row, sample.row_mm), (col, sample.col_mm))]
        weights = [
            np.array([max(0.0, min(high, k + 1) - max(low, k)) for k in range(length)])
            for (low, high), length in zip(edges, sample.shape)
        ]
        area = np.outer(*weights) * sample.valid
        share = area.sum() / np.outer(*weights).sum()
        if abs(share - 0.5) < 1e-3:
            continue
        assert bool(item["valid"][row, col]) == (share > 0.5)
        if share > 0.5:
            mean = (area * np.nan_to_num(sample.scatter)).sum() / area.sum()
            assert float(item["maps"][0, row, col]) == pytest.approx(mean, rel=1e-4)
        middle = [int((at + 0.5) * pixel / pitch) for at, pitch in ((row, sample.row_mm), (col, sample.col_mm))]
        assert int(item["label"][row, col]) == sample.label[tuple(middle)]
    crop = Scans(recipe, 1, crop=7, square_pixels=side, channels=["scatter", "height_mm"], missing=math.nan)[0]
    row, col = crop["corner"].tolist()
    window = {**item, "maps": item["maps"][:, row : row + 7, col : col + 7]}["maps"]
    assert torch.allclose(crop["maps"], window, rtol=1e-5, equal_nan=True)
    assert torch.equal(crop["label"], item["label"][row : row + 7, col : col + 7])


class Plane:
    """A sample of drawn numbers, whose Scatter is that of its place."""

    def __init__(self, shape, row_mm, col_mm, rng):
        self.shape, self.row_mm, self.col_mm, self.index, self.class_index, self.range_unit = shape, row_mm, col_mm, 0, 0, "mm"
        scatter = rng.uniform(0, 60_000, shape).astype(np.float32)
        scatter[rng.random(shape) < 0.3] = np.nan
        self.maps, self.valid = {"scatter": scatter}, ~np.isnan(scatter)
        self.label = self.instance = np.zeros(shape, np.uint8)


def test_no_square_pixel_is_lost_by_rounding(recipe):
    rng = np.random.default_rng(8)
    lossy = 0
    for _ in range(200):
        pitches, times = rng.choice([0.01, 0.05, 0.07, 0.09, 0.1, 0.3], 2), int(rng.integers(1, 14))
        side = float(times * pitches[0])
        rows = int(rng.integers(1, 9))
        plane = Plane((rows * times, 130 * 40), pitches[0], pitches[1], rng)
        shape = Scans(recipe, 1, square_pixels=side, channels=["scatter"]).item(plane)["label"].shape
        exact = Fraction(130 * 40) * Fraction(str(pitches[1])) / (times * Fraction(str(pitches[0])))
        assert shape == (rows, math.floor(exact)), (plane.shape, pitches, side)
        lossy += int(rows * times / (side / pitches[0])) < rows
    assert lossy > 3


class Counted(np.ndarray):
    """An array that counts the numbers which go into each operation on it, and on what comes of it."""

    numbers = 0

    def __array_ufunc__(self, ufunc, method, *inputs, **options):
        result = getattr(ufunc, method)(*(np.asarray(value) for value in inputs), **options)
        Counted.numbers += result.size * (self.shape[-1] if ufunc is np.matmul else 1)
        return result.view(Counted)


@pytest.mark.parametrize("side, shape", [(0.09, (2000, 1280)), (0.31, (2000, 1280)), (0.031, (600, 400))])
def test_square_pixels_of_a_large_scan_cost_little(recipe, side, shape):
    """Operations in proportion to pixels, and the means that running sums in double precision give."""
    rng = np.random.default_rng(3)
    plane = Plane(shape, 0.09, 0.07, rng)
    scans = Scans(recipe, 1, square_pixels=side, channels=["scatter"], missing=math.nan)
    plain = plane.valid
    plane.valid = plain.view(Counted)
    Counted.numbers = 0
    item = scans.item(plane)
    plane.valid = plain
    # Each mean is of at most two parts of pixels more than its side is long, along rows and then columns; a product of dense matrices
    # takes a hundred times as many operations.
    rows, cols = item["valid"].shape
    along = (shape[0] + 2 * rows) * shape[1]
    across = (shape[1] + 2 * cols) * rows
    assert shape[0] * shape[1] + cols * rows < Counted.numbers < 3 * (along + across)

    def summed(values):
        for axis, pitch in enumerate((0.09, 0.07)):
            values = np.moveaxis(values, axis, -1)
            count = math.floor(values.shape[-1] * pitch / side + 1e-9)
            sums = np.concatenate([np.zeros((*values.shape[:-1], 1)), np.cumsum(values, axis=-1)], axis=-1)
            edges = np.minimum(np.arange(count + 1) * side / pitch, values.shape[-1])
            low = np.minimum(edges.astype(int), values.shape[-1] - 1)
            at_edges = sums[..., low] + (edges - low) * values[..., low]
            values = np.moveaxis(np.diff(at_edges), -1, axis)
        return values

    area = summed(plane.valid.astype(np.float64))
    mean = summed(np.nan_to_num(plane.maps["scatter"]).astype(np.float64)) / np.maximum(area, 1e-12)
    share = area * (0.09 * 0.07 / side**2)
    clear = np.abs(share - 0.5) > 1e-5
    assert np.array_equal(item["valid"].numpy()[clear], (share > 0.5)[clear])
    known = clear & (share > 0.5)
    assert np.allclose(item["maps"][0].numpy()[known], mean[known], rtol=1e-5)


def test_options_that_cannot_be_used_are_told(recipe, boards):
    dataset = sheetlight.open(boards)
    wrong = [
        (lambda: Scans(recipe), "n: a recipe has any number"),
        (lambda: Scans(dataset, 21), "n: 21 samples are asked for"),
        (lambda: Scans(dataset, 2, first=1), "first"),
        (lambda: Scans(recipe, 1, channels=["scater"]), "channels: scater; there are range, reflectance"),
        (lambda: Scans(recipe, 1, channels=[]), "channels: none"),
        (lambda: Scans(recipe, 1, crop=0), "crop: 0"),
        (lambda: Scans(recipe, -1), "n: -1: give 0 or more"),
        (lambda: Scans(recipe, 1, first=-1), "first: -1: give 0 or more"),
        (lambda: Scans(recipe, 1, first=10**8), "first, n: 100000000 [+] 1 is more"),
        (lambda: ScansStream(recipe, first=-1), "first: -1: give 0 or more"),
        (lambda: Scans(recipe, 1, seed=-1), "seed: -1"),
        (lambda: Scans(recipe, 1, channels=["range_mm"]), "channels: range_mm; there are range, .* range is in mm"),
        (lambda: Scans(recipe, 1, crop=(8, 97)), "does not fit <Recipe .* of 40 x 96 px"),
        (lambda: Scans(dataset, crop=41), "does not fit <Dataset .* of 40 x 96 px"),
        (lambda: Scans(recipe, 1, crop=41, square_pixels=True), "does not fit <Recipe"),
        (lambda: Scans(recipe, 1, crop=(40, 96), square_pixels=True)[0], r"does not fit scan 0 of [0-9]+ x [0-9]+ square pixels"),
        (lambda: Scans(recipe, 1, crop=64, square_pixels=0.31)[0], "does not fit scan 0 of .*smaller side of pixels"),
        (lambda: Scans(recipe, 1, crop=(64,)), r"crop: \(64,\): give a whole number, or two"),
        (lambda: Scans(recipe, 1, crop=(64, 32, 3)), r"crop: \(64, 32, 3\): give a whole number, or two"),
        (lambda: Scans(recipe, 1, square_pixels="yes"), "square_pixels: yes: give the side"),
        (lambda: Scans(recipe, 1, square_pixels=-0.1), "square_pixels: -0.1: give the side"),
        (lambda: Scans(recipe, 1, square_pixels=math.nan), "square_pixels: nan: give the side"),
        (lambda: Scans(recipe, 1, square_pixels=math.inf), "square_pixels: inf: give the side"),
        (lambda: Scans(recipe, 1, square_pixels=0.0), "square_pixels: 0.0: give the side"),
        (lambda: Scans(recipe, 1, square_pixels=1e3)[0], "square_pixels: 1000.0 mm is more"),
        (lambda: Scans(recipe, 1, channels=["film_gap_mm"])[0], "has no film_gap_mm; it has range_mm"),
    ]
    for call, words in wrong:
        with pytest.raises(ValueError, match=words):
            call()
    for call, words in [
        (lambda: Scans(recipe, 2.7), "n: 2.7 is no whole number"),
        (lambda: Scans(dataset, 2.7), "n: 2.7 is no whole number"),
        (lambda: Scans(recipe, 1, first=1.5), "first: 1.5 is no whole number"),
        (lambda: ScansStream(recipe, first=1.5), "first: 1.5 is no whole number"),
        (lambda: Scans(recipe, 1, seed="a"), "seed: 'a' is no whole number"),
        (lambda: Scans(recipe, 1, channels="scatter"), "channels: 'scatter': give a list"),
        (lambda: Scans(recipe, 1, crop=64.0), "crop: 64.0: give a whole number"),
        (lambda: Scans(recipe, 1, crop=True), "crop: True: give a whole number"),
        (lambda: Scans(recipe, 1, crop=(8, "8")), r"crop: \(8, '8'\): give a whole number"),
        (lambda: Scans(recipe, 1)["0"], "number: '0' is no whole number"),
    ]:
        with pytest.raises(TypeError, match=words):
            call()
    assert Scans(recipe, np.int64(1), crop=np.int64(16))[np.int64(0)]["maps"].shape == (3, 16, 16)
    with pytest.raises(TypeError, match="Recipe or a Dataset"):
        Scans("wood-small", 1)
    with pytest.raises(IndexError):
        Scans(recipe, 1)[1]
