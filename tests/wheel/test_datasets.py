"""Datasets that were written: in folders, at URLs, unfinished, damaged."""

import io
import json
import pickle
import shutil

import fsspec
import numpy as np
import pyarrow.parquet as pq
import pytest
import sheetlight
from conftest import SMALL, write
from PIL import Image


def test_a_dataset_is_a_sequence_of_its_samples(boards):
    dataset = sheetlight.open(boards)
    assert len(dataset) == 20 and dataset.indices == list(range(20)) and dataset.seed == 7 and dataset.name == "wood-small"
    parts = [sheetlight.open(boards, split=split) for split in ("train", "validation", "test")]
    assert sorted(index for part in parts for index in part.indices) == list(range(20))
    for split, part in zip(("train", "validation", "test"), parts):
        assert [sample.split for sample in part] == [split] * len(part)
        assert [part[k].index for k in range(len(part))] == part.indices
    assert dataset[-1].index == 19 and pickle.loads(pickle.dumps(parts[0])).indices == parts[0].indices
    with pytest.raises(ValueError, match="split"):
        sheetlight.open(boards, split="dev")
    with pytest.raises(IndexError):
        dataset[20]
    with pytest.raises(IndexError):
        dataset.sample(-1)
    with pytest.raises(sheetlight.DatasetError, match="it has no sample 20, it has 20"):
        dataset.sample(20)


def test_images_become_mm_and_dn_where_there_is_no_exr_file(tmp_path):
    """By Pillow and NumPy, from what output_schema/README.md says."""
    out = tmp_path / "boards"
    write("blister-small", 3, out, {**SMALL, "output.exr": "[]", "output.truth_maps": "false"})
    dataset = sheetlight.open(out)
    row = [row for path in (out / "data").rglob("*.parquet") for row in pq.read_table(path).to_pylist() if row["index"] == 1][0]
    sample = dataset.sample(1)
    image = {name: np.array(Image.open(io.BytesIO(row[name]["bytes"]))) for name in ("range", "reflectance", "scatter", "label", "instance")}
    there = image["range"] > 0
    height = (row["range_offset_mm"] + row["range_scale_mm"] * image["range"].astype(np.float64)).astype(np.float32)
    assert np.array_equal(sample.range_mm, np.where(there, height, np.float32(np.nan)), equal_nan=True)
    assert np.array_equal(sample.valid, there) and 0 < there.mean() <= 1
    for name in ("reflectance", "scatter"):
        assert np.array_equal(getattr(sample, name), np.where(there, image[name], np.nan).astype(np.float32), equal_nan=True)
    assert np.array_equal(sample.label, image["label"]) and np.array_equal(sample.instance, image["instance"])
    assert not sample.truth and "height_mm" not in sample.maps
    names = dataset.pixel_classes
    assert [found["class"] for found in sample.objects] == [names[found["class"]] for found in row["objects"]]
    assert sample.to_arrow().to_pylist() == [row]


def test_channels_that_are_left_out_are_told(tmp_path):
    out = tmp_path / "boards"
    write("wood-train", 1, out, {**SMALL, "output.png": "[scatter, label]"})
    sample = sheetlight.open(out)[0]
    assert list(sample.maps) == ["scatter", "label"]
    with pytest.raises(AttributeError, match="no map 'reflectance'; it has scatter, label"):
        sample.reflectance
    # Without Range, 0 is what nothing measured has.
    assert np.array_equal(sample.valid, ~np.isnan(sample.scatter))


