"""Datasets in a folder, by processes of one machine: what does not depend on the store, and faults before any work."""

import errno
import json
import os
import random
import shutil
import signal
import socket
import stat
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
import sheetlight
import sheetlight.scale
from conftest import TINY, assert_same, command, files, run, tiny, tiny_arguments, wait_until
from sheetlight import _gen
from sheetlight.scale import dataset
from sheetlight.scale.dataset import manifest_path
from sheetlight.scale.program import NO_SHARD, _writer
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


def test_fewer_samples_than_it_was_begun_with_are_refused(tmp_path):
    run("begin", tmp_path / "planks", *tiny_arguments(4))
    said = run("generate", tmp_path / "planks", "--engine", "local", *tiny_arguments(2), status=2).stderr
    assert "begun with 4 samples" in said and "2 are asked for" in said


def test_no_dataset_is_begun_in_another_one(tmp_path):
    run("begin", tmp_path / "planks", *tiny_arguments(2))
    before = files(tmp_path / "planks")
    said = run("begin", tmp_path / "planks" / "data" / "new", *tiny_arguments(2), status=2).stderr
    assert "lies in the dataset" in said and "choose a folder elsewhere" in said
    assert files(tmp_path / "planks") == before


def test_another_version_is_refused(tmp_path, monkeypatch):
    """By whoever begins, and by each task."""
    url = tmp_path / "planks"
    run("begin", url, *tiny_arguments(2))
    document = (url / "dataset.json").read_text()
    (url / "dataset.json").write_text(document.replace(f'"version": "{_version()}"', '"version": "0.0.1"'))
    said = run("generate", url, "--engine", "local", *tiny_arguments(2), status=2).stderr
    assert f'{url}: generator.version: "0.0.1" -> "{_version()}"' in said
    for asked in ("task", "finish"):
        assert "gen 0.0.1 for " in run(asked, url, status=2).stderr


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
        "s3:///planks": "names no bucket",
        "s3:/bucket/planks": "two slashes, s3://bucket/planks",
        Path("hf://buckets/me/planks"): "two slashes, hf://buckets/me/planks",
        "file:/planks": "two slashes",
        "file://host/planks": "names another machine",
        "": "names no folder",
        "file://": "names no folder",
    }
    for url, words in refused.items():
        with pytest.raises(sheetlight.scale.Refusal, match=words) as fault:
            Store(url)
        assert "hidden" not in str(fault.value)


def test_places_that_are_none_are_refused_before_anything_is_written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for place in ("", "s3:/bucket/planks"):
        for asked in ("begin", "generate"):
            run(asked, place, *tiny_arguments(2), status=2)
    assert list(tmp_path.iterdir()) == []
    assert Store("./s3:/bucket").url == str(tmp_path / "s3:" / "bucket")


def test_impossible_places_are_told_at_once(tmp_path):
    """No attempts that cannot succeed, and remedies that fit the place."""
    (tmp_path / "file").write_text("")
    places = {
        "s3://no bucket!/planks": ["Invalid bucket name", "correct the URL"],
        str(tmp_path / "file"): ["Not a directory", "correct the URL"],
        "/proc/planks": ["there is no such folder and it cannot be made"],
    }
    for place, words in places.items():
        said = run("begin", place, *tiny_arguments(2), status=2).stderr
        assert place in said and all(word in said for word in words), said
        assert "attempts" not in said


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
    assert task.wait(60) == 143, task.stderr.read()
    assert [path for path in scratch.rglob("*") if path.is_file()] == []
    assert not (url / "shards").exists()


@pytest.fixture
def small_disk(tmp_path):
    """A disk of 1 MB in memory, which only root can mount: elsewhere SHEETLIGHT_NO_DISK=1 leaves these tests out."""
    if os.environ.get("SHEETLIGHT_NO_DISK") == "1":
        pytest.skip("SHEETLIGHT_NO_DISK=1")
    disk = tmp_path / "disk"
    disk.mkdir()
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", disk], capture_output=True, text=True)
    assert not mounted.returncode, f"no disk can be mounted ({mounted.stderr}): be root, or set SHEETLIGHT_NO_DISK=1"
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


