"""What goes wrong, told apart by whether trying again helps."""

import operator
from typing import Any


class ScaleError(RuntimeError):
    """Base of what this package raises; the message says where, what, and what to do.

    Attributes:
        status: exit status of `python -m sheetlight.scale` when it ends with this fault
    """

    status = 1


class Refusal(ScaleError):
    """Trying again changes nothing: wrong credentials, no such bucket, another dataset at the place, another version."""

    status = 2


class Interruption(ScaleError):
    """Trying again may help: a store that did not answer, a full scratch disk, a program that was killed."""


class Unfinished(Interruption):
    """Shards are missing.

    Attributes:
        missing: their numbers, ascending
    """

    def __init__(self, message: str, missing: list[int]):
        super().__init__(message, missing)
        self.missing = missing

    def __str__(self) -> str:
        return self.args[0]


def check_number(name: str, value: Any, least: int) -> int:
    """The whole number that somebody gave.

    Raises:
        Refusal: it is none, or below `least`.
    """
    try:
        number = operator.index(value)
    except TypeError:
        number = least - 1
    if number < least:
        raise Refusal(f"{name} {value!r}: give a whole number, {least} or more")
    return number
