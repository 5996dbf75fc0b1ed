"""What the package does to the process around it: imports, threads, signals, forks; and the program `gen`."""

import json
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
import sheetlight
from conftest import GEN, SMALL, alone, gen

BANDS = {"scan.columns": 64, "scan.profiles": 1200}
"""A scan of many bands, which threads share."""


def test_import_is_quick_and_brings_nothing_heavy():
    # Processor time, which others on the machine leave nearly as it is.
    code = "import time; t = time.process_time(); import sheetlight, sys; print(time.process_time() - t, *sys.modules)"
    outputs = [alone(code).split() for _ in range(5)]
    assert min(float(seconds) for seconds, *_ in outputs) < 0.2
    heavy = {"torch", "ray", "pyarrow", "fsspec", "pandas", "numpy", "sheetlight.scale", "sheetlight.torch"}
    assert not heavy & set(outputs[0])


def test_parts_come_when_they_are_asked_for():
    code = "import sheetlight, sys; before = 'sheetlight.scale' in sys.modules; print(before, callable(sheetlight.scale.generate))"
    assert alone(code) == "False True\n"
    with pytest.raises(AttributeError, match="has no attribute 'scales'"):
        sheetlight.scales


def test_the_line_of_the_readme_works_with_the_wheel_alone():
    code = "import numpy, sheetlight; print(numpy.nanmean(sheetlight.Recipe.load('wood-small').sample(0).scatter))"
    assert float(alone(code)) == pytest.approx(float(np.nanmean(sheetlight.Recipe.load("wood-small").sample(0).scatter)))


def test_the_wheel_is_small():
    wheels = sorted((Path(__file__).parents[2] / "target" / "wheels").glob("*.whl"), key=lambda path: path.stat().st_mtime)
    assert 0 < wheels[-1].stat().st_size < 25_000_000


def test_packages_that_are_missing_are_told():
    recipe = "import sheetlight; s = sheetlight.Recipe.load('wood-small', scan={'columns': 64, 'profiles': 32})"
    tries = {
        f"{recipe}.sample(0).to_arrow()": "pyarrow is missing: pip install \"sheetlight[arrow]\"",
        "import sheetlight.torch": "torch is missing: pip install \"sheetlight[torch]\"",
        "import sheetlight; sheetlight.open('s3://bucket/planks')": "fsspec is missing: pip install \"sheetlight[remote]\"",
    }
    for code, words in tries.items():
        assert words in alone(f"try:\n    {code.replace('; ', chr(10) + '    ')}\nexcept ModuleNotFoundError as e:\n    print(e)")


def test_check_looks_for_onnxruntime_where_the_package_is_installed(boards, tmp_path):
    environment = {name: value for name, value in os.environ.items() if name not in ("VIRTUAL_ENV", "ORT_DYLIB_PATH")}
    model = Path(__file__).parents[1] / "models" / "wood_patches.onnx"
    asked = [GEN, "check", boards, "--split", "all", "--model", model]
    done = subprocess.run(asked, capture_output=True, text=True, timeout=60, env=environment, cwd=tmp_path)
    assert done.returncode == 1 and f"{sys.prefix} has no package onnxruntime" in done.stderr, done.stderr


def test_other_threads_go_on_while_a_sample_is_rendered():
    recipe = sheetlight.Recipe.load("wood-small", BANDS)
    counted, done = [0], threading.Event()

    def count():
        while not done.is_set():
            counted[0] += 1
            time.sleep(0.001)

    counter = threading.Thread(target=count)
    counter.start()
    before = counted[0]
    recipe.sample(0)
    turns = counted[0] - before
    done.set()
    counter.join()
    # A thread that holds the interpreter all the while leaves the other one no turn, but for one as it begins and one
    # as it ends.
    assert turns > 5, turns


