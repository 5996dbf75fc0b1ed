"""Makes python/sheetlight/_commands.py: a function for each command of `gen`, from the program's own declarations.

    python python/make_commands.py GEN            writes it
    python python/make_commands.py GEN --check    says whether it is what would be written

`generate`, `validate` and `report` have functions by hand in _program.py, whose arguments a test compares.
"""

import json
import keyword
import subprocess
import sys
import textwrap
from pathlib import Path

TARGET = Path(__file__).parent / "sheetlight" / "_commands.py"
BY_HAND = {"generate", "validate", "report"}
# Names that a command or an argument has here; others are those of the command line.
COMMANDS = {"list": "list_datasets"}
ARGUMENTS = {"dir": "folder", "dirs": "folders", "recipe_word": "recipe", "swept_recipe": "recipe", "set": "overrides"}
# Commands whose JSON is a list.
LISTS = [["list"], ["recipe", "list"], ["recipe", "presets"]]
TYPES = {"flag": "bool", "whole": "int", "number": "float", "path": "str | os.PathLike[str]", "text": "Words"}

HEAD = '''"""What the commands of `gen` do, as functions. Made by python/make_commands.py: change the command, not this file."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from sheetlight._recipe import Recipe
from sheetlight._result import Result
from sheetlight._run import Words, run_command

RecipeLike = Recipe | str | os.PathLike[str] | Mapping[str, Any]
"""A loaded recipe, what `Recipe.load` takes of a name, or a dict of it."""
'''


def declarations(gen):
    """Commands by path."""
    said = subprocess.run([gen, "schema", "commands"], check=True, capture_output=True, text=True).stdout
    return json.loads(said)


def function_name(command):
    name = "_".join(command["command"])
    return COMMANDS.get(name, name)


def parameters(command):
    """Arguments as Python has them, in order: those without an option first."""
    known = {}
    for argument in command["arguments"]:
        name = ARGUMENTS.get(argument["name"], argument["name"])
        if name == "json" or name in known and name == "recipe":
            continue
        known[name + "_" * keyword.iskeyword(name)] = argument
    return dict(sorted(known.items(), key=lambda item: (item[0] != "recipe" or not takes_recipe(command), item[1]["option"] is not None)))


def takes_recipe(command):
    """Whether the command's first word is a recipe."""
    return any(argument["name"] == "recipe_word" for argument in command["arguments"])


def annotation(name, argument):
    if name == "recipe":
        return "RecipeLike"
    if name == "overrides":
        return "Mapping[str, Any]"
    kind = f"Literal[{', '.join(json.dumps(word) for word in argument['words'])}]" if argument["words"] else TYPES[argument["type"]]
    return f"{kind} | Sequence[{kind}]" if argument["many"] else kind


def result(command):
    """What the function returns: its kind for `run_command`, the type, and words."""
    names = {argument["name"]: argument for argument in command["arguments"]}
    if "json" in names and command["command"] in LISTS:
        return "list", "list[Result]", "What the command prints with `--json`, an entry each."
    if "json" in names:
        return "json", "Result", "What the command prints with `--json`, as a dict with attributes."
    if command["command"] == ["transport"]:
        return "answer", "Result", "The answer, also where `out` takes it; a dict with attributes."
    if "out" in names:
        return "place", "Path", "Where it is."
    return "text", "str", "What it prints."


def words(text):
    text = " ".join((text or "").split())
    return text[:1].lower() + text[1:] if text[1:2].islower() or text[1:2] == " " else text


def function(command):
    """The source of a command's function."""
    given = parameters(command)
    kind, returns, what = result(command)
    first = [name for name, argument in given.items() if name == "recipe" and takes_recipe(command) or argument["option"] is None]
    signature, lines = [], []
    for name, argument in given.items():
        if name not in first and "*" not in signature:
            signature.append("*")
        typed = annotation(name, argument)
        if argument["required"] or name == "recipe" and takes_recipe(command):
            signature.append(f"{name}: {typed}")
        elif argument["type"] == "flag":
            signature.append(f"{name}: bool = False")
        else:
            signature.append(f"{name}: {typed} | None = None")
        default = f"; {', '.join(argument['default'])} where it is None" if argument["default"] else ""
        if name == "recipe":
            doc = "a loaded one, the name of a file or of a built-in one, the folder of a dataset, or a dict"
        elif name == "overrides":
            doc = "changes to the recipe, by the path of the key"
        else:
            doc = words(argument["doc"])
        lines += textwrap.wrap(f"{name}: {doc}{default}", 132, initial_indent=" " * 8, subsequent_indent=" " * 12, break_on_hyphens=False)
    about = " ".join(command["about"].split()).rstrip(".")
    places = [name for name in first if name != "recipe" or not takes_recipe(command)]
    options = [f'"{argument["option"]}": {name}' for name, argument in given.items() if argument["option"] and name not in ("recipe", "overrides")]
    paths = [name for name, argument in given.items() if argument["type"] == "path"]
    call = [json.dumps(kind), json.dumps(command["command"])]
    call += [f"places={{{', '.join(f'{json.dumps(name)}: {name}' for name in places)}}}"] if places else []
    call += [f"{name}={name}" for name in ("recipe", "overrides") if name in given]
    call += ["options={", *(f"    {part}," for part in options), "},"] if options else []
    call += [f"paths={json.dumps(paths)}"] if paths else []
    source = [f"def {function_name(command)}("]
    source += [f"    {part}," for part in signature] + [f") -> {returns}:"]
    source += [*textwrap.wrap(f'"""{about}.', 132, initial_indent="    ", subsequent_indent="    "), "", "    Args:", *lines, ""]
    source += ["    Returns:", f"        {what}", "", "    Raises:", "        GenError: in the program's words.", '    """']
    source += ["    return run_command("] + [f"        {part}" + "," * (part[-1] not in "{,") for part in call] + ["    )"]
    return "\n".join(source)


def module(commands):
    made = [command for command in commands if function_name(command) not in BY_HAND]
    names = ",\n    ".join(json.dumps(name) for name in sorted(map(function_name, made)))
    parts = [HEAD + f"\n__all__ = [\n    {names},\n]", *map(function, sorted(made, key=function_name))]
    return "\n\n\n".join(parts) + "\n"


def main():
    if len(sys.argv) < 2:
        raise SystemExit(__doc__)
    text = module(declarations(sys.argv[1]))
    if "--check" in sys.argv[2:]:
        if TARGET.read_text() != text:
            raise SystemExit(f"{TARGET} is not what the commands of {sys.argv[1]} declare: make bless")
        return
    TARGET.write_text(text)


if __name__ == "__main__":
    main()
