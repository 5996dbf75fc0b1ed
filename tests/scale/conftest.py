"""What tests of scaling out share: tiny recipes, `gen` and the package as their users run them, a store on the loopback.

`make test-scale` makes what they need and runs them: the installed package with python/requirements-scale.txt, and beside it an
environment with python/requirements-moto.txt, `.venv-moto` or what SHEETLIGHT_MOTO names. SCALE_FULL=1 runs them in full size.
"""

import contextlib
import io
import json
import os
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from pathlib import Path

import pytest
import s3fs
from sheetlight import _gen
from sheetlight.scale.__main__ import main

# A shell that runs tests in the background has them, and what they start, ignore Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)

ROOT = Path(__file__).parents[2]
FULL = os.environ.get("SCALE_FULL") == "1"
SERVER = Path(os.environ.get("SHEETLIGHT_MOTO", ROOT / ".venv-moto")) / "bin" / "moto_server"

TINY = {"scan.columns": 64, "scan.profiles": 48, "speckle.strength": 0}
"""Changes to wood-small that make a sample cost 0.03 s."""

KEYS = {
    "AWS_ACCESS_KEY_ID": "testing",
    "AWS_SECRET_ACCESS_KEY": "a-secret-that-nobody-may-print",
    "AWS_DEFAULT_REGION": "us-east-1",
}
"""Credentials of the store, as its tools find them."""


def free_port() -> int:
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        return listening.getsockname()[1]


def wait_until(condition, limit_s: float = 60.0, every_s: float = 0.05) -> None:
    """Waits until something is so, and fails where it never is. Folders that it looks into may vanish meanwhile."""
    end = time.monotonic() + limit_s
    while True:
        with contextlib.suppress(FileNotFoundError):
            if condition():
                return
        assert time.monotonic() < end, "waited in vain"
        time.sleep(every_s)


def tiny(n: int, **options) -> dict:
    """Arguments of `generate` and `begin` for a tiny dataset of n samples, one a shard."""
    return {"recipe": "wood-small", "n": n, "samples_per_shard": 1, "overrides": TINY} | options


def tiny_arguments(n: int, samples_per_shard: int = 1) -> list[str]:
    """The same for a command line."""
    asked = ["--recipe", "wood-small", "--n", str(n), "--samples-per-shard", str(samples_per_shard)]
    return asked + _gen.set_arguments(TINY)


def files(folder: Path) -> dict[str, bytes]:
    """All files below a folder by path."""
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def assert_same(found: dict[str, bytes], wanted: dict[str, bytes]) -> None:
    """All files, and all their bytes."""
    assert sorted(found) == sorted(wanted)
    assert [path for path in wanted if found[path] != wanted[path]] == []


def command(*arguments) -> list[str]:
    """`python -m sheetlight.scale` with arguments."""
    return [sys.executable, "-m", "sheetlight.scale", *map(str, arguments)]


def run(*arguments, status: int = 0, **environment) -> subprocess.CompletedProcess:
    """Does what `command` says within this process and checks the exit status; nothing of credentials may be said."""
    out, err, handler = io.StringIO(), io.StringIO(), signal.getsignal(signal.SIGTERM)
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        for name, value in environment.items():
            patch.setenv(name, value)
        forget_stores()
        try:
            ended = main([str(argument) for argument in arguments])
        except SystemExit as exit:
            ended = exit.code
    signal.signal(signal.SIGTERM, handler)
    forget_stores()
    said = out.getvalue() + err.getvalue()
    assert ended == status, said
    assert "Traceback" not in said
    secret = os.environ.get("AWS_SECRET_ACCESS_KEY", KEYS["AWS_SECRET_ACCESS_KEY"])
    assert environment.get("AWS_SECRET_ACCESS_KEY", secret) not in said
    return subprocess.CompletedProcess(arguments, ended, out.getvalue(), err.getvalue())


def forget_stores() -> None:
    """What fsspec keeps of the environment as it was."""
    s3fs.S3FileSystem.clear_instance_cache()


@pytest.fixture(scope="session")
def reference(tmp_path_factory):
    """A function of n: the files of a tiny dataset that one `gen` wrote."""
    known = {}

    def written(n: int, samples_per_shard: int = 1) -> dict[str, bytes]:
        key = n, samples_per_shard
        if key not in known:
            out = tmp_path_factory.mktemp("reference") / "planks"
            _gen.run([*tiny_arguments(n, samples_per_shard), "--out", str(out)])
            known[key] = files(out)
        return known[key]

    return written