STOPPED = """
import os, signal, threading, time, sheetlight
recipe = sheetlight.Recipe.load("wood", {"scan.profiles": 16000})
small = sheetlight.Recipe.load("wood-small", scan={"columns": 64, "profiles": 32})
small.sample(0)
sent = []

def stop():
    # Processor time, which others on the machine leave nearly as it is.
    sent.append(time.process_time())
    os.kill(os.getpid(), signal.SIGINT)

try:
    threading.Timer(1.0, stop).start()
    %s
    print("not stopped")
except KeyboardInterrupt:
    print("stopped", time.process_time() - sent[0])
print(small.sample(0).index, next(small.samples(3)).index)
"""


@pytest.mark.parametrize("work", ["recipe.sample(0)", "list(recipe.samples(40))"])
def test_ctrl_c_stops_at_once_and_leaves_a_process_that_works(work):
    word, spent, *later = alone(STOPPED % work).split()
    # The work itself takes some twenty seconds of processor time at least; stopping takes tens of milliseconds.
    assert word == "stopped" and float(spent) < 2.0, spent
    assert later == ["0", "0"]


def _render(recipe, index, results):
    results.put((os.getpid(), recipe.sample(index).scatter))


def test_a_forked_process_renders_what_its_parent_renders():
    recipe = sheetlight.Recipe.load("wood-small", BANDS)
    mine = recipe.sample(1, threads=2).scatter
    fork = multiprocessing.get_context("fork")
    results = fork.Queue()
    children = [fork.Process(target=_render, args=(recipe, 1, results), daemon=True) for _ in range(2)]
    for child in children:
        child.start()
    found = dict(results.get(timeout=60) for _ in children)
    assert len(found) == 2 and all(np.array_equal(scatter, mine, equal_nan=True) for scatter in found.values())
    for child in children:
        child.join(20)
        assert child.exitcode == 0


def _go_on(samples, results):
    try:
        next(samples)
    except RuntimeError as fault:
        results.put(str(fault))


def test_a_fork_while_others_render_is_no_trap():
    recipe = sheetlight.Recipe.load("wood-small", BANDS)
    samples = recipe.samples(50, threads=2)
    mine = next(samples)
    fork = multiprocessing.get_context("fork")
    results = fork.Queue()
    # Threads of this process are rendering ahead.
    child = fork.Process(target=_render, args=(recipe, 0, results), daemon=True)
    child.start()
    _, scatter = results.get(timeout=60)
    child.join(20)
    assert child.exitcode == 0 and np.array_equal(scatter, mine.scatter, equal_nan=True)
    other = fork.Process(target=_go_on, args=(samples, results), daemon=True)
    other.start()
    assert "another process" in results.get(timeout=60)
    other.join(20)
    assert next(samples).index == 1


def test_gen_is_the_same_program():
    assert gen("--version") == f"gen {sheetlight.__version__}\n"
    module = subprocess.run([sys.executable, "-m", "sheetlight", "--help"], capture_output=True, text=True)
    assert (module.returncode, module.stdout) == (0, gen("--help"))
    assert "Usage: gen" in module.stdout
    for arguments, status in [(["validate", "/nonexistent"], 1), (["--nonsense"], 2), ([], 2)]:
        done = subprocess.run([GEN, *arguments], capture_output=True, text=True)
        assert done.returncode == status
        assert "Traceback" not in done.stderr
    # A reader that goes away is no fault.
    shell = subprocess.run(f"{GEN} schema recipe | head -n 1", shell=True, capture_output=True, text=True)
    assert (shell.stdout, shell.stderr) == ("{\n", "")


