"""Ray: a cluster of three nodes, processes of this machine. A worker, a node and the driver are killed; bytes stay the same."""

import contextlib
import json
import os
import signal
import subprocess
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest
import sheetlight
import sheetlight.scale
from conftest import FULL, KEYS, TINY, assert_same, command, files, log_gen, run, tiny, tiny_arguments, wait_until

SHARDS = 200 if FULL else 18
OVERHEAD = 0.02 * 30 / 0.12
"""What a task may take beside rendering, over the time of `gen` for a tiny shard: 2 % of a shard of 30 s on an idle core, where
that time is 0.12 s. Both grow alike where the machine is slow, or does other work."""


@pytest.fixture(scope="module")
def cluster(tmp_path_factory, request):
    """Three nodes of one core each, whose tasks write down what `gen` is asked for."""
    from ray.cluster_utils import Cluster

    with pytest.MonkeyPatch.context() as patch:
        folder = tmp_path_factory.mktemp("gen")
        parts = log_gen(folder, patch)
        if FULL:
            # Workers take credentials from the environment of their node.
            patch.setenv("AWS_ENDPOINT_URL", request.getfixturevalue("store").endpoint)
            for name, value in KEYS.items():
                patch.setenv(name, value)
        patch.setenv("RAY_AUTH_MODE", "disabled")
        patch.setenv("RAY_USAGE_STATS_ENABLED", "0")
        options = {"num_cpus": 1, "object_store_memory": 80 << 20}
        nodes = Cluster(initialize_head=True, head_node_args=options | {"include_dashboard": False})
        workers = [nodes.add_node(**options) for _ in range(2)]
        patch.setenv("RAY_ADDRESS", nodes.address)
        yield SimpleNamespace(nodes=nodes, workers=workers, parts=parts, hold=folder / "hold")
        nodes.shutdown()


@pytest.fixture(params=["folder", "bucket"] if FULL else ["folder"])
def place(request, tmp_path):
    """Where the dataset goes: its URL, its files, the numbers of its manifests."""
    if request.param == "bucket":
        bucket = request.getfixturevalue("bucket")
        url = f"s3://{bucket.NAME}/planks"
        return SimpleNamespace(url=url, files=lambda: bucket.files("planks"), manifests=lambda: bucket.manifests("planks"))
    folder = tmp_path / "planks"
    numbers = lambda: {int(path.stem) for path in folder.glob("shards/[0-9]*.json")}  # noqa: E731
    return SimpleNamespace(url=str(folder), files=lambda: files(folder), manifests=numbers)


class Watch(threading.Thread):
    """Looks all the time which manifests are there, and keeps when each was seen first [s since the epoch]."""

    def __init__(self, place):
        super().__init__(daemon=True)
        self.place, self.seen, self.ended = place, {}, threading.Event()

    def run(self):
        while not self.ended.wait(0.05):
            there = self.place.manifests()
            now = time.time()
            for shard in there:
                self.seen.setdefault(shard, now)


