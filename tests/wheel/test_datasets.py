"""Datasets that were written: in folders, at URLs, unfinished, damaged."""

import asyncio
import errno
import hashlib
import http.server
import io
import json
import multiprocessing
import pickle
import random
import shutil
import threading
import time
import urllib.error
import urllib.request
from pathlib import Path

import fsspec
import fsspec.asyn
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


def test_a_relative_folder_stays_the_same_one(boards, tmp_path, monkeypatch):
    monkeypatch.chdir(boards.parent)
    dataset = sheetlight.open(boards.name)
    packed = pickle.dumps(dataset)
    monkeypatch.chdir(tmp_path)
    assert dataset.sample(1).index == 1 and pickle.loads(packed).sample(19).id == dataset.sample(19).id


def test_places_and_numbers_that_cannot_be_used_are_told(boards):
    dataset = sheetlight.open(boards)
    for wrong in ("a", 1.5, True, None):
        with pytest.raises(TypeError, match="index: .* is no whole number"):
            dataset.sample(wrong)
        with pytest.raises(TypeError, match="place: .* is no whole number"):
            dataset[wrong]
    assert dataset[np.int64(3)].index == 3
    for wrong, words in [("", "place: the path is empty"), (Path("s3://bucket/boards"), "give it as a text")]:
        with pytest.raises(ValueError, match=words):
            sheetlight.open(wrong)
    with pytest.raises(TypeError, match="place: give a path, not int"):
        sheetlight.open(3)


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
    height = (np.floor(height.astype(np.float64) * 8192 + 0.5) / 8192).astype(np.float32)
    assert np.array_equal(sample.range_mm, np.where(there, height, np.float32(np.nan)), equal_nan=True)
    assert np.array_equal(sample.valid, there) and 0 < there.mean() <= 1
    for name in ("reflectance", "scatter"):
        assert np.array_equal(getattr(sample, name), np.where(there, image[name], np.nan).astype(np.float32), equal_nan=True)
    assert np.array_equal(sample.label, image["label"]) and np.array_equal(sample.instance, image["instance"])
    assert not sample.truth and "height_mm" not in sample.maps
    names = dataset.pixel_classes
    assert [found["class"] for found in sample.objects] == [names[found["class"]] for found in row["objects"]]
    assert sample.to_arrow().to_pylist() == [row]


def drawn_outputs():
    """What tables and EXR files hold, drawn; the last ones are those of which zeros alone would be wrong."""
    rng = random.Random(5)
    measured = ("range", "reflectance", "scatter")
    for _ in range(8):
        png, exr = ([name for name in measured if rng.random() < 0.5] for _ in range(2))
        if png or exr:
            yield png, exr, rng.choice(["kept", "subtracted"]), rng.choice([8, 12])
    yield ["scatter"], ["range"], "subtracted", 8
    yield ["scatter"], ["reflectance"], "subtracted", 12
    yield ["reflectance", "scatter"], [], "subtracted", 8


