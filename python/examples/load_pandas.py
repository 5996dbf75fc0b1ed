"""pandas: what Scatter and Reflectance do the pixels of each class have?

    python python/examples/load_pandas.py DIR

- Name the columns: an image is a struct of PNG `bytes`, which is read only when asked for.
- One file at a time keeps memory flat; pandas would hold every image of the folder otherwise.
- Drawn numbers come as dicts; `pandas.json_normalize` makes columns of them.
"""

import io

from sheetlight_schema import folder, images, needed

with needed():
    import numpy as np
    import pandas as pd
    from PIL import Image


def decode(image):
    """Pixels of an image column."""
    return np.asarray(Image.open(io.BytesIO(image["bytes"])))


def main():
    root, head = folder(__doc__)
    files = sorted((root / "data").rglob("*.parquet"))

    # The one line, for numbers: no image is read.
    rows = pd.concat(pd.read_parquet(file, columns=["index", "split", "class", "physics"]) for file in files)
    rows["class"] = rows["class"].map(dict(enumerate(head["classes"])))
    physics = pd.json_normalize(rows["physics"].tolist())
    print(f"rows: {len(rows)}, with {physics.shape[1]} derived numbers each")
    print(pd.crosstab(rows["class"], rows["split"]).to_string())

    # Pixels: mean of each map over all pixels of a class that were measured.
    images(head, "label", "scatter", "reflectance")
    many = len(head["pixel_classes"])
    count, scatter, reflectance = np.zeros(many, np.int64), np.zeros(many), np.zeros(many)
    for file in files:
        for _, row in pd.read_parquet(file, columns=["label", "scatter", "reflectance"]).iterrows():
            label, bright = decode(row["label"]), decode(row["reflectance"])
            seen = bright > 0  # 0 is missing
            count += np.bincount(label[seen], minlength=many)
            scatter += np.bincount(label[seen], decode(row["scatter"])[seen], minlength=many)
            reflectance += np.bincount(label[seen], bright[seen], minlength=many)
    for value in np.flatnonzero(count):
        means = f"Scatter {scatter[value] / count[value]:.4f} DN, Reflectance {reflectance[value] / count[value]:.4f} DN"
        print(f"pixels {head['pixel_classes'][value]}: {count[value]}, mean {means}")


if __name__ == "__main__":
    main()
