"""Turns Range of an uncalibrated Sheetlight dataset into places in the laser plane: x along the line, z upwards [mm].

    python python/calibrate.py ROWS            prints what each sample spans
    python python/calibrate.py ROWS HEIGHTS    and asserts that the heights are those of a calibrated dataset of the
                                               same recipe and seed, within 1 um

ROWS is a dataset made with `extraction: {range: uncalibrated}`; its column `calibration` holds the camera. `locate` and
`along` are all that is needed, and are meant to be copied. The same way goes the program itself (crates/scanner/src/frame/rig.rs):

    s = (centre_row - row) p          v = v0 + s sin b
    (xd, yd) = ((col - centre_col) p, s cos b) / v
    (xn, yn) = (xd, yd) without distortion
    z = yn d / (sin a + yn cos a)     x = xn (d - z cos a)

with the pixel p, the image distance v0, the sensor's tilt b, the distance d and the camera's tilt a. Column j of an image
is the sensor column (j + 1/2) * sensor_cols / cols - 1/2.
"""

import io
import json
import sys
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
from PIL import Image

sys.path.append(str(Path(__file__).resolve().parent / "examples"))
from sheetlight_schema import open_dataset


def bend(c, x, y):
    """Where the direction (x, y) goes: Brown and Conrady."""
    r2 = x * x + y * y
    gain = 1 + r2 * (c["k1"] + r2 * (c["k2"] + r2 * c["k3"]))
    return (
        x * gain + 2 * c["p1"] * x * y + c["p2"] * (r2 + 2 * x * x),
        y * gain + c["p1"] * (r2 + 2 * y * y) + 2 * c["p2"] * x * y,
    )


def straighten(c, xd, yd):
    """The direction that is bent to (xd, yd), by repetition; each turn leaves a few per cent of the error."""
    x, y = xd, yd
    for _ in range(40):
        at = bend(c, x, y)
        x, y = x + (xd - at[0]), y + (yd - at[1])
    return x, y


def locate(c, col, row):
    """Place (x, z) in the laser plane [mm] that is seen at a column and a row of the sensor [px]."""
    a, b, p = np.radians(c["tilt_deg"]), np.radians(c["sensor_tilt_deg"]), c["pixel_um"] * 1e-3
    s = (c["centre_row_px"] - row) * p
    v = c["image_distance_mm"] + s * np.sin(b)
    x, y = straighten(c, (col - c["centre_col_px"]) * p / v, s * np.cos(b) / v)
    z = y * c["distance_mm"] / (np.sin(a) + y * np.cos(a))
    return x * (c["distance_mm"] - z * np.cos(a)), z


def along(c, col, z):
    """Place x along the line [mm] of a height z [mm] that is seen in a column of the sensor [px]: for calibrated data."""
    a, b, p = np.radians(c["tilt_deg"]), np.radians(c["sensor_tilt_deg"]), c["pixel_um"] * 1e-3
    depth = c["distance_mm"] - z * np.cos(a)
    y = z * np.sin(a) / depth
    wanted = (col - c["centre_col_px"]) * p / c["image_distance_mm"]
    x = wanted * (1 - np.tan(b) * y)
    for _ in range(40):
        xd, yd = bend(c, x, y)
        x = x + wanted * (1 - np.tan(b) * yd) - xd
    return x * depth


def samples(root):
    """Index, calibration and Range (NaN where missing) of each sample, from the EXR files, else from the images."""
    head = open_dataset(root)
    unit = "px" if head["images"]["range"] == "uncalibrated" else "mm"
    for path in sorted((root / "data").rglob("*.parquet")):
        for row in pq.read_table(path).to_pylist():
            if "range" in head["images"]["exr"]:
                import OpenEXR

                shard = row["index"] // head["samples_per_shard"]
                thousand = f"{shard // 1000:03}" if shard >= 1000 else ""
                name = root / "exr" / thousand / f"{shard:05}" / f"{row['id']}.exr"
                with OpenEXR.File(str(name), separate_channels=True) as file:
                    said = json.loads(file.header()["sheetlight"])
                    assert said["units"]["Range"] == unit, said
                    map = file.channels()["Range"].pixels.astype(np.float64)
            else:
                png = np.asarray(Image.open(io.BytesIO(row["range"]["bytes"]))).astype(np.float64)
                map = row[f"range_offset_{unit}"] + png * row[f"range_scale_{unit}"]
                map[png == 0] = np.nan
            yield head, row["index"], row["calibration"], map


def main():
    if len(sys.argv) not in (2, 3):
        raise SystemExit(__doc__)
    others = {}
    if len(sys.argv) == 3:
        others = {index: (c, z) for _, index, c, z in samples(Path(sys.argv[2]))}
    worst = 0.0
    for head, index, c, rows in samples(Path(sys.argv[1])):
        if head["images"]["range"] != "uncalibrated":
            raise SystemExit(f"{sys.argv[1]}: its Range is {head['images']['range']}, in mm already")
        scale = head["images"]["sensor_cols"] / head["images"]["cols"]
        col = (np.arange(rows.shape[1]) + 0.5) * scale - 0.5
        x, z = locate(c, col, rows)
        print(f"sample {index}: x {np.nanmin(x):.3f} to {np.nanmax(x):.3f} mm, z {np.nanmin(z):.3f} to {np.nanmax(z):.3f} mm")
        if others:
            _, heights = others[index]
            if not np.array_equal(np.isnan(z), np.isnan(heights)):
                raise SystemExit(f"sample {index}: missing pixels differ")
            worst = max(worst, np.nanmax(np.abs(z - heights)), np.nanmax(np.abs(along(c, col, heights) - x)))
    if others:
        print(f"heights and places differ by at most {1000 * worst:.4f} um")
        if not worst < 1e-3:
            raise SystemExit("that is more than 1 um")


if __name__ == "__main__":
    main()
