"""The examples for clusters: Slurm's script, by submitit and by Slurm itself; Kubernetes' documents against its schemas."""

import os
import re
import subprocess
import sys
import time

import pytest
import sheetlight.scale
from conftest import FULL, ROOT, assert_same, files, free_port, run, tiny, tiny_arguments, wait_until
from slurm_cluster import Slurm, missing

EXAMPLES = ROOT / "python" / "examples" / "cluster"
KUBERNETES = "1.33"
"""The version from which on the documents are to work."""


def test_submitit_makes_the_parts(tmp_path, reference):
    """Its local executor, whose functions also go to Slurm."""
    import submitit

    sheetlight.scale.begin(**tiny(5), url=tmp_path / "planks")
    executor = submitit.AutoExecutor(folder=tmp_path / "logs", cluster="local")
    executor.update_parameters(timeout_min=2, cpus_per_task=1)
    jobs = executor.map_array(sheetlight.scale.make, [str(tmp_path / "planks")] * 2, [(0, 2), (1, 2)])
    made = [[report["shard"] for report in job.result()] for job in jobs]
    assert made == [[0, 2, 4], [1, 3]]
    sheetlight.scale.finish(tmp_path / "planks")
    assert_same(files(tmp_path / "planks"), reference(5))


@pytest.fixture
def pretended_slurm(tmp_path, monkeypatch):
    """`sbatch` as a script: runs an array's tasks one after another, a job behind them where all ended well."""
    (tmp_path / "bin").mkdir()
    sbatch = tmp_path / "bin" / "sbatch"
    sbatch.write_text(
        f"#!{sys.executable}\n"
        "import os, pathlib, re, subprocess, sys\n"
        f"state = pathlib.Path({str(tmp_path)!r}) / 'ended'\n"
        "options = dict(option[2:].split('=', 1) for option in sys.argv[1:] if '=' in option)\n"
        "script, words = sys.stdin.read(), options['export'].split(',')\n"
        "assert words[0] == 'ALL'\n"
        "environment = os.environ | dict(word.split('=', 1) for word in words[1:] if '=' in word)\n"
        "if 'array' in options:\n"
        "    count = int(options['array'].split('-')[1]) + 1\n"
        "    cpus, statuses = options['cpus-per-task'], []\n"
        "    for task in range(count):\n"
        "        own = {'SLURM_ARRAY_TASK_ID': str(task), 'SLURM_ARRAY_TASK_COUNT': str(count), 'SLURM_CPUS_PER_TASK': cpus}\n"
        "        ran = subprocess.run(['bash'], input=script, text=True, env=environment | own, stdout=sys.stderr)\n"
        "        statuses.append(ran.returncode)\n"
        "    state.write_text(repr(statuses))\n"
        "    print('71;cluster')\n"
        "else:\n"
        "    assert options['dependency'] == 'afterok:71'\n"
        "    print(72)\n"
        "    if state.read_text() == repr([0] * state.read_text().count('0')):\n"
        "        sys.exit(subprocess.run(['bash'], input=script, text=True, env=environment, stdout=sys.stderr).returncode)\n"
    )
    sbatch.chmod(0o755)
    monkeypatch.setenv("PATH", f"{sbatch.parent}:{os.environ['PATH']}")
    monkeypatch.setenv("SHEETLIGHT_PYTHON", sys.executable)
    monkeypatch.setenv("CPUS", "1")


def submit(url, tasks, *arguments, status=0, **options):
    done = subprocess.run([EXAMPLES / "slurm.sh", url, str(tasks), *arguments], capture_output=True, text=True, **options)
    assert done.returncode == status, done.stdout + done.stderr
    return done


def test_script_for_slurm_with_a_pretended_one(tmp_path, pretended_slurm, reference):
    """Of a folder whose name means something to sbatch and to the shell."""
    submit("planks,=1 $x", 2, *tiny_arguments(5), cwd=tmp_path)
    assert_same(files(tmp_path / "planks,=1 $x"), reference(5))
    assert "camera.tilt" in submit("other", 2, *tiny_arguments(5), "--set", "camera.tilt=1", cwd=tmp_path, status=2).stderr
    assert (tmp_path / "ended").read_text() == "[0, 0]", "nothing was submitted for it"
    assert "URL TASKS" in submit("planks", "", status=2, cwd=tmp_path).stderr


