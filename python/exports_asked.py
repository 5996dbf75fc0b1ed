"""What must be in an export by the dataset and by what was asked on the command line, never by what the export says."""

import argparse
import hashlib
import io
import json

import numpy as np
import pyarrow.parquet as pq
from PIL import Image

IMAGES = ["range", "reflectance", "scatter", "grey", "label", "instance"]
SPLITS = ["train", "validation", "test"]
SHOWN = {name: [name] for name in IMAGES[:4]} | {"rgb": IMAGES[:3]}
GOOD = {"wood": ["clear"], "blister": ["flange", "pocket"]}


def request(arguments):
    """The options of `gen export`, with the defaults that its help names."""
    parser = argparse.ArgumentParser()
    parser.add_argument("format")
    parser.add_argument("dataset")
    parser.add_argument("export")
    parser.add_argument("--split", default="all")
    parser.add_argument("--index", type=lambda text: [span(part) for part in text.split(",")], default=[])
    parser.add_argument("--image", default="reflectance")
    parser.add_argument("--range-ends", type=ends)
    parser.add_argument("--scatter-ends", type=ends)
    parser.add_argument("--bits", type=int, default=8)
    parser.add_argument("--mask", default="whole")
    parser.add_argument("--plain-rle", action="store_true")
    parser.add_argument("--good", type=lambda text: text.split(","), default=[])
    parser.add_argument("--patch-px", type=int)
    parser.add_argument("--maps", type=lambda text: text.split(","), default=[])
    parser.add_argument("--tar-mb", type=int, default=500)
    parser.add_argument("--colour", action="store_true")
    # Argparse takes a value that begins with a minus for an option.
    joined = [*arguments]
    for at, word in reversed(list(enumerate(arguments))):
        if word.endswith("-ends"):
            joined[at : at + 2] = [f"{word}={arguments[at + 1]}"]
    return parser.parse_args(joined)


def span(text):
    first, _, last = text.partition("-")
    return [int(first), int(last or first)]


def ends(text):
    return [float(number) for number in text.split(",")]


def stored(dataset):
    """Every row of the finished shards by index, in order: numbers, and images decoded by Pillow; from EXR where there is
    no image. And `dataset.json`."""
    head = json.loads((dataset / "dataset.json").read_text())
    rows = {}
    for manifest in sorted((dataset / "shards").glob("*.json")):
        for path in sorted((dataset / "data").glob(f"*-{manifest.stem}.parquet")):
            for row in pq.read_table(path).to_pylist():
                images, png = {}, {}
                for name in IMAGES:
                    if name in row:
                        png[name] = row.pop(name)["bytes"]
                        images[name] = np.array(Image.open(io.BytesIO(png[name])))
                if len(images) < len(IMAGES) and (exr := dataset / "exr" / manifest.stem / f"{row['id']}.exr").exists():
                    images = from_exr(exr, row) | images
                rows[row["index"]] = {"row": row, "images": images, "png": png}
    return head, dict(sorted(rows.items()))


def from_exr(path, row):
    """The maps of an EXR file in the numbers of PNG columns."""
    import OpenEXR

    found = OpenEXR.File(str(path), separate_channels=True).channels()
    maps = {name: found[name.capitalize()].pixels.astype(float) for name in IMAGES if name.capitalize() in found}
    for name, pixels in maps.items():
        if name == "range":
            offset, scale = meaning(row)
            pixels = np.clip(np.rint((pixels - offset) / scale), 1, 65535)
            pixels[np.isnan(maps["range"])] = 0
        maps[name] = np.rint(np.nan_to_num(pixels, nan=0.0)).astype(int)
    return maps


def meaning(row):
    """Offset and scale of Range [mm, or px of an uncalibrated dataset]."""
    unit = "mm" if "range_offset_mm" in row else "px"
    return row[f"range_offset_{unit}"], row[f"range_scale_{unit}"]


def splits(asked):
    """The splits that are exported: the layout of MVTec AD has no place for validation."""
    every = [split for split in SPLITS if asked.format != "mvtec" or split != "validation"]
    return every if asked.split == "all" else [asked.split]


def chosen(asked, rows):
    """The samples that are exported."""
    found = {}
    for index, sample in rows.items():
        is_there = not asked.index or any(first <= index <= last for first, last in asked.index)
        if is_there and sample["row"]["split"] in splits(asked):
            found[index] = sample
    return found


