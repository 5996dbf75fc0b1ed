"""Opens a Sheetlight dataset with the programs that people use, and asserts that all of them see the same.

    python python/check_readers.py DIR

pyarrow, Hugging Face datasets, polars, pandas, DuckDB, OpenEXR and OpenCV. Prints one line for each and exits with 1 at
the first thing that is not as `dataset.json` promises.
"""

import io
import json
import os
import sys
import tempfile
from pathlib import Path

os.environ.setdefault("HF_HUB_OFFLINE", "1")
os.environ.setdefault("HF_DATASETS_OFFLINE", "1")
os.environ.setdefault("HF_DATASETS_DISABLE_PROGRESS_BARS", "1")
os.environ["OPENCV_IO_ENABLE_OPENEXR"] = "1"

import numpy as np
import pyarrow.parquet as pq
from PIL import Image

sys.path.append(str(Path(__file__).resolve().parent / "examples"))
from sheetlight_schema import has_exr, open_dataset

DEPTH = {"range": np.uint16, "reflectance": np.uint8, "scatter": np.uint16, "grey": np.uint8, "label": np.uint8, "instance": np.uint16}

TRUTH = {"wood": {"Height", "FibreAzimuth", "FibreDive"}, "blister": {"Height", "FilmThickness", "FilmGap"}}


def expect(condition, *what):
    if not condition:
        raise SystemExit("check_readers: " + " ".join(str(w) for w in what))


def decode(png):
    """Pixels of a PNG as array."""
    return np.asarray(Image.open(io.BytesIO(png)))


def check_pyarrow(root, head, files):
    """Schema, units and rows; returns the rows by index, and the images of the first of each split."""
    numbers = {(n["group"], n["key"]): n for n in head["parameters"]}
    rows = 0
    for path in files:
        table = pq.read_table(path)
        rows += len(table)
        metadata = {k.decode() for k in table.schema.metadata}
        expect({"huggingface", "sheetlight.schema_version"} <= metadata, path, "metadata", metadata)
        for (group, key), number in numbers.items():
            field = table.schema.field(group).type.field(key)
            expect(field.metadata[b"unit"].decode() == number["unit"], group, key, "unit", field.metadata)
            expect(str(field.type) == "double", group, key, field.type)
        expect(table.schema.field("row_mm").metadata[b"unit"] == b"mm", "row_mm has no unit")
        expect(str(table.schema.field("seed").type) == "uint64", "seed", table.schema.field("seed").type)
        expect(set(table["seed"].to_pylist()) == {head["seed"]}, "seed", table["seed"])
        index = table["index"].to_pylist()
        expect(index == sorted(set(index)), path, "indices are not in order")
        for name in head["images"]["png"]:
            pixels = decode(table[name][0]["bytes"].as_py())
            shape = (head["images"]["rows"], head["images"]["cols"])
            expect((pixels.shape, pixels.dtype) == (shape, DEPTH[name]), name, pixels.shape, pixels.dtype)
    expect(rows == head["samples"], rows, "rows, not", head["samples"])
    return f"{rows} rows in {len(files)} files"


def check_stacks(root, head):
    """Sensor frames as tensors."""
    if head["images"]["stack_every"] is None:
        return "no sensor frames"
    frames = 0
    for path in sorted((root / "stacks").glob("*.parquet")):
        column = pq.read_table(path)["frame"]
        shape = [head["images"]["sensor_rows"], head["images"]["sensor_cols"]]
        expect(list(column.type.shape) == shape and str(column.type.value_type) == "uint8", column.type)
        tensor = column.combine_chunks().to_numpy_ndarray()
        expect(list(tensor.shape[1:]) == shape and tensor.dtype == np.uint8, tensor.shape, tensor.dtype)
        frames += len(tensor)
    return f"{frames} sensor frames"


def check_datasets(root, head, splits, cache):
    """Images decode, class labels have names, and the card finds the splits."""
    from datasets import ClassLabel, Image as ImageFeature, load_dataset

    found = load_dataset(str(root), cache_dir=cache)
    expect(set(found) == set(splits), "splits", set(found), "not", set(splits))
    expect(sum(len(part) for part in found.values()) == head["samples"], "rows", found)
    for name, part in found.items():
        feature = part.features["class"]
        expect(isinstance(feature, ClassLabel) and feature.names == head["classes"], "class", feature)
        objects = part.features["objects"].feature
        expect(isinstance(objects["class"], ClassLabel), "objects.class", objects["class"])
        expect(objects["class"].names == head["pixel_classes"], "objects.class", objects["class"].names)
        expect(objects["state"].names == head["pixel_classes"], "objects.state", objects["state"].names)
        sample = part[0]
        expect(sample["split"] == name, "split", sample["split"])
        for image in head["images"]["png"]:
            expect(isinstance(part.features[image], ImageFeature), image, "is", part.features[image])
            pixels = np.asarray(sample[image])
            shape = (head["images"]["rows"], head["images"]["cols"])
            expect((pixels.shape, pixels.dtype) == (shape, DEPTH[image]), image, pixels.shape, pixels.dtype)
        for each in sample["objects"]:
            expect(len(each["bbox"]) == 4, "bbox", each)
            name = head["pixel_classes"][each["class"]]
            expect(name == "pocket" or name in sample["defect_classes"], name, "is none of", sample["defect_classes"])
        for name in sample["defect_classes"]:
            expect(sample["class_area_px"][name] > 0, "no pixel shows", name)
        expect(list(sample["class_area_px"]) == [head["pixel_classes"][v] for v in head["label_values"]], sample)
    stream = load_dataset(str(root), split=splits[0], streaming=True, cache_dir=cache)
    expect(next(iter(stream))["id"] == found[splits[0]][0]["id"], "streaming differs")
    return "splits " + ", ".join(f"{name} {len(part)}" for name, part in found.items())


