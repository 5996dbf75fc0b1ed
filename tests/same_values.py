#!/usr/bin/env python3
"""Whether two folders of datasets hold the same values, whatever their ids, hashes and documents are.

    .venv/bin/python tests/same_values.py REF NEW      (tests/same_bytes.sh values, make same-values REF=<commit>)

Datasets of the same name are compared sample by sample, by seed and index: every column that both have, fields of structs
one by one, images as pixels, EXR files as channels, kept frames as numbers, those in the real camera's files as bytes.
Floating-point numbers are equal bit for bit.
Ids, and columns and fields that only NEW has, may differ; one that only REF has is a difference.
"""

import io
import pathlib
import sys

import numpy as np
import OpenEXR
import pyarrow as pa
import pyarrow.parquet as parquet
from PIL import Image

# What names a sample and follows from the recipe's text.
NAMES = {"id"}


def bits(array):
    """An array's numbers as bytes, with type and shape: a NaN equals itself, -0.0 is not 0.0."""
    array = np.asarray(array)
    return array.dtype.str, array.shape, array.tobytes()


def value_of(scalar):
    """A cell as something that compares bit for bit."""
    if isinstance(scalar, float):
        return np.float64(scalar).tobytes()
    if isinstance(scalar, dict):
        if set(scalar) == {"bytes", "path"} and scalar["bytes"]:
            with Image.open(io.BytesIO(scalar["bytes"])) as image:
                return bits(image)
        return {key: value_of(value) for key, value in scalar.items() if key != "path"}
    if isinstance(scalar, list):
        return [value_of(value) for value in scalar]
    return scalar


def differing(path, ref, new):
    """Names of what two cells don't share: fields of structs one by one."""
    if isinstance(ref, dict) and isinstance(new, dict):
        for key in ref:
            yield from differing(f"{path}.{key}", ref[key], new[key]) if key in new else [f"{path}.{key} is gone"]
    elif isinstance(ref, list) and isinstance(new, list) and len(ref) == len(new):
        for number, (one, other) in enumerate(zip(ref, new)):
            yield from differing(f"{path}[{number}]", one, other)
    elif ref != new:
        yield path


def rows(folder, table):
    """Rows of all files of a table of a dataset."""
    for file in sorted((folder / table).glob("**/*.parquet")):
        for batch in parquet.ParquetFile(file).iter_batches(batch_size=1):
            yield {name: batch.column(name)[0] for name in batch.schema.names}


def samples(folder):
    """Seed and index of each sample: its cells, its channels and its kept frames."""
    found, by_id = {}, {}
    for row in rows(folder, "data"):
        cells = {name: value_of(scalar.as_py()) for name, scalar in row.items()}
        key = cells["seed"], cells["index"]
        by_id[cells["id"]] = key
        found[key] = {name: value for name, value in cells.items() if name not in NAMES}
    for file in sorted((folder / "exr").glob("**/*.exr")):
        sample = found[by_id[file.stem]]
        with OpenEXR.File(str(file), separate_channels=True) as image:
            sample["exr"] = {name: bits(channel.pixels) for name, channel in image.channels().items()}
    for row in rows(folder, "stacks"):
        sample = found[by_id[row["id"].as_py()]]
        frame = row["frame"]
        frame = frame.value if isinstance(frame, pa.ExtensionScalar) else frame
        numbers = np.asarray(frame.values if hasattr(frame, "values") else frame)
        sample.setdefault("frames", {})[str(row["profile"].as_py())] = bits(numbers)
    return found


def sensor_frames(folder):
    """Bytes of the real camera's files, which hold a kept frame of each sample."""
    return {file.name: file.read_bytes() for file in folder.glob("*.dat")}


def main(ref, new):
    datasets = sorted(path.parent.name for path in ref.glob("*/dataset.json"))
    if not datasets:
        sys.exit(f"{ref} holds no dataset")
    differences, count, frames = [], 0, 0
    for name in datasets:
        if not (new / name / "dataset.json").exists():
            differences.append(f"{name}: only the reference made it")
            continue
        before, after = samples(ref / name), samples(new / name)
        count += len(before)
        one, other = (sensor_frames(root / f"{name}-sensor") for root in (ref, new))
        frames += len(one)
        differences += [f"{name}-sensor/{file}" for file in sorted(one) if one[file] != other.get(file)]
        if before.keys() != after.keys():
            differences.append(f"{name}: samples {sorted(before)} and {sorted(after)}")
        for key in before.keys() & after.keys():
            places = list(differing("", before[key], after[key]))
            more = f" and {len(places) - 8} more" if len(places) > 8 else ""
            if places:
                differences.append(f"{name}: seed {key[0]}, index {key[1]}: {', '.join(p[1:] for p in places[:8])}{more}")
    print(f"{len(datasets)} datasets, {count} samples, {frames} sensor frames in files of the camera")
    if differences:
        sys.exit("\n".join([*differences, f"the values differ: the datasets lie in {ref} and {new}"]))
    print("the same values")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*map(pathlib.Path, sys.argv[1:]))
