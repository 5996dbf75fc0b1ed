"""Datasets in a folder, by processes of one machine: what does not depend on the store, and faults before any work."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time

import pytest
import sheetlight
import sheetlight.scale
from conftest import TINY, assert_same, command, files, run, tiny, tiny_arguments, wait_until
from sheetlight import _gen
from sheetlight.scale.dataset import manifest_path
from sheetlight.scale.scratch import scratch_folder
from sheetlight.scale.store import Store


def test_command_line_of_a_cluster(tmp_path, reference):
    """begin, parts in any order, status in between, finish; what comes too early says what is missing."""
    url = tmp_path / "planks"
    assert "there is no dataset.json" in run("task", url, status=2).stderr
    begun = json.loads(run("begin", url, "--json", *tiny_arguments(7, 2)).stdout)
    assert begun == {"samples": 7, "samples_per_shard": 2, "shards": 4, "seed": 0}
    made = json.loads(run("task", url, "--part", "1/3", "--json").stdout)
    assert [(report["shard"], report["made"], report["samples"]) for report in made] == [(1, True, 2)]
    found = json.loads(run("status", url, "--json", status=1).stdout)
    assert (found["missing"], found["described"], found["recipe"]) == ([0, 2, 3], True, "wood-small")
    assert "3 shards have no manifest" in run("finish", url, status=1).stderr
    run("task", url, "--part", "2/3")
    run("task", url, "--part", "0/3", "--threads", "2")
    assert run("task", url).stdout.endswith("0 shards made of part 0/1\n")
    run("finish", url)
    run("finish", url)
    run("status", url)
    assert_same(files(url), reference(7, 2))


def test_gen_goes_on_with_it_and_the_other_way_round(tmp_path, reference):
    url = tmp_path / "planks"
    run("begin", url, *tiny_arguments(4))
    run("task", url, "--part", "0/2")
    _gen.run([*tiny_arguments(6), "--out", str(url)])
    assert_same(files(url), reference(6))
    run("generate", url, "--engine", "local", *tiny_arguments(8))
    assert_same(files(url), reference(8))


def test_unusable_requests_start_nothing(tmp_path):
    faults = [
        (["--recipe", "wood-smal", "--n", "2"], ["wood-smal"]),
        ([*tiny_arguments(2), "--set", "camera.tilt_deg=300"], ["camera.tilt_deg", "300"]),
        ([*tiny_arguments(2), "--set", "camera.tilt=30"], ["camera.tilt"]),
        ([*tiny_arguments(0)], ["--n 0"]),
        ([*tiny_arguments(2), "--samples-per-shard", "0"], ["--samples-per-shard 0"]),
        (["--recipe", "wood-small", "--n", "two"], ["two"]),
    ]
    for asked, words in faults:
        said = run("generate", tmp_path / "planks", "--engine", "local", *asked, status=2).stderr
        assert all(word in said for word in words), said
        assert not (tmp_path / "planks").exists()
    for part in ("3/3", "1", "-1/2"):
        assert part in run("task", tmp_path / "planks", f"--part={part}", status=2).stderr


def test_another_dataset_is_refused_with_each_difference(tmp_path):
    url = tmp_path / "planks"
    run("begin", url, *tiny_arguments(4, 2))
    before = files(url)
    asked = [*tiny_arguments(4, 3), "--seed", "5", "--set", "camera.tilt_deg=31"]
    said = run("generate", url, "--engine", "local", *asked, status=2).stderr
    assert all(word in said for word in (str(url), "recipe.camera.tilt_deg", "seed: 0 -> 5", "samples_per_shard: 2 -> 3")), said
    assert "/dataset/" not in said and "task-" not in said, "the scratch folder is nobody's business"
    assert files(url) == before


def test_another_version_is_refused(tmp_path, monkeypatch):
    """By whoever begins, and by each task."""
    url = tmp_path / "planks"
    run("begin", url, *tiny_arguments(2))
    document = (url / "dataset.json").read_text()
    (url / "dataset.json").write_text(document.replace(f'"version": "{_version()}"', '"version": "0.0.1"'))
    said = run("generate", url, "--engine", "local", *tiny_arguments(2), status=2).stderr
    assert f'{url}: generator.version: "0.0.1" -> "{_version()}"' in said
    for asked in ("task", "finish"):
        assert "gen 0.0.1 began this dataset, and " in run(asked, url, status=2).stderr


def _version() -> str:
    return _gen.run(["--version"]).split()[-1]


def test_engines_that_are_not_there(tmp_path):
    with pytest.raises(sheetlight.scale.Refusal, match="engine 'spark': there is none; give one of ray, local"):
        sheetlight.scale.generate(**tiny(2), url=tmp_path / "planks", engine="spark")
    # Where Ray, or what a store needs, is not installed.
    script = (
        "import sys; sys.modules.update(ray=None, s3fs=None, fsspec=None)\n"
        "from sheetlight.scale.__main__ import main\n"
        f"assert main(['generate', {str(tmp_path / 'planks')!r}, '--recipe', 'wood-small', '--n', '2']) == 2\n"
        "assert main(['status', 's3://planks/planks']) == 2\n"
    )
    said = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stderr
    assert "pip install 'sheetlight[ray]'" in said and "pip install 'sheetlight[s3]'" in said
    assert not (tmp_path / "planks").exists()
    with pytest.raises(sheetlight.scale.Refusal, match='"workers" and not \'cores\''):
        sheetlight.scale.generate(**tiny(2), url=tmp_path / "planks", engine="local", engine_options={"cores": 2})


def test_nothing_heavy_is_imported_until_it_is_used():
    script = (
        "import sys, sheetlight.scale, sheetlight.scale.__main__\n"
        "heavy = {'ray', 'fsspec', 's3fs', 'boto3', 'botocore', 'aiohttp', 'pyarrow', 'torch'}\n"
        "print(sorted(heavy & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout == "[]\n"


def test_urls(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert Store("planks").url == Store(f"file://{tmp_path}/planks").url == str(tmp_path / "planks")
    refused = {
        "s3://key:hidden@bucket/planks": "credentials",
        "az://bucket/planks?sig=hidden": "credentials",
        "ftp://host/planks": "cannot write to ftp://",
        "s3://": "names no bucket",
        "gs://bucket/planks": "pip install 'sheetlight\\[gs\\]'",
        "hf://datasets/me/planks": "hf upload-large-folder",
    }
    for url, words in refused.items():
        with pytest.raises(sheetlight.scale.Refusal, match=words) as fault:
            Store(url)
        assert "hidden" not in str(fault.value)


def test_impossible_places_are_told_at_once(tmp_path):
    """No attempts that cannot succeed, and remedies that fit the place."""
    (tmp_path / "file").write_text("")
    places = {
        "s3://no bucket!/planks": ["Invalid bucket name", "correct the URL"],
        str(tmp_path / "file"): ["Not a directory", "correct the URL"],
        "/proc/planks": ["there is no such folder and it cannot be made"],
    }
    for place, words in places.items():
        begun = time.monotonic()
        said = run("begin", place, *tiny_arguments(2), status=2).stderr
        assert place in said and all(word in said for word in words), said
        assert "attempts" not in said and time.monotonic() - begun < 5


def test_paths_of_manifests_are_those_of_gen(tmp_path):
    """Of shards below and above a thousand: `gen` makes the part, and the manifest lies where it is looked for."""
    asked = ["--recipe", "wood-small", "--n", "2003", "--samples-per-shard", "1", *_gen.set_arguments(TINY)]
    for shard in (0, 999, 1000, 2002):
        _gen.run([*asked, "--part", f"{shard}/2003", "--out", str(tmp_path / "planks")])
        assert (tmp_path / "planks" / manifest_path(shard)).is_file()
    missing = sheetlight.scale.status(tmp_path / "planks")["missing"]
    assert len(missing) == 1999 and not {0, 999, 1000, 2002} & set(missing)
    (report,) = sheetlight.scale.make(tmp_path / "planks", (1001, 2003))
    assert (report["shard"], report["made"]) == (1001, True)
    assert len(sheetlight.scale.status(tmp_path / "planks")["missing"]) == 1998


def test_a_stopped_task_leaves_nothing_behind(tmp_path):
    """SIGTERM, as Slurm and Kubernetes send it, in the middle of a shard; scratch is removed, then made again and finished."""
    url, scratch = tmp_path / "planks", tmp_path / "scratch"
    run("begin", url, "--recipe", "wood-small", "--n", "200", "--samples-per-shard", "200")
    task = subprocess.Popen(command("task", url, "--scratch", scratch), stderr=subprocess.PIPE, text=True)
    wait_until(lambda: any(scratch.rglob(".tmp-*.parquet")))
    task.send_signal(signal.SIGTERM)
    assert task.wait(20) == 143, task.stderr.read()
    assert [path for path in scratch.rglob("*") if path.is_file()] == []
    assert not (url / "shards").exists()


def test_scratch_of_killed_tasks_is_removed_by_the_next_one(tmp_path):
    with scratch_folder(tmp_path) as running:
        task = subprocess.Popen(
            [sys.executable, "-c", "import sys, time, sheetlight.scale.scratch as s\n"
             "with s.scratch_folder(sys.argv[1]) as folder: (folder / 'half').write_text('x'); time.sleep(100)", tmp_path],
        )  # fmt: skip
        wait_until(lambda: any(tmp_path.rglob("half")))
        with scratch_folder(tmp_path):
            assert any(tmp_path.rglob("half")), "it runs"
        task.kill()
        task.wait()
        with scratch_folder(tmp_path):
            assert not any(tmp_path.rglob("half"))
            assert running.is_dir()
    assert not any(tmp_path.rglob("task-*"))


@pytest.fixture
def small_disk(tmp_path):
    """A disk of 1 MB in memory; only root can mount one."""
    disk = tmp_path / "disk"
    disk.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", disk], capture_output=True).returncode:
        pytest.skip("only root can mount a small disk")
    yield disk
    subprocess.run(["umount", "-l", disk], check=True)


def test_a_full_scratch_disk(tmp_path, small_disk, reference):
    """Too small for a shard, which is refused before it is rendered, then full. Nothing is lost, and it goes on elsewhere."""
    url = tmp_path / "planks"
    begin = ["generate", url, "--engine", "local", "--retries", "0"]
    said = run(*begin, *tiny_arguments(40, 20), "--scratch", small_disk, status=1).stderr
    assert "2 of 2 shards were given up" in said and "free" in said and "the same call goes on" in said
    assert not (url / "shards").exists()
    filler = small_disk / "filler"
    filler.write_bytes(b"7" * (shutil.disk_usage(small_disk).free - 4096))
    said = run(*begin, *tiny_arguments(40, 20), "--scratch", small_disk, status=1).stderr
    assert str(small_disk) in said and "No space left on device; make room there, or name another folder" in said
    run(*begin, *tiny_arguments(40, 20))
    assert_same(files(url), reference(40, 20))


def test_a_full_or_read_only_place(tmp_path, small_disk):
    (small_disk / "filler").write_bytes(b"7" * (shutil.disk_usage(small_disk).free - 16384))
    said = run("generate", small_disk / "planks", "--engine", "local", *tiny_arguments(3), status=2).stderr
    assert "cannot write it: No space left on device; make room there" in said
    left = [path for path in small_disk.rglob(".tmp-*")]
    assert left == []
    subprocess.run(["mount", "-o", "remount,ro", small_disk], check=True)
    said = run("begin", small_disk / "planks", *tiny_arguments(3), status=2).stderr
    assert "Read-only file system; it can only be read: choose another place" in said


def test_a_killed_upload_leaves_no_half_file_and_finishing_sweeps(tmp_path, reference):
    url = tmp_path / "planks"
    run("begin", url, *tiny_arguments(2))
    partial = url / "data" / (".tmp-train-00000.parquet." + "0" * 32)
    partial.parent.mkdir()
    partial.write_bytes(b"half")
    foreign = url / "data" / ".tmp-notes"
    foreign.write_bytes(b"mine")
    run("generate", url, "--engine", "local", *tiny_arguments(2))
    assert not partial.exists() and foreign.exists()
    foreign.unlink()
    assert_same(files(url), reference(2))


def test_ctrl_c_stops_all_and_leaves_no_scratch(tmp_path):
    """As a terminal sends it: to the program and to every `gen` that it started."""
    url, scratch = tmp_path / "planks", tmp_path / "scratch"
    asked = ["--recipe", "wood-small", "--n", "400", "--samples-per-shard", "100", "--scratch", scratch]
    driver = subprocess.Popen(
        command("generate", url, "--engine", "local", *asked), stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    wait_until(lambda: len(list(scratch.rglob(".tmp-train-*.parquet"))) > 0)
    os.killpg(driver.pid, signal.SIGINT)
    said = driver.communicate(timeout=20)[1]
    assert driver.returncode == 130 and "stopped; finished shards are kept" in said, said
    assert [path for path in scratch.rglob("*") if path.is_file()] == []
    assert not (url / "shards").exists()


def test_a_smaller_number_that_somebody_writes_meanwhile(tmp_path, reference):
    """Two that extend a dataset at once may end with the smaller number in `dataset.json`; the larger one wins."""
    url = tmp_path / "planks"
    sheetlight.scale.generate(**tiny(3, samples_per_shard=2), url=url, engine="local")
    smaller = (url / "dataset.json").read_bytes()
    written = []

    def meddle(progress):
        if progress.made == 1 and not written:
            written.append((url / "dataset.json").write_bytes(smaller))

    done = sheetlight.scale.generate(**tiny(6, samples_per_shard=2), url=url, engine="local", progress=meddle)
    assert written and done["samples"] == 6
    assert_same(files(url), reference(6, 2))


def test_a_loaded_recipe_with_changes(tmp_path):
    recipe = sheetlight.Recipe.load("wood-small", **TINY)
    sheetlight.scale.generate(recipe, 2, tmp_path / "planks", "local", overrides={"camera.tilt_deg": 31})
    changed = [*_gen.set_arguments(TINY), "--set", "camera.tilt_deg=31"]
    _gen.run(["--recipe", "wood-small", *changed, "--n", "2", "--out", str(tmp_path / "wanted")])
    assert_same(files(tmp_path / "planks"), files(tmp_path / "wanted"))


def test_progress_tells_all_shards_once(tmp_path):
    seen = []

    def show(progress):
        seen.append((progress.finished, progress.made, progress.samples, progress.shards, str(progress)))

    sheetlight.scale.generate(**tiny(5, samples_per_shard=2), url=tmp_path / "planks", engine="local", progress=show)
    assert [entry[0] for entry in seen] == [entry[1] for entry in seen] == [0, 1, 2, 3]
    assert {entry[3] for entry in seen} == {3}
    assert sorted(after[2] - before[2] for before, after in zip(seen, seen[1:])) == [1, 2, 2]
    assert seen[-1][4].startswith(f"{tmp_path / 'planks'}: 3 of 3 shards, 5 samples in 3 shards made now")