def test_datasets_are_made_checked_and_shown(tmp_path):
    seen = []
    recipe = sheetlight.Recipe.load("wood-small", SMALL)
    out = tmp_path / "boards"
    made = sheetlight.generate(
        recipe, 5, out, seed=4, threads=2, samples_per_shard=2, progress=lambda *counts: seen.append(counts)
    )
    assert (made["made_samples"], made["samples"], made["recipe_hash"], made["seed"]) == (5, 5, recipe.hash, 4)
    assert seen == [(done, 5) for done in range(6)]
    assert sheetlight.generate("wood-small", 6, out, overrides=SMALL, seed=4)["made_samples"] >= 1
    assert np.array_equal(sheetlight.open(out).sample(5).label, recipe.sample(5, seed=4).label)
    assert sheetlight.validate(out)["faults"] == []
    page = sheetlight.report(out, samples=3)
    assert page == out / "reports" / "report.html" and page.stat().st_size > 10_000
    assert sheetlight.report(out, out=tmp_path / "page.html") == tmp_path / "page.html"

    [table] = (out / "data").glob("*-00001.parquet")
    table.write_bytes(table.read_bytes()[:-7])
    codes = [fault["code"] for fault in sheetlight.validate(out)["faults"]]
    assert codes and all(isinstance(code, str) for code in codes)


def test_faults_of_the_program_are_its_words(tmp_path):
    with pytest.raises(sheetlight.GenError) as caught:
        sheetlight.generate("wood-small", 2, tmp_path / "a", overrides={"camera.tilt_deg": 130})
    assert caught.value.status == 1 and "camera.tilt_deg" in str(caught.value) and not str(caught.value).startswith("gen:")
    with pytest.raises(sheetlight.GenError, match="--n 0: a dataset has 1 sample or more") as caught:
        sheetlight.generate("wood-small", 0, tmp_path / "b")
    assert caught.value.status == 2
    with pytest.raises(sheetlight.GenError, match="no such folder"):
        sheetlight.report(tmp_path / "none")

    def fail(done, _):
        if done:
            raise LookupError("mine")

    with pytest.raises(LookupError, match="mine"):
        sheetlight.generate("wood-small", 500, tmp_path / "c", overrides=SMALL, progress=fail)


def _fake(tmp_path, monkeypatch, script):
    """A program in place of `gen` that notes each call; how often it was called."""
    fake, calls = tmp_path / "fake", tmp_path / "calls"
    fake.write_text(f"#!/bin/sh\necho $$ >> '{calls}'\n{script}\n")
    fake.chmod(0o755)
    monkeypatch.setenv("SHEETLIGHT_GEN", str(fake))
    return lambda: [int(line) for line in calls.read_text().split()] if calls.exists() else []


def test_a_validation_that_fails_is_told_and_runs_once(tmp_path, monkeypatch):
    report = {"faults": [{"code": "mine"}]}
    calls = _fake(tmp_path, monkeypatch, f"echo '{json.dumps(report)}'; echo 'gen: 1 fault' >&2; exit 1")
    assert sheetlight.validate(tmp_path) == report and len(calls()) == 1
    # Status 1 without a report is a refusal, or a report that could not be kept.
    calls = _fake(tmp_path, monkeypatch, "echo 'gen: the report cannot be kept: no space' >&2; exit 1")
    with pytest.raises(sheetlight.GenError, match="^the report cannot be kept: no space$"):
        sheetlight.validate(tmp_path, save=True)
    assert len(calls()) == 2


def test_a_report_that_cannot_be_kept_is_told(tmp_path):
    out = tmp_path / "boards"
    sheetlight.generate("wood-small", 1, out, overrides=SMALL)
    (out / "reports").write_text("a file where the folder goes")
    with pytest.raises(sheetlight.GenError, match="reports"):
        sheetlight.validate(out, save=True)
    # Without it the file is a fault like others.
    assert [fault["place"] for fault in sheetlight.validate(out)["faults"]] == ["reports"]
    (out / "reports").unlink()
    assert sheetlight.validate(out, save=True)["faults"] == [] and list((out / "reports").iterdir())


