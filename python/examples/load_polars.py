"""polars: how many objects of each kind are there and how large, in what state are whole ones, and what was drawn?

    python python/examples/load_polars.py DIR

- `scan_parquet` reads the columns that the question names, and no others: PNG bytes stay on disk.
- Drawn numbers are structs: `pl.col("laser").struct.field("waist_mm")`.
- `objects` is a list of structs: explode, unnest.
- A pocket and the defect in it are two objects. Each has its own `class`; the pocket's `state` is the defect, so count
  states of whole objects alone: `within` = 0.
"""

from sheetlight_schema import folder, needed

with needed():
    import polars as pl


def main():
    root, head = folder(__doc__)

    # The one line; lazy, so that only what is asked for is read.
    rows = pl.scan_parquet(root / "data" / "**" / "*.parquet")

    names = dict(enumerate(head["pixel_classes"]))
    objects = (
        rows.select("id", "objects")
        .explode("objects")
        .drop_nulls("objects")  # samples without objects
        .unnest("objects")
        .with_columns(pl.col("class", "state").replace_strict(names, return_dtype=pl.String))
    )

    # Every object by its own class: the area of a pocket holds that of the defects in it.
    kinds = (
        objects.group_by("class")
        .agg(pl.len().alias("count"), pl.col("area_mm2").mean(), pl.col("id").n_unique().alias("samples"))
        .sort("class")
        .collect()
    )
    for kind in kinds.iter_rows(named=True):
        print(f"object {kind['class']}: {kind['count']} in {kind['samples']} samples, mean {kind['area_mm2']:.6f} mm2")

    # Whole objects by state: a pocket counts once, as its worst defect.
    wholes = objects.filter(pl.col("within") == 0).group_by("state").agg(pl.len().alias("count")).sort("state").collect()
    for whole in wholes.iter_rows(named=True):
        print(f"state {whole['state']}: {whole['count']}")

    # A drawn number by class of the recipe.
    waist = pl.col("laser").struct.field("waist_mm")
    means = rows.group_by("class").agg(pl.len().alias("count"), waist.mean().alias("waist")).sort("class").collect()
    for mean in means.iter_rows(named=True):
        print(f"class {head['classes'][mean['class']]}: {mean['count']} samples, mean laser.waist_mm {mean['waist']:.6f}")


if __name__ == "__main__":
    main()
