"""Tests of the installed wheel. `make test-wheel` runs them: the package comes from .venv-wheel, readers to compare with from .venv.

SHEETLIGHT_WHEEL_FULL=1 compares 50 samples of every built-in recipe in place of 1.
"""

import os
import signal
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

# A shell that runs tests in the background has them, and what they start, ignore Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)

FULL = os.environ.get("SHEETLIGHT_WHEEL_FULL") == "1"
GEN = Path(sysconfig.get_path("scripts")) / "gen"
SMALL = {"scan.columns": 96, "scan.profiles": 40}


def gen(*arguments, status=0):
    """Runs the console script of the wheel; its output."""
    done = subprocess.run([GEN, *map(str, arguments)], capture_output=True, text=True, timeout=600)
    assert done.returncode == status, (arguments, done.returncode, done.stderr)
    return done.stdout


def write(recipe, n, out, changes, *more):
    sets = [word for key, value in changes.items() for word in ("--set", f"{key}={value}")]
    gen("--recipe", recipe, "--n", n, "--out", out, "--quiet", *sets, *more)


def alone(code, *, timeout=120, **variables):
    """Runs Python code with what the wheel itself brings, and nothing of .venv; its output."""
    environment = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "SHEETLIGHT_GEN")}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=timeout, env={**environment, **variables}
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="session")
def boards(tmp_path_factory):
    """A dataset with everything: images, EXR files, truth, sensor frames, several shards, all splits."""
    out = tmp_path_factory.mktemp("datasets") / "boards"
    changes = {**SMALL, "output.sensor_stack": "{every: 20}"}
    write("wood-small", 20, out, changes, "--seed", 7, "--samples-per-shard", 6)
    return out