def test_a_scratch_disk_that_is_full_before_the_first_task(tmp_path, small_disk):
    """Whatever the step that finds no room, in `gen` or before it, it is the scratch disk that is told of, not the place."""
    url, filler = tmp_path / "planks", small_disk / "filler"
    size = shutil.disk_usage(small_disk).free
    for free in (0, 1, 4, 8, 20, 50):
        filler.write_bytes(b"7" * (size - 4096 * free))
        said = run("begin", url, *tiny_arguments(2), "--scratch", small_disk, status=1).stderr
        assert f"{small_disk}/" in said and "--scratch" in said and str(url) not in said, said
        assert not url.exists()
    filler.unlink()
    run("begin", url, *tiny_arguments(2), "--scratch", small_disk)


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


@pytest.mark.parametrize(
    ("number", "to_all", "status"),
    [(signal.SIGINT, True, 130), (signal.SIGINT, False, 130), (signal.SIGTERM, False, 143)],
)  # fmt: skip
def test_a_signal_stops_all_and_leaves_no_scratch(tmp_path, number, to_all, status):
    """As a terminal sends it, to the program and to every `gen` that it started, and to the program alone."""
    url, scratch = tmp_path / "planks", tmp_path / "scratch"
    # Minutes of work, so that nothing ends by itself, and no more disk than it takes.
    asked = ["--recipe", "wood-small", "--n", "4000", "--samples-per-shard", "1000", "--set", "output.exr=[]", "--set", "output.truth_maps=false"]
    asked += ["--scratch", scratch]
    driver = subprocess.Popen(
        command("generate", url, "--engine", "local", *asked), stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    wait_until(lambda: any(scratch.rglob(".tmp-train-*.parquet")))
    (os.killpg if to_all else os.kill)(driver.pid, number)
    said = driver.communicate(timeout=60)[1]
    assert driver.returncode == status and "Traceback" not in said, said
    assert "stopped; finished shards are kept" in said or number != signal.SIGINT, said
    with pytest.raises(ProcessLookupError):
        os.killpg(driver.pid, 0)  # it was the leader of its group: nothing that it started runs
    assert [path for path in scratch.rglob("*") if path.is_file()] == []
    assert not (url / "shards").exists()


def test_programs_of_threads_are_stopped(tmp_path, monkeypatch):
    """Those that run, those that start later, and by force those that do not listen."""
    program = tmp_path / "gen"
    monkeypatch.setenv(_gen.VARIABLE, str(program))
    monkeypatch.setattr(_gen, "PATIENCE_S", 0.5)
    for trap, status in (("", -signal.SIGINT), ("trap '' INT; ", -signal.SIGKILL)):
        program.write_text(f"#!/bin/sh\n{trap}touch {tmp_path}/runs; exec sleep 100\n")
        program.chmod(0o755)
        stop = _gen.Stop()
        with ThreadPoolExecutor(1) as pool:
            running = pool.submit(_gen.run, [], stop=stop)
            wait_until((tmp_path / "runs").exists)
            stop.set()
            assert running.exception(5).status == status
        (tmp_path / "runs").unlink()
    program.write_text("#!/bin/sh\nexec sleep 100\n")
    with pytest.raises(_gen.GenError):
        _gen.run([], stop=stop)


def test_a_store_begins_no_request_once_it_is_stopped(tmp_path):
    stop = _gen.Stop()
    store = Store(tmp_path / "planks", stop)
    store.write("a", b"1")
    stop.set()
    with pytest.raises(sheetlight.scale.Interruption, match="planks/b: stopped, and did not write it"):
        store.write("b", b"2")
    assert list(files(tmp_path / "planks")) == ["a"]


@pytest.mark.parametrize("number", [errno.EPERM, errno.ENOTSUP, errno.ENOSYS, errno.EMLINK, errno.EACCES])
def test_a_folder_without_hard_links(tmp_path, monkeypatch, number):
    """As FAT, exFAT, FUSE and CIFS answer: what is there is looked at. Other faults are told as they are."""

    def link(*_, **__):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "link", link)
    url = tmp_path / "planks"
    if number == errno.EACCES:
        assert "check owner and permissions of the folder" in run("begin", url, *tiny_arguments(2), status=2).stderr
        assert files(url) == {}
        return
    run("begin", url, *tiny_arguments(2))
    before = files(url)
    assert json.loads(before["dataset.json"])["samples"] == 2
    assert not Store(url).create("dataset.json", b"another")
    assert "seed: 0 -> 1" in run("begin", url, *tiny_arguments(2), "--seed", "1", status=2).stderr
    assert files(url) == before


