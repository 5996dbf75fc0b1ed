"""Scratch folders: removed at the end or by the next task, of this user alone, on file systems without locks too."""

import errno
import fcntl
import os
import subprocess
import sys

import pytest
from conftest import wait_until
from sheetlight.scale import Interruption, Refusal, scratch
from sheetlight.scale.scratch import scratch_folder


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
def base(tmp_path):
    """The folder that holds the scratch folders of this user in `tmp_path`."""
    with scratch_folder(tmp_path) as folder:
        return folder.parents[1]


def test_what_others_may_have_made_is_refused(tmp_path, base):
    """The name can be foretold, and anybody may make it in a common folder."""
    assert base.name == f"sheetlight-{os.getuid()}" and base.stat().st_mode & 0o777 == 0o700
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir(mode=0o700)

    def refused(words):
        with pytest.raises(Refusal, match=f"{base} on .*: {words}.*; remove it, or name another folder"):
            with scratch_folder(tmp_path):
                pass
        assert list(elsewhere.iterdir()) == []

    for mode in (0o770, 0o707, 0o710):
        base.chmod(mode)
        refused(f"lets others in \\(mode {mode:o}\\)")
    base.chmod(0o700)
    if os.getuid() == 0:  # only root may give it away
        os.chown(base, 65534, 65534)
        refused("is no folder of this user")
    base.rmdir()
    base.symlink_to(elsewhere, target_is_directory=True)
    refused("is no folder of this user")
    base.unlink()
    base.write_text("")
    refused("is no folder of this user")


def test_locks_that_are_no_files_stop_nobody(tmp_path, base):
    """A link is not followed, a pipe is not waited for."""
    outside = tmp_path / "outside"
    outside.write_text("mine")
    for name in ("task-link", "task-pipe"):
        (base / name).mkdir()
    (base / "task-link" / ".lock").symlink_to(outside)
    os.mkfifo(base / "task-pipe" / ".lock")
    script = "import sys, sheetlight.scale.scratch as s\nwith s.scratch_folder(sys.argv[1]) as folder: print(folder.is_dir())"
    said = subprocess.run([sys.executable, "-c", script, tmp_path], capture_output=True, text=True, timeout=60, check=True)
    assert said.stdout == "True\n"
    assert outside.read_text() == "mine" and (base / "task-link").is_dir()


def test_a_folder_that_is_swept_before_it_is_locked(tmp_path, base, monkeypatch):
    """Between the making of the lock file and the lock another task comes along: another folder is made, and it stays."""
    real, swept = fcntl.flock, []

    def flock(lock, how):
        if how == fcntl.LOCK_EX and len(swept) < 3:
            with monkeypatch.context() as patch:
                patch.setattr(fcntl, "flock", real)
                before = set(base.iterdir())
                scratch._sweep(base)
                swept.append(before - set(base.iterdir()))
        real(lock, how)

    monkeypatch.setattr(fcntl, "flock", flock)
    with scratch_folder(tmp_path) as folder:
        assert [len(gone) for gone in swept] == [1, 1, 1]
        (folder / "file").write_text("x")
        scratch._sweep(base)
        assert (folder / "file").read_text() == "x"
    assert list(base.iterdir()) == []


def test_file_systems_without_locks(tmp_path, base, monkeypatch):
    """It works there, and removes what it made; a fault of another kind is told and leaves nothing either."""
    number = 0

    def flock(*_):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(fcntl, "flock", flock)
    for number in (errno.ENOSYS, errno.EOPNOTSUPP, errno.ENOLCK):
        with scratch_folder(tmp_path) as first, scratch_folder(tmp_path) as second:
            assert first != second and first.is_dir() and second.is_dir()
        assert list(base.iterdir()) == []
    number = errno.EIO
    with pytest.raises(Interruption, match="cannot use it for scratch folders: Input/output error"):
        with scratch_folder(tmp_path):
            pass
    assert list(base.iterdir()) == []