@pytest.mark.skipif(not FULL, reason="SCALE_FULL=1 runs Slurm itself")
def test_script_for_slurm_with_a_node_that_dies(tmp_path, reference, logged):
    """Two nodes, eight tasks. One node dies while it renders: its task is requeued, the dataset finished."""
    assert missing() == [], "apt-get install slurmctld slurmd slurm-client munge"
    slurm = Slurm(tmp_path, [free_port() for _ in range(3)])
    try:
        wait_until(lambda: (tmp_path / "munge.socket").exists())
        wait_until(lambda: "idle" in _said(slurm, "sinfo", "-h", "-o", "%T %D"), 60, 0.5)
        environment = slurm.environment | {"SHEETLIGHT_PYTHON": sys.executable, "CPUS": "1"}
        told = submit(tmp_path / "planks", 8, *tiny_arguments(160), env=environment, cwd=tmp_path).stdout
        array, finish = re.search(r"array (\d+), then job (\d+)", told).groups()
        manifests = lambda: list((tmp_path / "planks").glob("shards/[0-9]*.json"))  # noqa: E731
        wait_until(lambda: len(manifests()) >= 20, 120)
        running = _said(slurm, "squeue", "-h", "-r", "-j", array, "-t", "R", "-o", "%K %N").split("\n")
        node = next(line.split()[1] for line in running if line)
        slurm.kill_node(node)
        killed = time.monotonic()
        wait_until(lambda: node in _said(slurm, "sinfo", "-h", "-N", "-t", "down", "-o", "%N"), 120, 0.5)
        print(f"{node} killed after {len(manifests())} shards, found down after {time.monotonic() - killed:.0f} s")
        slurm.start_node(node)
        wait_until(lambda: not _said(slurm, "squeue", "-h", "-j", f"{array},{finish}").strip(), 300, 1.0)
        restarts = _said(slurm, "scontrol", "show", "job", array)
        assert "Restarts=1" in restarts, restarts
        assert_same(files(tmp_path / "planks"), reference(160))
    finally:
        slurm.stop()


def _said(slurm, *arguments):
    try:
        return slurm.ask(*arguments)
    except subprocess.CalledProcessError as fault:
        return fault.stderr


def documents():
    import yaml

    return {name: yaml.safe_load((EXAMPLES / name).read_text()) for name in ("kubernetes.yaml", "kubernetes-finish.yaml")}


def test_documents_of_kubernetes_fit_its_schema():
    import kubernetes_validate

    for document in documents().values():
        kubernetes_validate.validate(document, KUBERNETES, strict=True)
    wrong = documents()["kubernetes.yaml"]
    wrong["spec"]["podFailurePolicy"]["rules"][0]["onExitCode"] = {}
    with pytest.raises(kubernetes_validate.ValidationError):
        kubernetes_validate.validate(wrong, KUBERNETES, strict=True)


def test_documents_of_kubernetes_agree_with_the_program(tmp_path, reference):
    """What a schema does not say: containers that rules name, the number of parts, the command, the status that is final."""
    job, finish = documents().values()
    spec = job["spec"]
    (container,), rules = spec["template"]["spec"]["containers"], spec["podFailurePolicy"]["rules"]
    (last,) = finish["spec"]["template"]["spec"]["containers"]
    assert rules[0]["onExitCodes"]["containerName"] == container["name"]
    assert finish["spec"]["podFailurePolicy"]["rules"][0]["onExitCodes"]["containerName"] == last["name"]
    assert rules[0]["onExitCodes"]["values"] == [sheetlight.scale.Refusal.status]
    assert sheetlight.scale.Interruption.status not in (0, sheetlight.scale.Refusal.status)
    assert spec["completions"] <= spec["parallelism"]

    # The commands themselves, with three indices and a folder in place of a bucket.
    url = str(tmp_path / "planks")
    run("begin", url, *tiny_arguments(4))

    def started(words, index=None):
        words = [word.replace("s3://bucket/planks", url).replace("$(JOB_COMPLETION_INDEX)", str(index)) for word in words]
        words = [re.sub(rf"^(\d+)/{spec['completions']}$", r"\1/3", word) for word in words]
        assert words[:3] == ["python", "-m", "sheetlight.scale"] and not any("$(" in word for word in words)
        return run(*words[3:])

    for index in range(3):
        started(container["command"], index)
    started(last["command"])
    assert_same(files(tmp_path / "planks"), reference(4))
