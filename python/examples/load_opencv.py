"""OpenCV: 16-bit PNG from the tables, boxes around defects in mm, and EXR files that hold Reflectance.

    python python/examples/load_opencv.py DIR

OpenCV reads EXR only where it was built with it and where OPENCV_IO_ENABLE_OPENEXR is set before it is imported (wheels of
4.x have it, wheels of 5.x do not). Of channels by other names than R, G, B, A it reads Y alone, which is Reflectance with 0
where it is missing. The other maps come as 16-bit PNG from the tables, which `cv2.imdecode` reads as they are.
"""

import os

os.environ["OPENCV_IO_ENABLE_OPENEXR"] = "1"

from sheetlight_schema import exr_path, folder, needed

with needed():
    import cv2
    import numpy as np
    import pyarrow.parquet as pq


def main():
    root, head = folder(__doc__)
    wanted = ["id", "index", "row_mm", "col_mm"] + [name for name in head["images"]["png"] if name in ("range", "label")]
    file = sorted((root / "data").rglob("*.parquet"))[0]
    row = pq.read_table(file, columns=wanted).slice(0, 1).to_pylist()[0]

    if "reflectance" in head["images"]["exr"]:
        # The one line.
        bright = cv2.imread(str(exr_path(root, head, row)), cv2.IMREAD_UNCHANGED)
        if bright is None:
            raise SystemExit("OpenCV cannot read EXR: install opencv-python 4.x, or use load_openexr.py")
        missing = bright == 0
        print(f"Reflectance: {bright.dtype} {bright.shape}, sum {bright.sum(dtype=np.float64):.3f} DN, missing {missing.sum()} px")

    if "range" in row:
        pixels = cv2.imdecode(np.frombuffer(row["range"]["bytes"], np.uint8), cv2.IMREAD_UNCHANGED)
        print(f"Range: {pixels.dtype} {pixels.shape}, missing {(pixels == 0).sum()} px")
    if "label" in row:
        label = cv2.imdecode(np.frombuffer(row["label"]["bytes"], np.uint8), cv2.IMREAD_UNCHANGED)
        for value in np.unique(label):
            if value == 0:
                continue
            outlines, _ = cv2.findContours((label == value).astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
            x, y, width, height = cv2.boundingRect(max(outlines, key=cv2.contourArea))
            size = f"{width * row['col_mm']:.3f} x {height * row['row_mm']:.3f} mm"
            print(f"label {head['pixel_classes'][value]}: {len(outlines)} regions, the largest {size}, from column {x}, row {y}")


if __name__ == "__main__":
    main()