def maps(asked, rows):
    """The maps that `--maps` asks for, in the order of columns."""
    known = next(iter(rows.values()))["images"]
    return [name for name in IMAGES if name in (asked.maps or known)]


def values(sample, name):
    """A map in what its numbers mean [mm, px or DN], and where it is missing."""
    numbers = sample["images"][name].astype(float)
    offset, scale = meaning(sample["row"]) if name == "range" else (0.0, 1.0)
    return offset + scale * numbers, numbers == 0


def expected_ends(asked, head, rows, name):
    """The ends of a map's grey levels: those that were asked for, else the quantiles; and how far they may lie off."""
    given = {"range": asked.range_ends, "scatter": asked.scatter_ends}.get(name)
    if given or name in ("reflectance", "grey"):
        return given or [1.0, max(255.0, 2.0 ** head["images"]["bits"] - 1)], 1e-9
    everything, count = list(rows.values()), min(64, len(rows))
    pixels = []
    for i in range(count):
        sample = everything[i * len(everything) // count]
        found, missing = values(sample, name)
        shown = sample["images"]["label"] > 0 if "label" in sample["images"] else True
        pixels.append(found[shown & ~missing])
    pixels = np.sort(np.concatenate(pixels))
    beyond = int(0.001 * len(pixels))
    # Heights are counted in hundredths.
    return [pixels[beyond], pixels[-1 - beyond]], 0.005 + 1e-9 if name == "range" else 1e-9


def check_scaling(asked, head, rows, scaling):
    """What an export says of its levels: the maps that were asked for, with ends that the dataset has."""
    if asked.bits == 16:
        assert scaling is None, scaling
        return
    assert [one["map"] for one in scaling] == SHOWN[asked.image], scaling
    for one in scaling:
        is_height = one["map"] == "range"
        assert one["unit"] == (("px" if head["images"]["range"] == "uncalibrated" else "mm") if is_height else "DN")
        wanted, error = expected_ends(asked, head, rows, one["map"])
        found = [one["offset"] + level * one["scale"] for level in (1, 255)]
        assert np.abs(np.subtract(found, wanted)).max() <= error, (one["map"], found, wanted)


def check_picture(asked, picture, sample, scaling):
    """Whether a picture shows the maps that were asked for, each level rounded to the nearest."""
    planes = picture if picture.ndim == 3 else picture[..., None]
    names = SHOWN[asked.image]
    assert planes.shape[-1] == len(names), (planes.shape, names)
    if asked.bits == 16:
        numbers = sample["images"][names[0]]
        assert (picture == numbers).all() and picture.dtype == np.uint16, (names, picture.dtype)
        return
    assert picture.dtype == np.uint8
    for channel, (name, one) in enumerate(zip(names, scaling)):
        found, missing = values(sample, name)
        levels = np.where(missing, 0, np.clip((found - one["offset"]) / one["scale"], 1, 255))
        worst = np.abs(planes[..., channel] - levels).max()
        assert worst <= 0.5 + 1e-6, f"{name}: levels differ by {worst}"
        assert ((planes[..., channel] == 0) == missing).all(), "missing is 0 and nothing else is"


def check_document(asked, wanted, dataset, export, head):
    """`export.json` holds the options that are wanted, of which dataset, and what there is; gives its result."""
    told = json.loads((export / "export.json").read_text())
    order = told["order"]
    assert (order["format"], order["options"]) == (asked.format, wanted), (order, wanted)
    manifests = b"".join(path.read_bytes() for path in sorted((dataset / "shards").glob("*.json")))
    assert order["source"] == {
        "dataset": head["recipe"]["name"],
        "subject": head["subject"],
        "seed": head["seed"],
        "dataset_sha256": hashlib.sha256((dataset / "dataset.json").read_bytes()).hexdigest(),
        "manifests_sha256": hashlib.sha256(manifests).hexdigest(),
        "splits": splits(asked),
        "indices": asked.index,
    }, order
    files = [path for path in export.rglob("*") if path.is_file() and path.name != "export.json"]
    assert (told["files"], told["bytes"]) == (len(files), sum(path.stat().st_size for path in files)), told
    return told["result"]
