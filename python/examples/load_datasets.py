"""Hugging Face datasets: one line loads a folder, with decoded images, class names and splits.

    python python/examples/load_datasets.py DIR

Prints the splits, Range in physical units and the labels of the first sample, and how to stream.
"""

import os

# A folder needs no hub; without these lines `datasets` asks it whether the name is known there.
os.environ.setdefault("HF_HUB_OFFLINE", "1")
os.environ.setdefault("HF_DATASETS_DISABLE_PROGRESS_BARS", "1")

from sheetlight_schema import exr_path, folder, has_exr, needed

with needed():
    import numpy as np
    from datasets import load_dataset


def range_map(row):
    """Range of a row as float32 [rows, cols], NaN where nothing was measured, and its unit."""
    unit = "mm" if "range_offset_mm" in row else "px"
    pixels = np.asarray(row["range"])  # uint16: PIL decodes 16-bit PNG as it is
    heights = row[f"range_offset_{unit}"] + pixels * row[f"range_scale_{unit}"]
    return np.where(pixels == 0, np.nan, heights).astype(np.float32), unit


def main():
    root, head = folder(__doc__)

    # The one line. Images are PIL images; `.with_format("numpy")` makes them arrays [H, W], "torch" tensors [1, H, W], uint8
    # or uint16. torch has no max, min or mean of uint16: say `.float()` first.
    scans = load_dataset(str(root))

    for name, part in scans.items():
        print(f"split {name}: {len(part)} samples")
    first = next(iter(scans.values()))
    # ClassLabel: numbers in the rows, names here.
    print("classes:", ", ".join(first.features["class"].names))

    # Numbers without decoding an image: take columns first.
    for label, name in enumerate(first.features["class"].names):
        print(f"class {name}: {sum(part['class'][:].count(label) for part in scans.values())} samples")

    row = first[0]  # decodes the images of this one row
    print(f"sample {row['index']}: class {first.features['class'].int2str(row['class'])}, {len(row['objects'])} objects")
    if "range" in row:
        heights, unit = range_map(row)
        seen = heights[~np.isnan(heights)]
        span = f"{seen.min():.3f} to {seen.max():.3f}" if seen.size else "nothing"
        print(f"Range: {span} {unit}, missing {np.isnan(heights).sum()} px of {heights.size}")
    if "reflectance" in row:
        pixels = np.asarray(row["reflectance"])  # uint8, or uint16 for cameras of 10 and 12 bits
        print(f"Reflectance: {pixels.dtype}, sum {pixels.sum(dtype=np.int64)} DN")
    if "label" in row:
        names = first.features["objects"].feature["class"].names  # pixel classes, the same as in label images
        for value, count in zip(*np.unique(np.asarray(row["label"]), return_counts=True)):
            print(f"label {names[value]}: {count} px")
    if not head["images"]["png"]:
        # Tables without images: numbers and objects come as before, maps are read from the EXR files, where there are any.
        exr = exr_path(root, head, row).relative_to(root)
        print("images: none in the tables;", f"maps are in {exr}" if has_exr(head) else "none in EXR files either")

    # Streaming: nothing is cached, rows come one by one; for datasets larger than the disk of the machine.
    stream = load_dataset(str(root), split=next(iter(scans)), streaming=True)
    print("streamed:", next(iter(stream.shuffle(seed=1, buffer_size=1)))["id"])


if __name__ == "__main__":
    main()