@pytest.mark.parametrize("png, exr, dark, bits", list(drawn_outputs()))
def test_what_is_missing_does_not_depend_on_what_is_kept(png, exr, dark, bits, tmp_path):
    # So high a threshold that much is missing; where Scatter is dim it is 0 or less than that without its dark level.
    changes = {**SMALL, "extraction.scatter_dark": dark, "exposure.bits": bits, "extraction.threshold_dn": 30}
    kept = {"output.png": json.dumps([*png, "label"]), "output.exr": json.dumps(exr), "output.truth_maps": "false"}
    write("blister-small", 2, tmp_path / "out", {**changes, **kept})
    dataset, recipe = sheetlight.open(tmp_path / "out"), sheetlight.Recipe.load("blister-small", changes)
    for index in range(2):
        read, rendered = dataset.sample(index), recipe.sample(index)
        assert 0 < rendered.valid.mean() < 1
        if (dark, index) == ("subtracted", 0):
            assert (rendered.scatter[rendered.valid] < 0.5).mean() > 0.01
        held = [name for name in ("range", "reflectance", "scatter") if name in {*png, *exr}]
        assert list(read.maps) == ["range_mm" if name == "range" else name for name in held] + ["label"]
        for name in held:
            key = "range_mm" if name == "range" else name
            values, truth = read.maps[key], rendered.maps[key]
            there = rendered.valid
            if {*png, *exr} == {"scatter"} and not exr:
                # Nothing else tells of what is missing.
                there = there & (np.floor(np.nan_to_num(truth) + 0.5) > 0)
            assert np.array_equal(~np.isnan(values), there), (name, int((np.isnan(values) == there).sum()))
            values, truth = values[there].astype(np.float64), truth[there].astype(np.float64)
            if name == "range":
                scale = 2**-13 if "range" in exr else dataset.sample(index).to_arrow()["range_scale_mm"][0].as_py()
                assert np.abs(values - truth).max() <= scale * 0.5001 + 2**-14
            elif name in exr:
                assert np.allclose(values, truth, rtol=2**-11, atol=0)
            else:
                assert np.array_equal(values, np.maximum(np.floor(truth + 0.5), 0))
        if held:
            assert np.array_equal(read.valid, ~np.isnan(read.maps["range_mm" if held[0] == "range" else held[0]]))


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
    [own] = (tmp_path / "cache").iterdir()
    kept = {path.relative_to(own).as_posix() for path in own.rglob("*") if path.is_file()}
    assert len([name for name in kept if name.endswith(".exr")]) == 2 and {name for name in kept if "stacks" in name} == {
        "stacks/00000.parquet", "stacks/00002.parquet"
    }  # fmt: skip
    bucket.rm("/bucket/boards/data", recursive=True)
    assert far.sample(3).index == 3
    with pytest.raises(sheetlight.DatasetError, match="data/"):
        far.sample(9)


def test_what_is_fetched_without_a_cache_is_removed(bucket):
    import gc

    far = sheetlight.open("memory://bucket/boards")
    folder = Path(far._remote.folder)
    assert far.sample(0).index == 0 and folder.is_dir()
    del far
    gc.collect()
    assert not folder.exists()


def put(folder, place):
    """Makes what is at the place in memory the same as the folder."""
    files = fsspec.filesystem("memory")
    if files.exists(place):
        files.rm(place, recursive=True)
    files.put(str(folder), place, recursive=True)


def assert_same(near, far):
    assert far.indices == near.indices and far.head == near.head
    for index in near.indices:
        a, b = near.sample(index), far.sample(index)
        assert a.id == b.id and a.to_arrow().equals(b.to_arrow()), index
        assert all(np.array_equal(a.maps[name], b.maps[name], equal_nan=True) for name in a.maps), index


LEAN = {**SMALL, "output.exr": "[range]", "output.truth_maps": "false"}


def test_a_cache_keeps_datasets_apart(tmp_path):
    """Of one recipe, files have the same names whatever the seed, and after a dataset was made anew at its place."""
    cache = tmp_path / "cache"
    near = []
    for seed in (1, 2, 3):
        write("blister-small", 4, tmp_path / str(seed), LEAN, "--seed", seed, "--samples-per-shard", 2)
        near.append(sheetlight.open(tmp_path / str(seed)))
    put(tmp_path / "1", "/apart/a")
    put(tmp_path / "2", "/apart/b")
    for _ in range(2):
        # Both are read in turn.
        far = [sheetlight.open(f"memory://apart/{place}", cache=cache) for place in "ab"]
        for index in range(4):
            for a, b in zip(near, far):
                assert a.sample(index).to_arrow().equals(b.sample(index).to_arrow())
        for a, b in zip(near, far):
            assert_same(a, b)
    # Neither fetches again what was fetched.
    for place, dataset in zip("ab", near):
        for folder in ("data", "exr"):
            fsspec.filesystem("memory").rm(f"/apart/{place}/{folder}", recursive=True)
        assert_same(dataset, sheetlight.open(f"memory://apart/{place}", cache=cache))
    put(tmp_path / "3", "/apart/a")
    assert_same(near[2], sheetlight.open("memory://apart/a", cache=cache))


