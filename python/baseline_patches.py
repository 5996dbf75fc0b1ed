"""Patches of a dataset that `gen` made, cut and shrunk exactly as `gen check` does (docs/guide/check.md), for train_baseline.py."""

import io
import sys
from collections import namedtuple
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent / "examples"))
from sheetlight_schema import needed, open_dataset

with needed():
    import numpy as np
    import pyarrow.parquet as pq
    import torch
    from PIL import Image

CHANNELS = ("range", "reflectance", "scatter")

# Whose class is asked, the window around it and what becomes of it (rows, columns) [px], how many of each class a check
# asks about, whether the network takes the logarithm of light, and of which pixel classes of the dataset each class of the
# model is made.
Task = namedtuple("Task", "kind window size most logarithm classes")
TABLET = ["pocket", "broken", "chipped", "cracked", "capped", "foreign_tablet", "wrong_coat", "double", "particle",
          "fibre", "powder", "shallow", "collapsed", "punctured", "pinhole", "channel"]
TASKS = {
    "wood": Task("classify_pixels", (96, 96), (32, 32), 1000, False,
                 {"clear": ["clear"], "knot": ["sound_knot", "dead_knot"], "rot": ["rot"]}),
    "grading": Task("classify_pixels", (96, 96), (32, 32), 300, False,
                    {"clear": ["clear"], "sound_knot": ["sound_knot"], "dead_knot": ["dead_knot"], "rot": ["rot"],
                     "blue_stain": ["blue_stain"], "compression_wood": ["compression_wood"],
                     "resin": ["resin_pocket", "resin_streak"], "bark_pocket": ["bark_pocket"],
                     "crack": ["check", "shake", "split"], "hole": ["knot_hole", "insect_hole"]}),
    "blister": Task("classify_objects", (160, 128), (32, 32), 300, True,
                    {"present": ["pocket"], "missing": ["missing"], "broken": ["broken"]}),
    "presence": Task("classify_objects", (160, 128), (32, 32), 300, True, {"present": TABLET, "missing": ["missing"]}),
}

# What training looks at: windows `x` [patches, channels, rows, columns], heights less the mean of their window, NaN where
# missing; the class `y` of each; the index `sample` of its scan.
Patches = namedtuple("Patches", "x y sample")


def truth_of(head, task):
    """Class of the model of each pixel class of the dataset, -1 for none."""
    names = head["pixel_classes"]
    unknown = [name for of in task.classes.values() for name in of if name not in names]
    if unknown:
        sys.exit(f"the dataset knows no pixel class {', '.join(unknown)}: train it for another --task")
    truth = np.full(len(names), -1)
    for number, of in enumerate(task.classes.values()):
        truth[[names.index(name) for name in of]] = number
    return truth


def rows(tables, columns, step):
    """Every row of the tables as a plain dictionary, `step` in memory at a time."""
    for table in tables:
        with pq.ParquetFile(table) as file:
            for batch in file.iter_batches(batch_size=step, columns=columns):
                yield from batch.to_pylist()


def portion(total, rank, count):
    """How many of `total` entry number `rank` of `count` gets, so that all together get `total`."""
    return (rank + 1) * total // count - rank * total // count


def plan_pixels(tables, task, truth, names, patches):
    """How many pixels of each class to draw from each sample, by its index: shared evenly among those that show it."""
    areas = {row["index"]: row["class_area_px"] for row in rows(tables, ["index", "class_area_px"], 256)}
    wanted = {index: [0] * len(task.classes) for index in areas}
    for number in range(len(task.classes)):
        shown = [name for value, name in enumerate(names) if truth[value] == number]
        showing = [index for index, area in areas.items() if any(area.get(name, 0) for name in shown)]
        for rank, index in enumerate(showing):
            wanted[index][number] = portion(patches, rank, len(showing))
    return wanted


