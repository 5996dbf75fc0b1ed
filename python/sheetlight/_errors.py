"""Exceptions of the package, beside `GenError` of the program."""

from typing import NamedTuple


class RecipeFault(NamedTuple):
    """One fault of a recipe."""

    place: tuple[int, int] | None
    """Line and column in its text, from 1; None for a change (an override)."""
    key: str
    """Path of the key, such as `camera.tilt_deg`; empty for the whole text."""
    problem: str
    """What is wrong."""
    remedy: str
    """What is allowed, or what to do."""
    file: str | None = None
    """The recipe that it stands in, where that is one that the text extends."""


class RecipeError(ValueError):
    """A recipe with faults, all of them at once; the message shows each with its line.

    Attributes:
        faults: the faults by place, each with place, key, problem, remedy and file
    """

    def __init__(self, message: str, faults: list[tuple[tuple[int, int] | None, str, str, str, str | None]]):
        super().__init__(message, faults)
        self.faults = [RecipeFault(*fault) for fault in faults]

    def __str__(self) -> str:
        return self.args[0]


class RecipeNotFoundError(FileNotFoundError):
    """Neither a file nor a built-in recipe has that name; the message lists those that are built in."""


class DatasetError(ValueError):
    """A dataset that cannot be read, or a sample that it does not have: where, what, and what to do."""