def test_a_cache_follows_what_changes_at_the_url(tmp_path):
    out, cache, url = tmp_path / "boards", tmp_path / "cache", "memory://grown/boards"
    write("blister-small", 7, out, LEAN, "--samples-per-shard", 4)
    put(out, "/grown/boards")
    before = sheetlight.open(url, cache=cache)
    assert_same(sheetlight.open(out), before)
    # The second shard had three samples, and then has four.
    write("blister-small", 10, out, LEAN)
    put(out, "/grown/boards")
    near = sheetlight.open(out)
    assert len(near) == 10
    assert_same(near, sheetlight.open(url, cache=cache))
    # What was cut off here, by a full disk, is fetched again.
    [own] = cache.iterdir()
    for table in own.rglob("*-00000.parquet"):
        table.write_bytes(table.read_bytes()[:-9])
    assert_same(near, sheetlight.open(url, cache=cache))
    # A shard that is gone there, or has become another one of the same size, is so here.
    [table, *_] = sorted(out.glob("data/*-00001.parquet"))
    name, content = table.relative_to(out).as_posix(), bytearray(table.read_bytes())
    content[-1] ^= 1
    manifest = json.loads((out / "shards" / "00001.json").read_text())
    for file in manifest["files"]:
        if file["path"] == name:
            file["sha256"] = hashlib.sha256(content).hexdigest()
    table.write_bytes(content)
    (out / "shards" / "00001.json").write_text(json.dumps(manifest))
    (out / "shards" / "00002.json").unlink()
    put(out, "/grown/boards")
    far = sheetlight.open(url, cache=cache)
    assert far.indices == list(range(8)) and not (own / "shards" / "00002.json").exists()
    damaged = 0
    for index in range(4, 8):
        try:
            far.sample(index)
        except sheetlight.DatasetError:
            damaged += 1
    assert damaged and (own / name).read_bytes() == content
    # Files that no manifest there speaks of are no files of the dataset.
    bucket = fsspec.filesystem("memory")
    bucket.pipe("/grown/boards/" + next(out.glob("data/*-00000.parquet")).relative_to(out).as_posix(), b"short")
    shutil.rmtree(cache)
    with pytest.raises(sheetlight.DatasetError, match="it has 5 bytes, and the manifest of its shard says"):
        list(sheetlight.open(url, cache=cache))


@pytest.fixture
def served(boards):
    """The dataset at an HTTP server that lists nothing, through a file system that is asynchronous as those of stores are."""
    seen = {"now": 0, "most": 0, "hold": None, "held": threading.Event()}
    count = threading.Lock()

    class Handler(http.server.SimpleHTTPRequestHandler):
        def __init__(self, *arguments):
            super().__init__(*arguments, directory=str(boards.parent))

        def do_GET(self):
            with count:
                seen["now"] += 1
                seen["most"] = max(seen["most"], seen["now"])
            time.sleep(0.05)
            if seen["hold"] is not None and self.path.endswith(".parquet"):
                hold, seen["hold"] = seen["hold"], None
                seen["held"].set()
                hold.wait(60)
            with count:
                seen["now"] -= 1
            super().do_GET()

        def list_directory(self, path):
            self.send_error(404)

        def log_message(self, *_):
            pass

    class Loopback(fsspec.asyn.AsyncFileSystem):
        protocol = "loopback"

        async def _cat_file(self, path, **_):
            def read():
                try:
                    with urllib.request.urlopen(f"http://{path}", timeout=60) as reply:
                        return reply.read()
                except urllib.error.HTTPError as error:
                    raise FileNotFoundError(path) if error.code == 404 else OSError(error.code) from None

            return await asyncio.to_thread(read)

        async def _get_file(self, path, here, **_):
            Path(here).write_bytes(await self._cat_file(path))

    fsspec.register_implementation("loopback", Loopback, clobber=True)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"loopback://127.0.0.1:{server.server_port}", seen
        server.shutdown()


def test_a_server_that_lists_nothing_is_read(boards, served):
    root, seen = served
    far = sheetlight.open(f"{root}/{boards.name}")
    assert far.indices == list(range(20)) and far.sample(13).to_arrow().equals(sheetlight.open(boards).sample(13).to_arrow())
    # All four manifests at once, or nearly.
    assert seen["most"] >= 2


def test_a_url_without_any_shard_is_told(bucket):
    bucket.rm("/bucket/boards/shards/00002.json")
    assert len(sheetlight.open("memory://bucket/boards")) == 14
    bucket.rm("/bucket/boards/shards", recursive=True)
    with pytest.raises(sheetlight.DatasetError, match="none of its 4 shards has a manifest there, such as shards/00000.json"):
        sheetlight.open("memory://bucket/boards")
    bucket.pipe("/bucket/boards/dataset.json", b"{}")
    with pytest.raises(sheetlight.DatasetError, match="^(cannot use )?memory://bucket/boards"):
        sheetlight.open("memory://bucket/boards")


