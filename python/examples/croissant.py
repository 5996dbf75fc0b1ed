"""Croissant: what mlcroissant makes of croissant.json, and the records of a split with their images.

    python python/examples/croissant.py DIR

Always give a filter on `samples/split`: mlcroissant then reads file by file. Without one it joins the samples with the list
of splits, and holds every image of the dataset for that.
"""

import os

os.environ.setdefault("HF_HUB_OFFLINE", "1")

from sheetlight_schema import folder, needed

with needed():
    import mlcroissant
    import numpy as np


def main():
    root, head = folder(__doc__)

    # The one line: refuses metadata that is not as the specification wants it.
    dataset = mlcroissant.Dataset(str(root / "croissant.json"))

    issues = dataset.metadata.ctx.issues
    print(f"accepted: {len(issues.errors)} errors, {len(issues.warnings)} warnings, version {dataset.metadata.version}")
    classes = {record["classes/number"]: record["classes/name"] for record in dataset.records("classes")}
    print("classes:", ", ".join(classes[number] for number in sorted(classes)))
    pixel_classes = {record["pixel_classes/number"]: record["pixel_classes/name"] for record in dataset.records("pixel_classes")}
    print("pixel classes:", ", ".join(f"{value} {name}" for value, name in pixel_classes.items()))

    for split in [record["splits/name"] for record in dataset.records("splits")]:
        samples = 0
        for record in dataset.records("samples", filters={"samples/split": split}):
            samples += 1
            if samples == 1:
                print(f"first of {split}: sample {record['samples/index']}, class {classes[record['samples/class']]}")
                for name in head["images"]["png"]:
                    pixels = np.asarray(record[f"samples/{name}"])  # a PIL image, decoded here
                    print(f"{split} {name}: {pixels.dtype} {pixels.shape}, sum {pixels.sum(dtype=np.int64)}")
                for thing in record["samples/objects"]:
                    kind = pixel_classes[thing["samples/objects/class"]] if thing["samples/objects/class"] is not None else None
                    if kind:
                        print(f"{split} object {kind}: box {[int(n) for n in thing['samples/objects/bbox']]}")
        print(f"split {split}: {samples} samples")

    if head["images"]["stack_every"] is not None:
        frame = next(iter(dataset.records("frames")))
        shape = (head["images"]["sensor_rows"], head["images"]["sensor_cols"])
        pixels = np.asarray(frame["frames/frame"]).reshape(shape)
        print(f"frame {frame['frames/profile']} of sample {frame['frames/index']}: {pixels.shape}, sum {pixels.sum(dtype=np.int64)}")


if __name__ == "__main__":
    main()