def test_an_upload_whose_temporary_file_is_swept(tmp_path, monkeypatch, reference):
    """Somebody finishes the dataset while another task uploads a file to it: it is uploaded again."""
    url, origin = tmp_path / "planks", tmp_path / "origin"
    sheetlight.scale.generate(**tiny(2), url=url, engine="local")
    origin.mkdir()
    (origin / "late").write_bytes(random.Random(4).randbytes(1000))
    real, swept = shutil.copyfileobj, []

    def copy(source, *more):
        real(source, *more)
        if source.name == str(origin / "late") and not swept:
            swept.append(list(url.glob(".tmp-late.*")))
            sheetlight.scale.finish(url)
            assert not any(url.glob(".tmp-late.*"))

    monkeypatch.setattr(shutil, "copyfileobj", copy)
    Store(url).upload(origin, ["late"])
    assert [len(files) for files in swept] == [1]
    assert_same(files(url), reference(2) | files(origin))


def test_two_writers_of_a_folder(tmp_path, reference):
    url = tmp_path / "planks"
    arguments = ["generate", url, "--engine", "local", *tiny_arguments(6)]
    writers = [subprocess.Popen(command(*arguments), stderr=subprocess.PIPE, text=True) for _ in range(2)]
    ended = [(writer.communicate()[1], writer.returncode) for writer in writers]
    assert [status for _, status in ended] == [0, 0], ended
    assert_same(files(url), reference(6))


def test_names_are_on_disk_before_what_relies_on_them(tmp_path, monkeypatch):
    """Folders are synchronised too, new ones in the folder above, and after the file has its name."""
    synced, real = [], os.fsync

    def fsync(opened):
        real(opened)
        if stat.S_ISDIR(os.fstat(opened).st_mode):
            place = Path(f"/proc/self/fd/{opened}").readlink()
            synced.append((place.relative_to(tmp_path).as_posix(), sorted(path.name for path in place.iterdir())))

    monkeypatch.setattr(os, "fsync", fsync)
    Store(tmp_path / "planks").write("data/001/a", b"1")
    assert dict(synced) == {".": ["planks"], "planks": ["data"], "planks/data": ["001"], "planks/data/001": ["a"]}
    synced.clear()
    assert Store(tmp_path / "planks").create("data/001/b", b"2")
    assert dict(synced)["planks/data/001"] == ["a", "b"]


@pytest.mark.skipif(os.name != "posix", reason="folders are opened on POSIX systems alone")
def test_folders_that_cannot_be_synchronised(tmp_path, monkeypatch):
    """Where the file system does not know it, the file is written all the same; a fault of the disk is told."""
    real = os.fsync
    for number, works in ((errno.EINVAL, True), (errno.ENOSPC, False)):

        def fsync(opened, number=number):
            if stat.S_ISDIR(os.fstat(opened).st_mode):
                raise OSError(number, os.strerror(number))
            real(opened)

        monkeypatch.setattr(os, "fsync", fsync)
        store = Store(tmp_path / str(number))
        if works:
            store.write("a", b"1")
            assert files(tmp_path / str(number)) == {"a": b"1"}
        else:
            with pytest.raises(sheetlight.scale.Refusal, match="No space left on device"):
                store.write("a", b"1")


