"""What runs the tasks. An engine is a module with a function `run`, which makes shards and yields what came of each."""

import importlib
from collections.abc import Generator, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from ..errors import Refusal

ENGINES = ("ray", "local")
"""Names of the engines, each a module here."""


@dataclass(frozen=True)
class Tasks:
    """The tasks of a run."""

    url: str
    """Where the dataset lies."""
    shards: list[int]
    """The shards to make."""
    threads: int
    """Threads of each task."""
    retries: int
    """How often a task is repeated at most."""
    scratch: str | None
    """Folder for scratch folders on the machine of the task."""
    options: Mapping[str, Any]
    """What only this engine understands."""


@dataclass(frozen=True)
class Outcome:
    """What came of a shard."""

    shard: int
    """Its number."""
    report: dict[str, Any] | None
    """What `make_shard` returned, or None where it was given up."""
    fault: str = ""
    """Why it was given up, in words."""


class Engine(Protocol):
    """What a module of an engine offers."""

    def run(self, tasks: Tasks) -> Generator[Outcome, None, None]:
        """Makes shards and yields as they are done. A Refusal stops all and is raised; shards whose retries are used up are
        outcomes with a fault. Stops what it started when the iterator is closed."""


def engine(name: str) -> Engine:
    """The engine of that name.

    Raises:
        Refusal: there is none, or what it needs is not installed.
    """
    if name not in ENGINES:
        raise Refusal(f"engine {name!r}: there is none; give one of {', '.join(ENGINES)}")
    try:
        return importlib.import_module(f"{__name__}.{name}")
    except ImportError as fault:
        raise Refusal(f"engine {name!r}: {fault}; pip install 'sheetlight[{name}]', or take engine=\"local\"") from None
