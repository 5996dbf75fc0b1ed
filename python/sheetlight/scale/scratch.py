"""Scratch folders of tasks. Those of tasks that were killed are removed by the next task on the machine."""

import contextlib
import errno
import os
import shutil
import socket
import stat
import tempfile
from collections.abc import Iterator
from pathlib import Path

from .errors import Interruption, Refusal

try:
    import fcntl
except ImportError:  # no Linux, no macOS: what a killed task leaves stays
    fcntl = None  # type: ignore[assignment]

VARIABLE = "SHEETLIGHT_SCRATCH"
"""Environment variable that names the folder of scratch folders, where it is not said otherwise."""

NO_LOCKS = {errno.ENOSYS, errno.EOPNOTSUPP, errno.ENOTSUP, errno.ENOLCK}
"""Error numbers of file systems without locks: there, too, what a killed task leaves stays."""

LOCK_FLAGS = os.O_RDWR | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
"""How lock files are opened: only files of the folder itself, and nothing that waits for another program."""


@contextlib.contextmanager
def scratch_folder(base: str | os.PathLike[str] | None) -> Iterator[Path]:
    """An empty folder that is removed at the end.

    Args:
        base: where it lies; None for what SHEETLIGHT_SCRATCH names, or else the system's temporary folder

    Raises:
        Refusal: somebody else may read or change what lies there.
        Interruption: it cannot be made, or what is done within fails to read or write it.
    """
    base = Path(base or os.environ.get(VARIABLE) or tempfile.gettempdir(), f"sheetlight-{_user()}")
    try:
        base.parent.mkdir(parents=True, exist_ok=True)
        with contextlib.suppress(FileExistsError):
            base.mkdir(mode=0o700)
        _check_owner(base)
        _sweep(base)
        folder, lock = _own_folder(base)
    except OSError as fault:
        raise _told(base, fault) from None
    try:
        place = folder / "dataset"
        place.mkdir()
        yield place
    except OSError as fault:
        raise _told(base, fault) from None
    finally:
        _remove(folder, lock)


def _check_owner(base: Path) -> None:
    """Its name can be foretold, and anybody may have made it in a common folder."""
    if not hasattr(os, "getuid"):
        return
    found = os.lstat(base)
    if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid():
        what = "is no folder of this user"
    elif found.st_mode & 0o077:
        what = f"lets others in (mode {stat.S_IMODE(found.st_mode):o})"
    else:
        return
    raise Refusal(
        f"{base} on {socket.gethostname()}: {what}, and is not used for scratch folders; remove it, or name another folder "
        f"(--scratch, {VARIABLE})"
    )


def _own_folder(base: Path) -> tuple[Path, int]:
    """A new folder and its open lock file, which tells other tasks that somebody works there."""
    while True:
        folder = Path(tempfile.mkdtemp(prefix="task-", dir=base))
        lock = None
        try:
            lock = os.open(folder / ".lock", LOCK_FLAGS | os.O_CREAT | os.O_EXCL, 0o600)
            _lock(lock)
            # Before it was locked another task may have taken it for the folder of a killed one.
            if (folder / ".lock").exists():
                return folder, lock
        except BaseException:
            _remove(folder, lock)
            raise
        _remove(folder, lock)


def _remove(folder: Path, lock: int | None) -> None:
    # Windows removes no file that is open; elsewhere another task may help once it is unlocked.
    if lock is not None:
        os.close(lock)
    shutil.rmtree(folder, ignore_errors=True)


def _lock(lock: int) -> None:
    if fcntl is None:
        return
    try:
        fcntl.flock(lock, fcntl.LOCK_EX)
    except OSError as fault:
        if fault.errno not in NO_LOCKS:
            raise


def _sweep(base: Path) -> None:
    """Removes the folders of tasks that no longer run: nobody holds their locks."""
    if fcntl is None:
        return
    for folder in base.glob("task-*"):
        try:
            lock = os.open(folder / ".lock", LOCK_FLAGS)
        except OSError:
            continue  # without its lock yet, or gone
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            shutil.rmtree(folder, ignore_errors=True)
        except OSError:
            pass  # held by a task, or a file system without locks
        finally:
            os.close(lock)


def _told(base: Path, fault: OSError) -> Interruption:
    what = f"{base} on {socket.gethostname()}: cannot use it for scratch folders: {fault.strerror}"
    return Interruption(f"{what}; make room there, or name another folder (--scratch, {VARIABLE})")


def _user() -> str:
    return str(os.getuid()) if hasattr(os, "getuid") else os.environ.get("USERNAME", "user")