def test_another_target_is_refused(tmp_path, logged):
    """A dataset that was begun for other machines: whoever goes on with it, before anything is rendered, and only once."""
    url = tmp_path / "planks"
    run("begin", url, *tiny_arguments(2))
    document = json.loads((url / "dataset.json").read_text())
    here = document["target"]
    document["target"] = "riscv64gc-unknown-linux-gnu"
    (url / "dataset.json").write_text(json.dumps(document))
    before, earlier = files(url), len(logged())
    for asked in (["begin", *tiny_arguments(4)], ["generate", "--engine", "local", *tiny_arguments(2)]):
        said = run(asked[0], url, *asked[1:], status=2).stderr
        assert f'{url}: target: "riscv64gc-unknown-linux-gnu" -> "{here}"' in said
    for asked in ("task", "finish"):
        said = run(asked, url, status=2).stderr
        assert f"{url}: gen {_version()} for riscv64gc-unknown-linux-gnu began this dataset" in said
        assert f"for {here}, whose values may differ; take machines of one kind" in said
    with pytest.raises(sheetlight.scale.Refusal, match="riscv64gc"):
        sheetlight.scale.make_shard(str(url), 0)
    assert files(url) == before
    assert {part for part, what, *_ in logged()[earlier:] if what == "begun"} <= {NO_SHARD}


def test_numbers_that_are_none(tmp_path):
    url = tmp_path / "planks"
    for option, number in (("--retries", "-1"), ("--threads", "0"), ("--threads", "two"), ("--retries", "1.5")):
        said = run("generate", url, *tiny_arguments(2), option, number, status=2).stderr
        assert f"{option}: {number}: give a whole number, " in said
    for engine in ("local", "ray"):
        for name, number in (("retries", -1), ("threads", 0), ("threads", "two"), ("retries", None)):
            with pytest.raises(sheetlight.scale.Refusal, match=f"{name} {number!r}: give a whole number"):
                sheetlight.scale.generate(**tiny(2), url=url, engine=engine, **{name: number})
    for engine, options in (("local", {"workers": 0}), ("local", {"workers": -2}), ("local", {"workers": "2"}), ("ray", {"max_retries": -1})):
        ((name, number),) = options.items()
        with pytest.raises(sheetlight.scale.Refusal, match=f"{name} {number!r}: give a whole number"):
            sheetlight.scale.generate(**tiny(2), url=tmp_path / "begun", engine=engine, engine_options=options)
    assert not url.exists()
    for part in ("0/2", (1,), (0, 1, 2), None, (0, 2.0), (2, 2)):
        with pytest.raises(sheetlight.scale.Refusal, match="^part .*: give .*, for instance "):
            sheetlight.scale.make(tmp_path / "begun", part)
    with pytest.raises(sheetlight.scale.Refusal, match="threads 0"):
        sheetlight.scale.make_shard(str(tmp_path / "begun"), 0, threads=0)


def test_a_program_that_does_not_work(tmp_path):
    """Its faults are told in its own words, and another program is told from `gen`."""
    url, program = tmp_path / "planks", tmp_path / "gen"
    run("begin", url, *tiny_arguments(2))
    for script, status, words in (
        ("echo 'gen: libfoo.so is missing' >&2; exit 127", 1, "libfoo.so is missing"),
        ("kill -9 $$", 1, "was ended by signal 9"),
        ("echo '{}'", 2, f"{program} on {socket.gethostname()} is no gen"),
        ("echo gen 0.2.0", 2, "is no gen"),
    ):
        program.write_text(f"#!/bin/sh\n{script}\n")
        program.chmod(0o755)
        _writer.cache_clear()
        for asked in ("task", "finish"):
            assert words in run(asked, url, status=status, SHEETLIGHT_GEN=str(program)).stderr
        if status == 2:
            assert "is no gen" in run("begin", tmp_path / "other", *tiny_arguments(2), status=2, SHEETLIGHT_GEN=str(program)).stderr
    _writer.cache_clear()
    for missing in (tmp_path / "no-gen", tmp_path):
        assert "gen cannot be started" in run("task", url, status=2, SHEETLIGHT_GEN=str(missing)).stderr


