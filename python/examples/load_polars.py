"""polars: how large are the objects of each kind, and what was drawn for the samples that have them?

    python python/examples/load_polars.py DIR

- `scan_parquet` reads the columns that the question names, and no others: PNG bytes stay on disk.
- Drawn numbers are structs: `pl.col("laser").struct.field("waist_mm")`.
- `objects` is a list of structs: explode, unnest.
"""

from sheetlight_schema import folder, needed

with needed():
    import polars as pl


def main():
    root, head = folder(__doc__)

    # The one line; lazy, so that only what is asked for is read.
    rows = pl.scan_parquet(root / "data" / "*.parquet")

    names = pl.Series(head["pixel_classes"])
    objects = (
        rows.select("id", "objects")
        .explode("objects")
        .drop_nulls("objects")  # samples without objects
        .unnest("objects")
        .with_columns(state=pl.col("state").replace_strict(dict(enumerate(names)), return_dtype=pl.String))
    )
    kinds = (
        objects.group_by("state")
        .agg(pl.len().alias("count"), pl.col("area_mm2").mean(), pl.col("id").n_unique().alias("samples"))
        .sort("state")
        .collect()
    )
    for kind in kinds.iter_rows(named=True):
        print(f"object {kind['state']}: {kind['count']} in {kind['samples']} samples, mean {kind['area_mm2']:.6f} mm2")

    # A drawn number by class of the recipe.
    waist = pl.col("laser").struct.field("waist_mm")
    means = rows.group_by("class").agg(pl.len().alias("count"), waist.mean().alias("waist")).sort("class").collect()
    for mean in means.iter_rows(named=True):
        print(f"class {head['classes'][mean['class']]}: {mean['count']} samples, mean laser.waist_mm {mean['waist']:.6f}")


if __name__ == "__main__":
    main()