def test_unfinished_and_damaged_datasets_are_told(boards, tmp_path):
    part = tmp_path / "part"
    shutil.copytree(boards, part)
    (part / "shards" / "00001.json").unlink()
    dataset = sheetlight.open(part)
    assert dataset.indices == [*range(6), *range(12, 20)] and dataset[6].index == 12
    with pytest.raises(sheetlight.DatasetError, match="shard 1 with sample 7 is not finished; run gen again"):
        dataset.sample(7)
    [table] = [path for path in (part / "data").glob("*-00002.parquet") if dataset.sample(12).split in path.name]
    table.write_bytes(table.read_bytes()[:200])
    with pytest.raises(sheetlight.DatasetError, match="`gen validate` says what is damaged"):
        dataset.sample(12)
    (part / "shards" / "00002.json").write_text("{")
    with pytest.raises(sheetlight.DatasetError, match="00002.json"):
        sheetlight.open(part)
    head = json.loads((part / "dataset.json").read_text())
    (part / "dataset.json").write_text(json.dumps({**head, "schema_version": [9, 0]}))
    with pytest.raises(sheetlight.DatasetError, match="9.0"):
        sheetlight.open(part)
    with pytest.raises(sheetlight.DatasetError, match="dataset.json"):
        sheetlight.open(tmp_path)


@pytest.fixture
def bucket(boards):
    files = fsspec.filesystem("memory")
    files.put(str(boards), "/bucket/boards", recursive=True)
    yield files
    files.rm("/bucket", recursive=True)


def test_a_dataset_at_a_url_is_the_same(boards, bucket, tmp_path):
    near, far = sheetlight.open(boards), sheetlight.open("memory://bucket/boards", cache=tmp_path / "cache")
    assert far.indices == near.indices and "memory://bucket/boards" in repr(far)
    for index in (3, 17):
        a, b = near.sample(index), far.sample(index)
        assert list(a.maps) == list(b.maps) and all(np.array_equal(a.maps[name], b.maps[name], equal_nan=True) for name in a.maps)
        assert list(a.frames) == list(b.frames) and a.parameters == b.parameters and a.to_arrow().equals(b.to_arrow())
    # Tables are fetched by shards, EXR files by samples.
    kept = {path.relative_to(tmp_path / "cache").as_posix() for path in (tmp_path / "cache").rglob("*") if path.is_file()}
    assert len([name for name in kept if name.endswith(".exr")]) == 2 and {name for name in kept if "stacks" in name} == {
        "stacks/00000.parquet", "stacks/00002.parquet"
    }  # fmt: skip
    bucket.rm("/bucket/boards/data", recursive=True)
    assert far.sample(3).index == 3
    with pytest.raises(sheetlight.DatasetError, match="data/"):
        far.sample(9)


def test_what_is_fetched_without_a_cache_is_removed(bucket):
    import gc
    from pathlib import Path

    far = sheetlight.open("memory://bucket/boards")
    folder = Path(far._remote.folder)
    assert far.sample(0).index == 0 and folder.is_dir()
    del far
    gc.collect()
    assert not folder.exists()


def test_urls_that_cannot_be_used_are_told(bucket):
    with pytest.raises(sheetlight.DatasetError, match="memory://bucket/none: it holds no dataset.json"):
        sheetlight.open("memory://bucket/none")
    with pytest.raises(sheetlight.DatasetError, match="nosuch"):
        sheetlight.open("nosuch://bucket/boards")
    with pytest.raises(sheetlight.DatasetError) as caught:
        sheetlight.open("s3://key:secret@bucket/boards")
    assert "secret" not in str(caught.value)


def test_a_manifest_leads_nowhere_else(bucket, tmp_path):
    """Names of files follow from ids and numbers, which are checked, and nothing is fetched out of the folder."""
    manifest = json.loads(bucket.cat("/bucket/boards/shards/00000.json"))
    manifest["samples"][0]["id"] = "../../../../escaped"
    bucket.pipe("/bucket/boards/shards/00000.json", json.dumps(manifest).encode())
    far = sheetlight.open("memory://bucket/boards", cache=tmp_path / "a" / "b" / "cache")
    with pytest.raises(sheetlight.DatasetError):
        far.sample(0).maps["height_mm"]
    assert not list(tmp_path.rglob("*escaped*"))