def _read(dataset, index, results):
    try:
        results.put(dataset.sample(index).scatter)
    except BaseException as fault:
        results.put(repr(fault))
        raise


def test_forked_workers_read_from_an_asynchronous_store(boards, served):
    """Also while another thread of the parent waits for a file, with the lock of the dataset."""
    root, seen = served
    far, near = sheetlight.open(f"{root}/{boards.name}"), sheetlight.open(boards)
    assert far.sample(0).index == 0
    seen["hold"] = release = threading.Event()
    thread = threading.Thread(target=far.sample, args=(19,))
    thread.start()
    assert seen["held"].wait(60)
    fork = multiprocessing.get_context("fork")
    results = fork.Queue()
    try:
        for index in (7, 13):
            child = fork.Process(target=_read, args=(far, index, results), daemon=True)
            child.start()
            found = results.get(timeout=60)
            assert np.array_equal(found, near.sample(index).scatter, equal_nan=True), found
            child.join(20)
            assert child.exitcode == 0
    finally:
        release.set()
        thread.join(60)
    assert far.sample(19).index == 19


def test_urls_that_cannot_be_used_are_told(bucket):
    with pytest.raises(sheetlight.DatasetError, match="memory://bucket/none: it holds no dataset.json"):
        sheetlight.open("memory://bucket/none")
    with pytest.raises(sheetlight.DatasetError, match="nosuch"):
        sheetlight.open("nosuch://bucket/boards")
    with pytest.raises(sheetlight.DatasetError) as caught:
        sheetlight.open("s3://key:secret@bucket/boards")
    assert "secret" not in str(caught.value)


def test_faults_of_files_name_the_url(bucket, tmp_path):
    for cache in (None, tmp_path / "cache"):
        far = sheetlight.open("memory://bucket/boards", cache=cache)
        sample = far.sample(3)
        folder = far._remote.folder
        for path in [*folder.rglob("*.exr"), *folder.rglob("stacks/*")]:
            path.write_bytes(bytes(path.stat().st_size))
        for read in (lambda: sample.truth["height_mm"], lambda: sample.frames):
            with pytest.raises(sheetlight.DatasetError, match="memory://bucket/boards/") as caught:
                read()
            assert (str(folder) in str(caught.value)) == (cache is not None)
        with pytest.raises(sheetlight.DatasetError, match="memory://bucket/boards.* has no sample 20"):
            far.sample(20)
    bucket.pipe("/bucket/boards/shards/00001.json", b"{")
    with pytest.raises(sheetlight.DatasetError, match="memory://bucket/boards/shards/00001.json") as caught:
        sheetlight.open("memory://bucket/boards")
    assert "sheetlight-" not in str(caught.value)


def test_a_cache_that_cannot_be_written_is_told(bucket, tmp_path, monkeypatch):
    (tmp_path / "file").write_text("no folder")
    with pytest.raises(sheetlight.DatasetError, match=f"^cache: cannot write in {tmp_path}/file .*name another folder"):
        sheetlight.open("memory://bucket/boards", cache=tmp_path / "file")
    with pytest.raises(ValueError, match="cache: .* is a URL"):
        sheetlight.open("memory://bucket/boards", cache="s3://bucket/cache")
    far = sheetlight.open("memory://bucket/boards", cache=tmp_path / "cache")
    full = OSError(errno.ENOSPC, "No space left on device")

    def get_file(*_, **__):
        raise full

    monkeypatch.setattr(type(bucket), "get_file", get_file)
    with pytest.raises(sheetlight.DatasetError, match=f"^cache: cannot write in {tmp_path}/cache .No space left on device.; free space"):
        far.sample(0)


def test_a_manifest_leads_nowhere_else(bucket, tmp_path):
    """Names of files follow from ids and numbers, which are checked, and nothing is fetched out of the folder."""
    manifest = json.loads(bucket.cat("/bucket/boards/shards/00000.json"))
    manifest["samples"][0]["id"] = "../../../../escaped"
    bucket.pipe("/bucket/boards/shards/00000.json", json.dumps(manifest).encode())
    far = sheetlight.open("memory://bucket/boards", cache=tmp_path / "a" / "b" / "cache")
    with pytest.raises(sheetlight.DatasetError):
        far.sample(0).maps["height_mm"]
    assert not list(tmp_path.rglob("*escaped*"))