def test_worker_node_and_driver_are_killed(cluster, place, reference):
    earlier = len(cluster.parts())
    watch = Watch(place)
    watch.start()
    arguments = ["generate", place.url, "--engine", "ray", "--json", *tiny_arguments(SHARDS)]
    driver = subprocess.Popen(command(*arguments), stdout=subprocess.DEVNULL)

    def made(more: int):
        wanted = len(watch.seen) + more
        wait_until(lambda: len(watch.seen) >= wanted, 180)

    @contextlib.contextmanager
    def held():
        """Shards that have begun stay at that meanwhile: they could all be made before a node has gone and another has come."""
        cluster.hold.touch()
        try:
            wait_until(rendering)
            yield
        finally:
            cluster.hold.unlink()

    def rendering():
        """Workers whose `gen` runs, with the shard."""
        begun = {shard: worker for shard, what, worker, _ in events() if what == "begun"}
        done = {shard for shard, what, *_ in events() if what == "done"}
        return {worker: shard for shard, worker in begun.items() if shard not in done}

    def events():
        said = cluster.parts()[earlier:]
        return [(int(part.partition("/")[0]), what, int(worker), float(at)) for part, what, worker, at in said]

    made(SHARDS // 6)
    with held():
        (worker, lost), *_ = rendering().items()
        os.kill(worker, signal.SIGKILL)
    made(SHARDS // 6)
    with held():
        cluster.nodes.remove_node(cluster.workers.pop(), allow_graceful=False)
        cluster.workers.append(cluster.nodes.add_node(num_cpus=1, object_store_memory=80 << 20))
    made(SHARDS // 6)
    driver.kill()
    assert driver.wait() == -signal.SIGKILL
    there = place.manifests()
    assert SHARDS // 2 <= len(there) < SHARDS

    done = run(*arguments)
    watch.ended.set()
    watch.join()
    assert_same(place.files(), reference(SHARDS))
    told = json.loads(done.stdout)
    assert told["made_shards"] <= SHARDS - len(there)
    begun = [(shard, at) for shard, what, _, at in events() if what == "begun"]
    assert [shard for shard, at in begun if at > watch.seen.get(shard, at)] == [], "made again after it was finished"
    assert sum(shard == lost for shard, _ in begun) >= 2, "the killed worker's shard was made anew"

    other, rendered = (told[name] / told["made_shards"] for name in ("other_s", "render_s"))
    print(f"a task of {told['made_shards']} took {rendered:.3f} s in gen, {other:.3f} s beside it")
    assert other < OVERHEAD * rendered


def test_what_cannot_be_made_is_told(cluster, tmp_path, monkeypatch):
    """Faults of tasks come back as they are: those that trying again does not help stop all, others are tried again."""
    url = tmp_path / "planks"
    run("begin", url, *tiny_arguments(6))
    not_a_folder = tmp_path / "file"
    not_a_folder.write_text("")
    options = {"url": url, "engine": "ray", "retries": 1, "scratch": not_a_folder}
    monkeypatch.setattr(sheetlight.scale, "begin", lambda *_, **__: json.loads((url / "dataset.json").read_text()))
    with pytest.raises(sheetlight.scale.Unfinished, match="6 of 6 shards were given up; shard 0: .*cannot use it for scratch"):
        sheetlight.scale.generate(**tiny(6), **options)
    del options["scratch"]
    document = (url / "dataset.json").read_text()
    head = json.loads(document)
    head["generator"]["version"] = "0.0.1"
    (url / "dataset.json").write_text(json.dumps(head))
    with pytest.raises(sheetlight.scale.Refusal, match="gen 0.0.1 for .* began this dataset, and .* has gen"):
        sheetlight.scale.generate(**tiny(6), **options)
    with pytest.raises(sheetlight.scale.Refusal, match="engine_options: "):
        sheetlight.scale.generate(**tiny(6), **options, engine_options={"cores": 2})


@pytest.mark.skipif(not FULL, reason="SCALE_FULL=1 runs Ray Data")
def test_ray_data_streams_samples_that_nobody_writes(cluster):
    """As docs/guide/scale.md shows it: the arrays are those of the recipe."""
    import ray

    class Render:
        def __init__(self):
            self.recipe = sheetlight.Recipe.load("wood-small", **TINY)

        def __call__(self, row):
            sample = self.recipe.sample(row["id"], seed=1, threads=1)
            return {"index": row["id"], "scatter": sample.scatter, "label": sample.label}

    ray.init(log_to_driver=False)
    try:
        scans = ray.data.range(12).map(Render, compute=ray.data.ActorPoolStrategy(size=1))
        batches = list(scans.iter_batches(batch_size=5))
    finally:
        ray.shutdown()
    found = {int(index): scatter for batch in batches for index, scatter in zip(batch["index"], batch["scatter"], strict=True)}
    wanted = list(sheetlight.Recipe.load("wood-small", **TINY).samples(range(12), seed=1))
    assert sorted(found) == list(range(12))
    for sample in wanted:
        np.testing.assert_array_equal(found[sample.index], sample.scatter)
