"""Arguments that several functions take: what they are, or an exception that names them."""

import operator
import os
import re
from typing import Any


def whole(name: str, value: Any, least: int | None = None) -> int:
    """A whole number, of Python or NumPy.

    Raises:
        TypeError: it is none.
        ValueError: it is below `least`.
    """
    try:
        if isinstance(value, bool):
            raise TypeError
        number = operator.index(value)
    except TypeError:
        raise TypeError(f"{name}: {value!r} is no whole number") from None
    if least is not None and number < least:
        raise ValueError(f"{name}: {number}: give {least} or more")
    return number


def thread_count(threads: Any) -> int | None:
    """Threads that were asked for, None for one a core; the most that a machine allows is known to the simulator."""
    if threads is None:
        return None
    threads = whole("threads", threads)
    if not 0 < threads < 2**32:
        raise ValueError(f"threads: {threads}: give 1 or more, or None for one a core")
    return threads


def is_url(place: str) -> bool:
    """Whether it is the URL of a store; a drive letter of Windows is no protocol."""
    protocol, separator, _ = place.partition("://")
    return bool(separator) and len(protocol) > 1


def local(name: str, place: str | os.PathLike[str], remedy: str) -> str:
    """A path on this machine.

    Raises:
        TypeError: it is no path.
        ValueError: it is empty, or a URL, also one that `pathlib` took a slash of; with the remedy for that.
    """
    try:
        path = os.fspath(place)
    except TypeError:
        raise TypeError(f"{name}: give a path, not {type(place).__name__}") from None
    if not path:
        raise ValueError(f"{name}: the path is empty; name a file or folder")
    if is_url(path) or re.match(r"[A-Za-z][A-Za-z0-9+.:-]+:/", path):
        raise ValueError(f"{name}: {path} is a URL; {remedy}")
    return path
