"""OpenEXR: one file a sample with every map, for programs that read EXR alone (Nuke, OpenCV, viewers).

    python python/examples/rejoin_exr.py DIR [OUT]

The tables of a dataset hold the measured images, its EXR files what PNG cannot hold. This joins both: OUT/<index>.exr
(without OUT, DIR-exr) has the channels that `output.exr: all` writes, with the same bits.
"""

import io
import json
import sys
from pathlib import Path

from sheetlight_schema import exr_path, has_exr, needed, open_dataset

with needed():
    import numpy as np
    import OpenEXR
    import pyarrow.parquet as pq
    from PIL import Image

# Heights are kept in steps of 2^-13 mm (px where uncalibrated).
STEPS = 8192.0
LIGHT = ("reflectance", "scatter", "grey")


def left(numbers, rest):
    """Steps that each number of Range leaves: those of `rest`, and where it is 0 those of the same number higher up in the column."""
    numbers = np.maximum(numbers.astype(np.int32) - int(numbers[numbers > 0].min(initial=65535)) + 1, 0)
    before = np.full((numbers.shape[1], int(numbers.max()) + 1), 2**15, np.int32)
    columns, steps = np.arange(numbers.shape[1]), np.empty(numbers.shape)
    for row, own, new in zip(steps, numbers, rest.astype(np.int32)):
        before[columns, own] = np.where(new > 0, new, before[columns, own])
        row[:] = before[columns, own] - 2**15
    return steps


def decoded(row, head, rest):
    """The images of a row as channels of EXR: float32, NaN where nothing was measured; `rest` is the channel RangeRest."""
    pixels = {name: np.asarray(Image.open(io.BytesIO(row[name]["bytes"]))) for name in head["images"]["png"]}
    maps = {name.capitalize(): image.astype(np.float32) for name, image in pixels.items() if name not in LIGHT}
    if "range" in pixels:
        unit = "px" if head["images"]["range"] == "uncalibrated" else "mm"
        height = row[f"range_offset_{unit}"] + pixels["range"].astype(np.float64) * row[f"range_scale_{unit}"]
        steps = height.astype(np.float32).astype(np.float64) * STEPS
        stepped = np.trunc(steps + np.copysign(0.5, steps)) / STEPS
        maps["Range"] = np.where(pixels["range"] == 0, np.nan, stepped + (0 if rest is None else left(pixels["range"], rest) / STEPS)).astype(np.float32)
    # Reflectance is 0 where no line was found, and so is Range.
    found = next((pixels[name] != 0 for name in ("range", "reflectance") if name in pixels), None)
    for name in LIGHT:
        if name in pixels:
            seen = pixels[name] != 0 if found is None or name == "grey" else found
            maps[name.capitalize()] = np.where(seen, pixels[name].astype(np.float32), np.float32("nan"))
    return maps


def joined(root, head, row):
    """Every channel of a sample by name, and its header: those of the EXR file, where there is one, come first."""
    held, said = {}, {"id": row["id"], "index": row["index"], "row_mm": row["row_mm"], "col_mm": row["col_mm"]}
    if has_exr(head):
        with OpenEXR.File(str(exr_path(root, head, row)), separate_channels=True) as file:
            held = {name: channel.pixels.copy() for name, channel in file.channels().items()}
            said = json.loads(file.header()["sheetlight"])
    maps = decoded(row, head, held.pop("RangeRest", None)) | held
    half = ["Label"] if head["images"]["bits"] > 8 else ["Label", "Reflectance", "Grey"]
    if "Reflectance" in maps:
        maps["Y"] = np.nan_to_num(maps["Reflectance"])  # the name that OpenCV and viewers look for
        half += ["Y"] if "Reflectance" in half else []
    channels = {name: pixels.astype(np.float16) if name in half else pixels for name, pixels in sorted(maps.items())}
    return channels, said


def main():
    if len(sys.argv) not in (2, 3):
        raise SystemExit(__doc__)
    root = Path(sys.argv[1])
    head, out = open_dataset(root), Path(sys.argv[2]) if len(sys.argv) == 3 else root.with_name(f"{root.resolve().name}-exr")
    out.mkdir(parents=True, exist_ok=True)
    wanted = ["id", "index", "row_mm", "col_mm", *head["images"]["png"]]
    for file in sorted((root / "data").rglob("*.parquet")):
        table = pq.ParquetFile(file)
        scale = [name for name in table.schema_arrow.names if name.startswith(("range_offset_", "range_scale_"))]
        for batch in table.iter_batches(batch_size=1, columns=wanted + scale):
            row = batch.to_pylist()[0]
            channels, said = joined(root, head, row)
            if not channels:
                raise SystemExit(f"{root}: it was made without images; make it anew with output.png or output.exr")
            header = {"compression": OpenEXR.PIZ_COMPRESSION, "type": OpenEXR.scanlineimage, "sheetlight": json.dumps(said)}
            OpenEXR.File(header, channels).write(str(out / f"{row['index']:08}.exr"))
            print(f"{row['index']:08}.exr: {', '.join(channels)}")


if __name__ == "__main__":
    main()
