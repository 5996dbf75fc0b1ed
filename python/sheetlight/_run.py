"""Calls of commands of `gen`: arguments of Python as those of the command line, and what comes back."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sheetlight import _gen
from sheetlight._arguments import local
from sheetlight._recipe import Recipe, reload_arguments
from sheetlight._result import Result

Words = str | int | float | Sequence[float]
"""What the command line takes as a word: numbers are joined by commas."""

HERE = "name a file or folder on this machine"
"""What to do with a URL."""


def run_command(
    kind: str,
    command: list[str],
    *,
    places: Mapping[str, Any] | None = None,
    recipe: Any = None,
    overrides: Mapping[str, Any] | None = None,
    options: Mapping[str, Any] | None = None,
    paths: Sequence[str] = (),
) -> Any:
    """Runs a command.

    Args:
        kind: what comes back: "json" and "answer" a Result, "list" a list of them, "place" the path of what was written, "text" what was printed
        command: its name, in words
        places: arguments without an option, by their names
        recipe, overrides: as `Recipe.load` takes them
        options: values by option; None and False leave one out, True is a flag, a list is given one by one
        paths: names of arguments that are paths
    """
    arguments, given = list(command), dict(options or {})
    for name, value in (places or {}).items():
        arguments += [_word(name, each, name in paths) for each in _each(value)]
    text = None
    if recipe is not None:
        if isinstance(recipe, Mapping):
            recipe = Recipe.load(recipe)
        if not isinstance(recipe, Recipe):
            recipe = local("recipe", recipe, "copy the recipe to this machine")
        of_recipe, text = reload_arguments(recipe, overrides)
        arguments += of_recipe
    elif overrides:
        arguments += _gen.set_arguments(dict(overrides))
    for option, value in given.items():
        name = option.removeprefix("--").replace("-", "_")
        if value is True:
            arguments.append(option)
        elif value is not None and value is not False:
            # With the sign between them a value may begin with a dash.
            arguments += [f"{option}={_word(name, each, name in paths)}" for each in _each(value)]
    if kind == "json":
        return Result(_gen.run_json(arguments, text=text))
    if kind == "list":
        return [Result(entry) for entry in _gen.run_json(arguments, list, text=text)]
    said = _gen.run(arguments, text=text)
    if kind == "answer":
        out = given.get("--out")
        return Result(json.loads(said if out is None else Path(out).read_text()))
    if kind == "place":
        out = given.get("--out")
        return Path(_DEFAULT_PLACES[command[0]] if out is None else os.fspath(out))
    return said


_DEFAULT_PLACES = {"preview": "preview.png", "study": "out/study"}


def _each(value: Any) -> Sequence[Any]:
    """Values of an argument that may have several; numbers in a list are one word."""
    if value is None:
        return ()
    several = isinstance(value, Sequence) and not isinstance(value, (str, bytes))
    return value if several and not all(isinstance(part, (int, float)) for part in value) else (value,)


def _word(name: str, value: Any, is_path: bool) -> str:
    if is_path:
        return local(name, value, HERE)
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ",".join(_word(name, part, False) for part in value)
    if isinstance(value, str):
        return value
    if isinstance(value, bool) or not isinstance(value, (int, float)) and not hasattr(value, "__float__"):
        raise TypeError(f"{name}: give a number or a text, not {type(value).__name__}")
    return repr(value.item() if hasattr(value, "item") else value)
