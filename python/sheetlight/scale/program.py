"""`gen` for the work of scaling out: its version, its runs in scratch folders, its faults in words that fit the place."""

import functools
import json
import os
import socket
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sheetlight import _gen

from .errors import Interruption, Refusal
from .scratch import scratch_folder
from .store import FULL

NO_SHARD = "100000/100001"
"""The part of a dataset that holds no shard, as a dataset has at most 100 000: `gen` begins it and renders nothing."""

USAGE = 2
"""Exit status of `gen` for arguments that cannot be used."""


def run(
    arguments: Sequence[str], scratch: Path, place: str, stop: _gen.Stop | None = None, text: str | None = None
) -> dict[str, Any]:
    """Runs `gen --json` in a scratch folder.

    Args:
        arguments: those after the program's name, without `--json`
        scratch: the folder, of which its messages speak as of `place`
        place: what it stands for, in words
        stop: what another thread may stop it by
        text: what it reads on standard input

    Returns:
        The document that it prints.

    Raises:
        Refusal: the arguments cannot be used.
        Interruption: it ended otherwise than well.
        OSError: the disk of the scratch folder is full, which `scratch_folder` tells.
    """
    try:
        return _gen.run_json(arguments, stop=stop, text=text)
    except _gen.GenError as fault:
        said = str(fault).replace(str(scratch), place).strip()
        if number := next((number for number in FULL if os.strerror(number) in said), None):
            raise OSError(number, os.strerror(number)) from None
        if fault.status in (USAGE, 0):  # 0 of a program that is no gen
            raise Refusal(said) from None
        raise Interruption(said) from None
    except OSError as fault:
        raise Refusal(f"{' '.join(_gen.command())}: gen cannot be started on {socket.gethostname()}: {fault}") from None


@functools.lru_cache
def _writer(command: tuple[str, ...], scratch: str | None) -> tuple[str, str]:
    """Version and target of `gen` on this machine, as it writes them into a dataset that it begins."""
    with scratch_folder(scratch) as folder:
        asked = ["--recipe", "wood-small", "--n", "1", "--part", NO_SHARD, "--out", str(folder)]
        try:
            run(asked, folder, f"a scratch folder on {socket.gethostname()}")
            head = json.loads((folder / "dataset.json").read_bytes())
            return head["generator"]["version"], head["target"]
        except (FileNotFoundError, ValueError, KeyError):
            raise no_gen() from None


def no_gen() -> Refusal:
    """The fault of a program that ends well and writes no dataset."""
    return Refusal(
        f"{' '.join(_gen.command())} on {socket.gethostname()} is no gen; install sheetlight again, or let {_gen.VARIABLE} "
        "name the program"
    )


def check_writer(head: dict[str, Any], url: str, scratch: str | os.PathLike[str] | None) -> None:
    """Refuses a dataset that another version of `gen` began, or one for other machines: its values may differ.

    Args:
        head: `dataset.json`
        url: where it lies
        scratch: as for `begin`

    Raises:
        Refusal: it is another one, or `gen` on this machine does not work.
        Interruption: it ended otherwise than well, or the scratch folder is full.
    """
    version, target = head["generator"]["version"], head["target"]
    here = _writer(tuple(_gen.command()), None if scratch is None else os.fspath(scratch))
    if here == (version, target):
        return
    remedy = f"install sheetlight {version}" if here[0] != version else "take machines of one kind"
    raise Refusal(
        f"{url}: gen {version} for {target} began this dataset, and {socket.gethostname()} has gen {here[0]} for {here[1]}, "
        f"whose values may differ; {remedy}, or choose another place"
    )