def draw_pixels(labels, task, truth, wanted, seed, index):
    """First pixels (row, column) of windows around drawn pixels whose window lies inside the image, and their classes."""
    low = [side // 2 for side in task.window]
    high = [n - w + w // 2 + 1 for n, w in zip(labels.shape, task.window)]
    classes = truth[labels[low[0]:high[0], low[1]:high[1]]]
    firsts, found = [], []
    for number, count in enumerate(wanted):
        places = np.flatnonzero(classes == number)
        chosen = np.random.default_rng([seed, index, number]).permutation(len(places))[:count]
        firsts.extend(zip(*np.unravel_index(places[chosen], classes.shape)))
        found.extend([number] * len(chosen))
    return firsts, found


def object_windows(objects, task, truth):
    """First pixels of windows around the middle of every object that lies in no other, and their classes."""
    firsts, found = [], []
    for thing in objects:
        number = truth[thing["state"]]
        if thing["within"] == 0 and number >= 0:
            left, top, cols, high = thing["bbox"]
            middle = (top + high // 2, left + cols // 2)
            firsts.append(tuple(m - w // 2 for m, w in zip(middle, task.window)))
            found.append(int(number))
    return firsts, found


def measured(row, name):
    """A map in its unit [mm or DN], NaN where nothing was measured."""
    pixels = np.asarray(Image.open(io.BytesIO(row[name]["bytes"]))).astype(np.float32)
    values = row["range_offset_mm"] + pixels * row["range_scale_mm"] if name == "range" else pixels
    return np.where(pixels == 0, np.nan, values).astype(np.float32)


def shrink(plane, firsts, task):
    """Windows of a map, each cell the mean of what was measured in it; outside of the image nothing was."""
    (high, wide), (tall, broad) = task.window, task.size
    padded = np.pad(plane, [(high, high), (wide, wide)], constant_values=np.nan)
    cut = np.stack([padded[r + high:r + 2 * high, c + wide:c + 2 * wide] for r, c in firsts])
    cells = cut.reshape(len(firsts), tall, high // tall, broad, wide // broad)
    known = ~np.isnan(cells)
    count = known.sum(axis=(2, 4))
    total = np.where(known, cells, 0).sum(axis=(2, 4), dtype=np.float64)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan).astype(np.float32)


def cut_patches(folder, task, channels, split, patches, seed):
    """The patches of a split (or of all, for None); about `patches` of each class where pixels are drawn."""
    head = open_dataset(folder)
    lacking = [name for name in channels if name not in head["images"]["png"]]
    if lacking:
        sys.exit(f"{folder} has no PNG images of {', '.join(lacking)}: name them under `output.png` in the recipe")
    if "range" in channels and head["images"]["range"] == "uncalibrated":
        sys.exit(f"Range of {folder} is in sensor rows: make it anew with `extraction: {{range: calibrated}}`, or leave "
                 "range out of --channels")
    tables = sorted((folder / "data").rglob(f"{split or '*'}-*.parquet"))
    truth, pixels = truth_of(head, task), task.kind == "classify_pixels"
    wanted = plan_pixels(tables, task, truth, head["pixel_classes"], patches) if pixels else {}
    scale = ["range_offset_mm", "range_scale_mm"] if "range" in channels else []
    columns = ["index", *scale, *channels, "label" if pixels else "objects"]
    # Half precision: 1 um of 2 mm, 2 DN of 4000. Numbers of more than 8 bits do not fit.
    precision = np.float16 if head["images"].get("bits", 8) == 8 else np.float32
    x, y, sample = [], [], []
    for row in rows(tables, columns, 8):
        if pixels:
            labels = np.asarray(Image.open(io.BytesIO(row["label"]["bytes"])))
            firsts, found = draw_pixels(labels, task, truth, wanted[row["index"]], seed, row["index"])
        else:
            firsts, found = object_windows(row["objects"], task, truth)
        if not found:
            continue
        windows = np.stack([shrink(measured(row, name), firsts, task) for name in channels], axis=1)
        for channel in (i for i, name in enumerate(channels) if name == "range"):
            heights = windows[:, channel]
            known = np.maximum((~np.isnan(heights)).sum(axis=(1, 2), keepdims=True), 1)
            heights -= np.nansum(heights, axis=(1, 2), keepdims=True, dtype=np.float64) / known
        x.append(windows.astype(precision))
        y.extend(found)
        sample.extend([row["index"]] * len(found))
    if len(set(y)) < len(task.classes):
        sys.exit(f"{folder}, split {split or 'all'}: not every class of {', '.join(task.classes)} is there: make more "
                 "samples, or take a recipe that has them")
    return Patches(torch.from_numpy(np.concatenate(x)), torch.tensor(y), np.array(sample))
