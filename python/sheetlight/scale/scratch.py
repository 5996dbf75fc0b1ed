"""Scratch folders of tasks. Those of tasks that were killed are removed by the next task on the machine."""

import contextlib
import os
import shutil
import socket
import tempfile
from collections.abc import Iterator
from pathlib import Path

from .errors import Interruption

try:
    import fcntl
except ImportError:  # no Linux, no macOS: what a killed task leaves stays
    fcntl = None

VARIABLE = "SHEETLIGHT_SCRATCH"
"""Environment variable that names the folder of scratch folders, where it is not said otherwise."""


@contextlib.contextmanager
def scratch_folder(base: str | os.PathLike[str] | None) -> Iterator[Path]:
    """An empty folder that is removed at the end.

    Args:
        base: where it lies; None for what SHEETLIGHT_SCRATCH names, or else the system's temporary folder

    Raises:
        Interruption: it cannot be made, or what is done within fails to read or write it.
    """
    base = Path(base or os.environ.get(VARIABLE) or tempfile.gettempdir(), f"sheetlight-{_user()}")
    lock = None
    try:
        base.mkdir(mode=0o700, parents=True, exist_ok=True)
        _sweep(base)
        folder = Path(tempfile.mkdtemp(prefix="task-", dir=base))
        lock = (folder / ".lock").open("wb")
        if fcntl is not None:
            fcntl.flock(lock, fcntl.LOCK_EX)
        place = folder / "dataset"
        place.mkdir()
    except OSError as fault:
        if lock is not None:
            lock.close()
        raise _told(base, fault) from None
    try:
        yield place
    except OSError as fault:
        raise _told(base, fault) from None
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        lock.close()


def _sweep(base: Path) -> None:
    """Removes the folders of tasks that no longer run: nobody holds their locks."""
    if fcntl is None:
        return
    for folder in base.glob("task-*"):
        try:
            with (folder / ".lock").open("rb") as lock:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                shutil.rmtree(folder, ignore_errors=True)
        except OSError:
            continue  # held by a task, or without its lock yet, or gone


def _told(base: Path, fault: OSError) -> Interruption:
    what = f"{base} on {socket.gethostname()}: cannot use it for scratch folders: {fault.strerror}"
    return Interruption(f"{what}; make room there, or name another folder (scratch, {VARIABLE})")


def _user() -> str:
    return str(os.getuid()) if hasattr(os, "getuid") else os.environ.get("USERNAME", "user")
