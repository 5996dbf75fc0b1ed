"""`gen` for the work of scaling out: its version, its runs in scratch folders, its faults in words that fit the place."""

import functools
import socket
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sheetlight import _gen

from .errors import Interruption, Refusal

USAGE = 2
"""Exit status of `gen` for arguments that cannot be used."""


def run(arguments: Sequence[str], scratch: Path, place: str) -> dict[str, Any]:
    """Runs `gen --json` in a scratch folder.

    Args:
        arguments: those after the program's name, without `--json`
        scratch: the folder, of which its messages speak as of `place`

    Returns:
        The document that it prints.

    Raises:
        Refusal: the arguments cannot be used.
        Interruption: it ended otherwise than well.
    """
    try:
        return _gen.run_json(arguments)
    except _gen.GenError as fault:
        said = str(fault).replace(str(scratch), place).strip()
        if fault.status == USAGE:
            raise Refusal(said) from None
        raise Interruption(said) from None
    except OSError as fault:
        raise Refusal(f"{' '.join(_gen.command())}: gen cannot be started on {socket.gethostname()}: {fault}") from None


def version() -> str:
    """The version of `gen` on this machine, for instance "0.2.0"."""
    return _version(tuple(_gen.command()))


@functools.lru_cache
def _version(_command: tuple[str, ...]) -> str:
    try:
        return _gen.run(["--version"]).split()[-1]
    except OSError as fault:
        raise Refusal(f"gen cannot be started on {socket.gethostname()}: {fault}") from None


def check_version(head: dict[str, Any], url: str) -> None:
    """Refuses a dataset that another version of `gen` began: its values may differ.

    Args:
        head: `dataset.json`
        url: where it lies
    """
    begun, here = head["generator"]["version"], version()
    if here != begun:
        raise Refusal(
            f"{url}: gen {begun} began this dataset, and {socket.gethostname()} has gen {here}; install sheetlight {begun} "
            "there, or choose another place"
        )
