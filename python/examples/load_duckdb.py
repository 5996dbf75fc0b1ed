"""DuckDB: the same questions in SQL, straight on the files.

    python python/examples/load_duckdb.py DIR

- Drawn numbers are structs: `laser.waist_mm`, quoted where a name is a word of SQL.
- `objects` is a list of structs: `unnest(objects)`.
- A pocket and the defect in it are two objects. Each has its own `class`; the pocket's `state` is the defect, so count
  states of whole objects alone: `within = 0`.
- Columns that a query does not name are not read: never say `SELECT *` of files with images.
"""

from sheetlight_schema import folder, needed

with needed():
    import duckdb


def main():
    root, head = folder(__doc__)
    db = duckdb.connect()

    # The one line: a view over all shards and splits.
    db.sql(f"CREATE VIEW samples AS FROM read_parquet('{root}/data/**/*.parquet')")

    # Names of pixel classes, by their value in labels and objects.
    db.execute("CREATE TABLE names AS SELECT unnest(range(len($1))) AS value, unnest($1) AS name", [head["pixel_classes"]])
    db.sql("CREATE VIEW things AS SELECT id, unnest(objects) AS object FROM samples")

    # Every object by its own class: the area of a pocket holds that of the defects in it.
    kinds = db.sql("""
        SELECT name, count(*), count(DISTINCT id), avg(object.area_mm2)
        FROM things JOIN names ON object.class = names.value
        GROUP BY name ORDER BY name
    """)
    for name, count, samples, area in kinds.fetchall():
        print(f"object {name}: {count} in {samples} samples, mean {area:.6f} mm2")

    # Whole objects by state: a pocket counts once, as its worst defect.
    wholes = db.sql("""
        SELECT name, count(*) FROM things JOIN names ON object.state = names.value
        WHERE object.within = 0 GROUP BY name ORDER BY name
    """)
    for name, count in wholes.fetchall():
        print(f"state {name}: {count}")

    # A drawn number by class of the recipe.
    means = db.sql("SELECT class, count(*), avg(laser.waist_mm) FROM samples GROUP BY class ORDER BY class")
    for label, count, mean in means.fetchall():
        print(f"class {head['classes'][label]}: {count} samples, mean laser.waist_mm {mean:.6f}")


if __name__ == "__main__":
    main()