def test_urls_are_no_folders(boards, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for url in ("s3://bucket/boards", "simplecache::s3://bucket/boards", Path("gs://bucket/boards"), "file:///tmp/boards"):
        for call, words in [
            (lambda: sheetlight.generate("wood-small", 1, url, overrides=SMALL), "out: .*sheetlight.scale.generate"),
            (lambda: sheetlight.validate(url), "folder: .*sheetlight.open"),
            (lambda: sheetlight.report(url), "folder: .*sheetlight.open"),
            (lambda: sheetlight.report(boards, out=url), "out: .*on this machine"),
            (lambda: sheetlight.Recipe.load(url), "name: .*copy the recipe"),
            (lambda: sheetlight.generate(url, 1, tmp_path / "out"), "recipe: .*copy the recipe"),
        ]:
            with pytest.raises(ValueError, match=words):
                call()
    assert not list(tmp_path.iterdir())


def test_arguments_of_generate_that_cannot_be_used_are_told(boards, tmp_path, monkeypatch):
    out = tmp_path / "out"
    for more, fault, words in [
        ({"overrides": ["scan.columns=64"]}, TypeError, "overrides: give a mapping .* not list"),
        ({"overrides": {3: 4}}, TypeError, "overrides: 3 is no key"),
        ({"part": (1,)}, ValueError, r"part: \(1,\): give \(k, m\)"),
        ({"part": 2}, ValueError, "part: 2: give"),
        ({"n": 2.7}, sheetlight.GenError, "'2.7' for '--n"),
        ({"seed": "a"}, sheetlight.GenError, "'a' for '--seed"),
        ({"recipe": 3}, TypeError, "recipe: give a path, not int"),
        ({"recipe": ""}, ValueError, "recipe: the path is empty"),
        ({"out": ""}, ValueError, "out: the path is empty"),
    ]:
        with pytest.raises(fault, match=words):
            sheetlight.generate(**{"recipe": "wood-small", "n": 1, "out": out, **more})
    # Not the dataset that the program runs in.
    monkeypatch.chdir(boards)
    gen("--recipe", "", "--n", 1, "--out", out, status=1)
    assert not out.exists()


def test_the_seed_is_that_of_the_recipe_then_that_of_the_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert sheetlight.generate("wood-small", 1, "five", overrides=SMALL, seed=5)["seed"] == 5
    five = sheetlight.Recipe.load("five")
    assert five.seed == 5
    for place, recipe in [("loaded", five), ("named", "five"), ("path", Path("five")), ("changed", sheetlight.Recipe.load("five", name="mine"))]:
        assert sheetlight.generate(recipe, 1, place)["seed"] == 5
        made, shown = sheetlight.open(place)[0], recipe.sample(0) if isinstance(recipe, sheetlight.Recipe) else five.sample(0)
        assert made.id == shown.id and made.parameters == shown.parameters and np.array_equal(made.label, shown.label)
    # A dataset goes on with its own seed.
    more = sheetlight.generate("wood-small", 2, "five", overrides=SMALL)
    assert (more["seed"], more["samples"]) == (5, 2)
    assert sheetlight.generate("wood-small", 1, "none", overrides=SMALL)["seed"] == 0
    assert sheetlight.generate(five, 1, "six", seed=6)["seed"] == 6
    # The recipe's seed is first: another dataset is refused and left as it is.
    with pytest.raises(sheetlight.GenError, match="seed"):
        sheetlight.generate(five, 2, "six")
    assert len(sheetlight.open("six")) == 1


def test_a_signal_while_the_program_starts_leaves_none_behind(tmp_path, monkeypatch):
    calls = _fake(tmp_path, monkeypatch, "exec sleep 300")
    start = threading.Thread.start
    for turn in range(2):
        turns = iter(range(2))

        def interrupted(thread):
            start(thread)
            if next(turns, None) == turn:
                while len(calls()) <= turn:
                    time.sleep(0.01)
                raise KeyboardInterrupt

        monkeypatch.setattr(threading.Thread, "start", interrupted)
        with pytest.raises(KeyboardInterrupt):
            sheetlight.validate(tmp_path)
    assert len(calls()) == 2
    for process in calls():
        with pytest.raises(ProcessLookupError):
            os.kill(process, 0)


THREADS = """
import os, time, sheetlight
recipe = sheetlight.Recipe.load("wood-small", scan={"columns": 64, "profiles": 32})
def threads():
    return set(os.listdir("/proc/self/task"))
before = threads()
for count in range(1, 11):
    recipe.sample(0, threads=count)
end = time.monotonic() + 30
# Of the last three numbers 27 rendering threads stay, of all ten it would be 55; a few may do something else.
while len(threads() - before) > 32 and time.monotonic() < end:
    time.sleep(0.05)
kept = threads() - before
for count in (8, 9, 10, 8):
    recipe.sample(0, threads=count)
print(len(kept), kept <= threads())
"""


@pytest.mark.skipif(not os.path.isdir("/proc/self/task"), reason="counts threads as Linux tells them")
def test_threads_of_numbers_that_nobody_asks_for_any_more_end():
    count, is_kept = alone(THREADS).split()
    assert 27 <= int(count) <= 32 and is_kept == "True"


def test_another_program_can_be_named(tmp_path, monkeypatch):
    fake = tmp_path / "other gen"
    fake.write_text(f"#!/bin/sh\necho '{json.dumps({'faults': []})}'\n")
    fake.chmod(0o755)
    monkeypatch.setenv("SHEETLIGHT_GEN", str(fake))
    assert sheetlight.validate(tmp_path) == {"faults": []}
    monkeypatch.setenv("SHEETLIGHT_GEN", str(tmp_path / "none"))
    with pytest.raises(FileNotFoundError, match="SHEETLIGHT_GEN"):
        sheetlight.validate(tmp_path)
    # What ends well and is no gen.
    for said in ("", "hello", "[1, 2]", "\\377"):
        fake.write_text(f"#!/bin/sh\nprintf '{said}'\n")
        monkeypatch.setenv("SHEETLIGHT_GEN", str(fake))
        for call in (
            lambda: sheetlight.validate(tmp_path),
            lambda: sheetlight.generate("wood-small", 1, tmp_path / "out"),
            lambda: sheetlight.report(tmp_path),
        ):
            with pytest.raises(sheetlight.GenError, match="other gen is no gen: .*let SHEETLIGHT_GEN name a gen"):
                call()


GENERATED = """
import sys, sheetlight
try:
    # More than is made before it is stopped, and room for it on a disk that is nearly full.
    asked = {"samples_per_shard": 1, "overrides": {"output.exr": [], "output.truth_maps": False}, "progress": lambda done, _: print(done, flush=True)}
    sheetlight.generate("wood-small", 400, sys.argv[1], **asked)
except KeyboardInterrupt:
    print("stopped", flush=True)
"""


def test_ctrl_c_stops_the_program_and_keeps_what_is_finished(tmp_path):
    child = subprocess.Popen([sys.executable, "-c", GENERATED, tmp_path / "out"], stdout=subprocess.PIPE, text=True)
    while child.stdout.readline() != "3\n":
        assert child.poll() is None
    # To Python alone, as Jupyter sends it.
    child.send_signal(signal.SIGINT)
    assert child.stdout.read().split()[-1] == "stopped" and child.wait(30) == 0
    running = subprocess.run(["pgrep", "-f", str(tmp_path / "out")], capture_output=True, text=True).stdout
    # Who was told to end may still be ending; one that goes on would make hundreds of samples.
    while running and len(sheetlight.open(tmp_path / "out")) < 200:
        running = subprocess.run(["pgrep", "-f", str(tmp_path / "out")], capture_output=True, text=True).stdout
        time.sleep(0.01)
    assert not running, "the program goes on"
    assert len(sheetlight.open(tmp_path / "out")) >= 2