def log_gen(folder: Path, patch: pytest.MonkeyPatch):
    """Lets `gen` write down each part that it is asked for; a function that gives them so far.

    Each is (part, "begun" or "done", process that started it, time [s since the epoch]). A `gen` that has begun its part goes on
    once `folder` has no file `hold`.
    """
    log, hold, program = folder / "gen.log", folder / "hold", folder / "gen"
    real = " ".join(f"'{word}'" for word in _gen.command())
    # One short line is written at once, whoever writes beside.
    program.write_text(
        '#!/bin/sh\npart=-\nfor word; do [ "$last" = --part ] && part=$word; last=$word; done\n'
        f'[ $part = - ] || echo "$part begun $PPID $(date +%s.%N)" >> {log}\n'
        f'while [ $part != - ] && [ -e {hold} ]; do sleep 0.05; done\n'
        f'{real} "$@"; status=$?\n[ $part = - ] || echo "$part done $PPID $(date +%s.%N)" >> {log}\nexit $status\n'
    )
    program.chmod(0o755)
    patch.setenv(_gen.VARIABLE, str(program))

    def parts() -> list[tuple[str, ...]]:
        lines = log.read_text().splitlines() if log.exists() else []
        return [tuple(line.split()) for line in lines]

    return parts


@pytest.fixture
def logged(tmp_path, monkeypatch):
    """What `log_gen` gives, for one test."""
    return log_gen(tmp_path, monkeypatch)


class Bucket:
    """A store on the loopback, and one bucket in it."""

    NAME = "planks"

    def __init__(self, port: int):
        self.endpoint = f"http://127.0.0.1:{port}"
        self.port = port

    def client(self, service: str = "s3", **keys):
        import botocore.session

        session = botocore.session.get_session()
        return session.create_client(
            service, endpoint_url=self.endpoint, region_name="us-east-1",
            aws_access_key_id=keys.get("key", KEYS["AWS_ACCESS_KEY_ID"]),
            aws_secret_access_key=keys.get("secret", KEYS["AWS_SECRET_ACCESS_KEY"]),
        )  # fmt: skip

    def empty(self) -> None:
        """A store without anything, in which everybody may do all, and one empty bucket."""
        self.let_everybody()
        self._ask("reset", b"")
        self.client().create_bucket(Bucket=self.NAME)

    def let_everybody(self) -> None:
        """From now on no request is asked for its keys."""
        self._ask("reset-auth", b"1000000000")

    def require_keys(self) -> None:
        """From now on each request needs the keys of a user whose policies allow it."""
        self._ask("reset-auth", b"0")

    def _ask(self, call: str, body: bytes) -> None:
        address, plain = f"{self.endpoint}/moto-api/{call}", {"Content-Type": "text/plain"}
        request = urllib.request.Request(address, body, plain, method="POST")
        urllib.request.urlopen(request).read()

    def files(self, folder: str) -> dict[str, bytes]:
        client, found = self.client(), {}
        for page in client.get_paginator("list_objects_v2").paginate(Bucket=self.NAME, Prefix=f"{folder}/"):
            for entry in page.get("Contents", []):
                body = client.get_object(Bucket=self.NAME, Key=entry["Key"])["Body"].read()
                found[entry["Key"].removeprefix(f"{folder}/")] = body
        return found

    def manifests(self, folder: str) -> set[int]:
        """Numbers of finished shards."""
        client, found = self.client(), set()
        for page in client.get_paginator("list_objects_v2").paginate(Bucket=self.NAME, Prefix=f"{folder}/shards/"):
            found |= {int(entry["Key"].rpartition("/")[2].removesuffix(".json")) for entry in page.get("Contents", [])}
        return found


@pytest.fixture(scope="session")
def store(tmp_path_factory):
    """A server that speaks S3."""
    if not SERVER.exists():
        pytest.fail(f"{SERVER} is missing: make its environment (python/requirements-moto.txt), or name it in SHEETLIGHT_MOTO")
    port = free_port()
    log = (tmp_path_factory.mktemp("store") / "log").open("wb")
    server = subprocess.Popen([SERVER, "-H", "127.0.0.1", "-p", str(port)], stdout=log, stderr=log)

    def answers() -> bool:
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", port)) == 0

    wait_until(answers)
    yield Bucket(port)
    server.terminate()
    server.wait()


@pytest.fixture
def bucket(store, monkeypatch):
    """An empty bucket, which the environment leads to."""
    store.empty()
    for name, value in KEYS.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setenv("AWS_ENDPOINT_URL", store.endpoint)
    forget_stores()
    yield store
    forget_stores()


class FaultyProxy:
    """A way to the store on which a share of the requests fails."""

    def __init__(self, target: int, share: float, seed: int, *options: str):
        self.port = free_port()
        script = Path(__file__).with_name("faulty_proxy.py")
        arguments = [sys.executable, script, *map(str, (self.port, target, share, seed)), *options]
        self.process = subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout.readline() == "ready\n"
        self.endpoint = f"http://127.0.0.1:{self.port}"

    def stop(self) -> dict[str, int]:
        """How many requests met which fault."""
        self.process.send_signal(signal.SIGTERM)
        said, _ = self.process.communicate(timeout=30)
        return json.loads(said)