def first_number(head):
    """Group and key of one drawn number, if any."""
    numbers = head["parameters"]
    return (numbers[0]["group"], numbers[0]["key"]) if numbers else None


def check_tables(root, head):
    """polars, pandas and DuckDB see the same rows; DuckDB can say group.key."""
    import duckdb
    import pandas as pd
    import polars as pl

    pattern = str(root / "data" / "*.parquet")
    frame = pl.read_parquet(pattern)
    expect(frame.height == head["samples"], "polars rows", frame.height)
    pandas = pd.concat([pd.read_parquet(path) for path in sorted((root / "data").glob("*.parquet"))])
    expect(len(pandas) == head["samples"], "pandas rows", len(pandas))
    expect(sorted(frame["id"].to_list()) == sorted(pandas["id"]), "polars and pandas ids differ")
    area = head["pixel_classes"][head["label_values"][1]]
    rows = duckdb.sql(f"SELECT count(*), sum(class_area_px.{area}), max(seed) FROM '{pattern}'").fetchall()[0]
    expect(rows[0] == head["samples"] and rows[2] == head["seed"], "duckdb", rows)
    expect(rows[1] == frame["class_area_px"].struct.field(area).sum(), "duckdb and polars areas differ")
    number = first_number(head)
    if number:
        group, key = number
        ((mean,),) = duckdb.sql(f'SELECT avg("{group}"."{key}") FROM \'{pattern}\'').fetchall()
        other = frame[group].struct.field(key).mean()
        third = np.mean([row[key] for row in pandas[group]])
        expect(np.isclose(mean, other) and np.isclose(mean, third), group, key, mean, other, third)
    ((objects,),) = duckdb.sql(f"SELECT coalesce(sum(len(objects)), 0) FROM '{pattern}'").fetchall()
    expect(objects == sum(len(row) for row in pandas["objects"]), "objects differ")
    return f"{frame.height} rows, {objects} objects"


def check_exr(root, head, files, most=8):
    """OpenEXR: channels, types and attribute; equal to the images of the row. OpenCV: the channel Y."""
    if not has_exr(head):
        return "no EXR files"
    import cv2
    import OpenEXR

    checked = 0
    shard = head["samples_per_shard"]
    for path in files:
        for row in pq.read_table(path).slice(0, most).to_pylist():
            name = root / "exr" / f"{row['index'] // shard:05}" / f"{row['id']}.exr"
            with OpenEXR.File(str(name), separate_channels=True) as file:
                said = json.loads(file.header()["sheetlight"])
                channels = {key: channel.pixels.copy() for key, channel in file.channels().items()}
            expect((said["id"], said["index"]) == (row["id"], row["index"]), name, said)
            expect(said["col_mm"] == row["col_mm"] and said["row_mm"] == row["row_mm"], name, "spacing", said)
            expect(set(said["units"]) == set(channels), name, said["units"])
            for key, pixels in channels.items():
                expect(pixels.shape == (row["rows"], row["cols"]), name, key, pixels.shape)
            if head["images"]["truth_maps"]:
                expect(TRUTH[head["subject"]] <= set(channels), name, set(channels))
            compare(name, row, channels)
            if "Y" in channels:
                seen = cv2.imread(str(name), cv2.IMREAD_UNCHANGED)
                expect(seen is not None and np.array_equal(seen, np.nan_to_num(channels["Reflectance"])), name, "OpenCV differs")
            checked += 1
    return f"{checked} files, channels {sorted(channels)}"


def compare(name, row, channels):
    """Channels against the images of the row."""
    for key in DEPTH:
        pixels = channels.get(key.capitalize())
        if pixels is None or key not in row:
            continue
        png = decode(row[key]["bytes"]).astype(np.float64)
        if key == "range":
            expect(pixels.dtype == np.float32, name, pixels.dtype)
            expect(np.array_equal(np.isnan(pixels), png == 0), name, "missing pixels differ")
            heights = row["range_offset_mm"] + png * row["range_scale_mm"]
            inside = (png > 1) & (png < 65535)
            worst = np.abs(pixels - heights)[inside].max(initial=0)
            # EXR heights come in steps of 2^-13 mm.
            expect(worst <= row["range_scale_mm"] * 0.501 + 2**-14, name, "range differs by", worst, "mm")
        elif key in ("label", "instance"):
            expect(np.array_equal(pixels.astype(np.float64), png), name, key, "differs")
        else:
            if "Range" in channels:
                expect(np.array_equal(np.isnan(pixels), np.isnan(channels["Range"])), name, key, "missing differ")
            unsaturated = png < np.iinfo(DEPTH[key]).max
            worst = np.abs(np.nan_to_num(pixels) - png)[unsaturated].max(initial=0)
            expect(worst <= 0.5625, name, key, "differs by", worst, "DN")


def main():
    if len(sys.argv) != 2:
        raise SystemExit(__doc__)
    root = Path(sys.argv[1]).resolve()
    head = open_dataset(root)
    files = sorted((root / "data").glob("*.parquet"))
    names = [path.name.split("-")[0] for path in files]
    splits = [name for name in ("train", "validation", "test") if name in names]
    expect(files, "no files in", root / "data")
    print("pyarrow: ", check_pyarrow(root, head, files))
    print("tensors: ", check_stacks(root, head))
    with tempfile.TemporaryDirectory() as cache:
        print("datasets:", check_datasets(root, head, splits, cache))
    print("tables:  ", check_tables(root, head))
    print("EXR:     ", check_exr(root, head, files))


if __name__ == "__main__":
    main()
