"""What reads a dataset in a bucket without copying it first, as docs/guide/scale.md shows it, compared with the files on disk."""

import io

import numpy as np
import pyarrow.parquet as parquet
import pytest
import sheetlight
import sheetlight.scale
from conftest import tiny

URL = "s3://planks/boards"
N = 12


@pytest.fixture
def boards(bucket, tmp_path, monkeypatch):
    """A dataset in a bucket and, under the same bytes, in a folder."""
    monkeypatch.setenv("HF_HOME", str(tmp_path / "huggingface"))
    sheetlight.scale.generate(**tiny(N, samples_per_shard=4), url=URL, engine="local")
    found = bucket.files("boards")
    folder = tmp_path / "boards"
    for path, content in found.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(content)
    return folder


def rows(folder, split="*"):
    """The rows of a split by the slow way."""
    tables = [parquet.read_table(io.BytesIO(path.read_bytes())) for path in folder.glob(f"data/{split}-*.parquet")]
    return sorted((row for table in tables for row in table.to_pylist()), key=lambda row: row["index"])


def test_open(boards):
    there, here = sheetlight.open(URL), sheetlight.open(boards)
    assert there.indices == here.indices == list(range(N))
    for a, b in zip(there, here, strict=True):
        assert (a.id, a.split) == (b.id, b.split)
        for name in ("range_mm", "reflectance", "scatter", "label", "instance"):
            np.testing.assert_array_equal(getattr(a, name), getattr(b, name))


def test_polars(boards, bucket):
    import polars

    # What follows is for a server on the loopback alone; AWS needs none of it.
    local = {"aws_allow_http": "true", "aws_endpoint_url": bucket.endpoint}
    found = polars.scan_parquet(f"{URL}/data/**/*.parquet", storage_options=local)
    ids = found.sort("index").select("id").collect()["id"].to_list()
    assert ids == [row["id"] for row in rows(boards)]


def test_duckdb(boards):
    import duckdb
    import fsspec

    base = duckdb.connect()
    base.register_filesystem(fsspec.filesystem("s3"))
    asked = f"SELECT class, count(*), sum(measured_share) FROM read_parquet('{URL}/data/**/*.parquet') GROUP BY 1"
    found = base.sql(asked).fetchall()
    wanted = {}
    for row in rows(boards):
        count, share = wanted.get(row["class"], (0, 0.0))
        wanted[row["class"]] = count + 1, share + row["measured_share"]
    assert {name: (count, pytest.approx(share)) for name, count, share in found} == wanted


def test_datasets(boards):
    import datasets

    files = {split: f"{URL}/data/**/{split}-*.parquet" for split in ("train", "test")}
    found = datasets.load_dataset("parquet", data_files=files, streaming=True)
    for split in files:
        wanted = rows(boards, split)
        got = sorted(found[split], key=lambda row: row["index"])
        assert [row["id"] for row in got] == [row["id"] for row in wanted] != []
        first = np.asarray(got[0]["reflectance"])
        number = got[0]["index"]
        np.testing.assert_array_equal(first, sheetlight.open(boards).sample(number).reflectance.astype(first.dtype))