def test_a_larger_number_that_somebody_writes_meanwhile(tmp_path, monkeypatch):
    """Two extend a dataset at once; whatever the order in which they read and write, `begin` leaves the larger number there."""
    for n in (3, 6):
        run("begin", tmp_path / str(n), *tiny_arguments(n))
    three, six = ((tmp_path / str(n) / "dataset.json").read_bytes() for n in (3, 6))
    url = tmp_path / "planks"
    real_run, real_upload = dataset.program.run, Store.upload

    def extended_meanwhile(*arguments, **options):
        done = real_run(*arguments, **options)
        (url / "dataset.json").write_bytes(six)
        return done

    run("begin", url, *tiny_arguments(3))
    with monkeypatch.context() as patch:
        patch.setattr(dataset.program, "run", extended_meanwhile)
        assert sheetlight.scale.begin(**tiny(4), url=url)["samples"] == 6
    assert (url / "dataset.json").read_bytes() == six

    def written_over(store, folder, paths):
        real_upload(store, folder, paths)
        if paths == dataset.DOCUMENTS and not over:
            over.append((url / "dataset.json").write_bytes(three))

    over = []
    (url / "dataset.json").write_bytes(three)
    monkeypatch.setattr(Store, "upload", written_over)
    assert sheetlight.scale.begin(**tiny(6), url=url)["samples"] == 6
    assert over and (url / "dataset.json").read_bytes() == six


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


def test_the_seed_is_that_of_the_recipe_or_of_the_dataset(tmp_path):
    """Where none is given; one that differs from the dataset's is refused."""
    first, second, url = tmp_path / "first", tmp_path / "second", tmp_path / "planks"
    seed = random.randrange(1, 2**63)
    begin, generate = sheetlight.scale.begin, sheetlight.scale.generate
    assert begin(**tiny(1), url=first, seed=seed)["seed"] == seed
    generate(**tiny(2), url=first, engine="local")
    assert sheetlight.scale.status(first)["seed"] == seed and not sheetlight.scale.status(first)["missing"]
    run("begin", first, *tiny_arguments(2))
    generate(sheetlight.Recipe.load(first), 2, second, "local", samples_per_shard=1)
    of_first, of_second = ({path: data for path, data in files(at).items() if path.startswith("data/")} for at in (first, second))
    assert of_first == of_second and len(of_first) >= 2
    for number, recipe in enumerate((first, str(first))):
        assert begin(recipe, 2, tmp_path / str(number))["seed"] == seed
    for given in (0, seed - 1):
        with pytest.raises(sheetlight.scale.Refusal, match=f"seed: {seed} -> {given}"):
            begin(**tiny(2), url=first, seed=given)
    begin(**tiny(2), url=url)
    assert sheetlight.scale.status(url)["seed"] == 0
    with pytest.raises(sheetlight.scale.Refusal, match=f"seed: 0 -> {seed}"):
        begin(sheetlight.Recipe.load(first), 2, url, samples_per_shard=1)
    assert "recipe: " in run("begin", tmp_path / "none", "--recipe", "s3://bucket/planks", "--n", "2", status=2).stderr


def test_long_silence_is_told_once(tmp_path, monkeypatch, caplog):
    failures = random.randrange(2, 5)
    store, left = Store(tmp_path), iter(range(failures))

    def read(_path):
        if next(left, None) is not None:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        return b"7"

    monkeypatch.setattr(store._place, "read", read)
    monkeypatch.setattr("sheetlight.scale.store.FIRST_PAUSE_S", 0.01)
    monkeypatch.setattr("sheetlight.scale.store.SILENCE_S", 0.004)
    assert store.read("file") == b"7"
    assert [record.getMessage() for record in caplog.records] == [
        f"{tmp_path}/file: cannot read it yet: Input/output error; trying again"
    ]


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
