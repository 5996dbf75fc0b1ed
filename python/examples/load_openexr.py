"""OpenEXR: the maps of a sample's EXR file in physical units, NaN where nothing was measured.

    python python/examples/load_openexr.py DIR

The attribute `sheetlight` holds id, index, spacing and units as JSON. C++ reads the same: channels by name from one part
of scan lines, as OpenEXR's `InputFile` gives them. Measured images lie in the tables, unless `output.exr` asks for them;
rejoin_exr.py puts all into one file.
"""

import json

from sheetlight_schema import exr_path, folder, has_exr, needed

with needed():
    import numpy as np
    import OpenEXR
    import pyarrow.parquet as pq


def main():
    root, head = folder(__doc__)
    if not has_exr(head):
        remedy = ", or read the PNG images (load_datasets.py)" if head["images"]["png"] else ""
        raise SystemExit(f"this dataset holds no EXR files; make it anew with output.exr{remedy}")
    file = sorted((root / "data").rglob("*.parquet"))[0]
    row = pq.read_table(file, columns=["id", "index"]).slice(0, 1).to_pylist()[0]
    path = exr_path(root, head, row)

    # The one line. Without separate_channels, names that end in R, G, B would be joined.
    with OpenEXR.File(str(path), separate_channels=True) as scan:
        maps = {name: channel.pixels for name, channel in scan.channels().items()}
        said = json.loads(scan.header()["sheetlight"])

    rows, cols = next(iter(maps.values())).shape
    print(f"sample {said['index']}: {rows} rows of {said['row_mm']} mm, {cols} columns of {said['col_mm']} mm")
    for name, pixels in maps.items():
        seen = pixels[~np.isnan(pixels)].astype(np.float64)  # np.nanmean and its kin do the same
        mean = f"mean {seen.mean():.6f}" if seen.size else "nothing seen"
        print(f"{name}: {pixels.dtype}, {mean} [{said['units'][name]}], missing {pixels.size - seen.size} px")


if __name__ == "__main__":
    main()
