"""Recipes, and the samples that they make in this process."""

from __future__ import annotations

import functools
import html
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from sheetlight import _sheetlight
from sheetlight._arguments import local, thread_count, whole
from sheetlight._gen import override_text
from sheetlight._sample import Facts, Sample

MOST_SAMPLES = 100_000_000
"""Samples of the largest dataset, and of the largest range."""


class Recipe:
    """What samples are drawn from; get one by `Recipe.load`.

    A sample follows from recipe, seed, its number and the version of the package alone: threads, processes and the order in which
    samples are asked for make no difference.
    """

    _name: str
    _text: str | None
    _overrides: list[tuple[str, str]]
    _recipe: _sheetlight.Recipe

    def __init__(self) -> None:
        raise TypeError("recipes are made by Recipe.load(name)")

    @classmethod
    def load(
        cls, name: str | os.PathLike[str] | Mapping[str, Any], overrides: Mapping[str, Any] | None = None, /, **sections: Any
    ) -> Recipe:
        """The recipe in a YAML file, a built-in one (`recipes()` lists them), that of a dataset in a folder, or a dict.

        >>> import sheetlight
        >>> sheetlight.Recipe.load("wood-small", {"camera.tilt_deg": 30}).name
        'wood-small'
        >>> recipe = sheetlight.Recipe.load("wood-small", scan={"columns": 128, "profiles": 64})
        >>> recipe.shape
        (64, 128)

        Args:
            name: path of a file, name of a built-in recipe, path of a dataset's folder, or what a recipe's YAML says as a dict
            overrides: values that replace those of the recipe, by the path of the key: {"camera.tilt_deg": 30}. A value is a number,
                a text, a list, or a distribution such as {"uniform": [20, 30]}.
            **sections: the same by section: camera={"tilt_deg": 30}

        Raises:
            RecipeError: the recipe has faults; `faults` lists them with line, key and remedy.
            RecipeNotFoundError: nothing has that name.
            DatasetError: the folder holds no dataset that can be read.
            TypeError, ValueError: the name is empty or a URL, or an override is nothing that a recipe can hold.
        """
        changes = _all_changes(overrides, sections)
        if isinstance(name, Mapping):
            return cls._load("-", _texts(changes), text=override_text("recipe", dict(name)))
        name = local("name", name, "copy the recipe to this machine")
        # Where the working directory changes, or a worker has another one, it is the same file.
        path = Path(name)
        if path.exists():
            name = str(path.absolute())
        return cls._load(name, _texts(changes))

    @classmethod
    def from_yaml(cls, text: str, overrides: Mapping[str, Any] | None = None, /, **sections: Any) -> Recipe:
        """The recipe of a text in YAML; files that it names lie in the working directory.

        >>> import sheetlight
        >>> sheetlight.Recipe.from_yaml("name: mine\\nextends: wood-small").name
        'mine'

        Args:
            text: the text
            overrides, **sections: as for `load`

        Raises:
            RecipeError: the recipe has faults; `faults` lists them with line, key and remedy.
            TypeError: it is no text.
        """
        if not isinstance(text, str):
            raise TypeError(f"text: give the text of a recipe, not {type(text).__name__}")
        return cls._load("-", _texts(_all_changes(overrides, sections)), text=text)

    @classmethod
    def _load(cls, name: str, overrides: list[tuple[str, str]], content: str | None = None, text: str | None = None) -> Recipe:
        self = object.__new__(cls)
        self._name, self._overrides, self._text = name, overrides, text
        self._recipe = _sheetlight.Recipe.load(name, overrides) if text is None else _sheetlight.Recipe.parse(text, overrides)
        if content not in (None, self.hash):
            raise ValueError(f"the recipe {name} has changed since it was loaded; load it again")
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return Recipe._load, (self._name, self._overrides, self.hash, self._text)

    def __eq__(self, other: object) -> bool:
        """Whether both make the same samples."""
        if not isinstance(other, Recipe):
            return NotImplemented
        return (self.hash, self.seed) == (other.hash, other.seed)

    def __hash__(self) -> int:
        return hash((self.hash, self.seed))

    def __repr__(self) -> str:
        rows, cols = self.shape
        return f"<Recipe {self.name}: {self.subject}, {rows} x {cols} px, {self.hash[:12]}>"

    def _repr_html_(self) -> str:
        from sheetlight._commands import rig
        from sheetlight._result import as_html

        said = rig(self)
        shown = {"numbers": said["numbers"], "warnings": said["warnings"]}
        return f"<div>{html.escape(repr(self))}</div>{as_html(shown)}"

    @property
    def name(self) -> str:
        """Name of its datasets."""
        return self._recipe.name

    @functools.cached_property
    def hash(self) -> str:
        """SHA-256 of what it means, in hexadecimal: comments, order and spelling leave it as it is."""
        return self._recipe.hash

    @property
    def subject(self) -> str:
        """What the objects are: "wood", "blister", "sawtooth" or "mesh"."""
        return self._recipe.subject

    @property
    def text(self) -> str:
        """Its text in YAML; overrides are in its section `set`."""
        return self._recipe.text

    @functools.cached_property
    def canonical(self) -> dict[str, Any]:
        """Everything that it means, defaults included."""
        return json.loads(self._recipe.canonical())

    @property
    def notes(self) -> list[str]:
        """Keys that have no effect, each with its reason and what to do."""
        return self._recipe.notes

    @property
    def classes(self) -> list[str]:
        """Names of the classes that samples are drawn from."""
        return self._facts.head["classes"]

    @property
    def pixel_classes(self) -> list[str]:
        """Names of the classes of pixels; the position is the value in `Sample.label`."""
        return self._facts.head["pixel_classes"]

    @property
    def shape(self) -> tuple[int, int]:
        """Rows (along the scan) and columns (along the laser line) of the maps [px]."""
        images = self._facts.head["images"]
        return images["rows"], images["cols"]

    @property
    def size(self) -> dict[str, int]:
        """What is exposed: `profiles`, sensor `columns` and sensor `rows` [px]; the maps are smaller where the recipe bins them."""
        images = self._facts.head["images"]
        profiles = self.canonical["scan"]["profiles"]
        return {"profiles": profiles, "columns": images["sensor_cols"], "rows": images["sensor_rows"]}

    @functools.cached_property
    def _facts(self) -> Facts:
        return Facts(json.loads(self._recipe.head(0)))

    @property
    def seed(self) -> int:
        """Seed of the dataset that it was loaded from, else 0: samples are drawn with it unless another one is given."""
        return self._recipe.dataset_seed or 0

    def sample(self, index: int, seed: int | None = None, *, threads: int | None = None, dark: bool = True) -> Sample:
        """Renders a sample.

        >>> import sheetlight
        >>> recipe = sheetlight.Recipe.load("wood-small", scan={"columns": 128, "profiles": 64})
        >>> sample = recipe.sample(3)
        >>> sample.scatter.shape, sample.scatter.dtype.name, sample.class_name in recipe.classes
        ((64, 128), 'float32', True)

        Args:
            index: number of the sample, from 0
            seed: seed of all draws; None for `self.seed`
            threads: threads that render it; None for one a core
            dark: whether Reflectance and Scatter keep the sensor's dark level, as the camera and datasets have it

        Raises:
            IndexError: there is no sample of that number.
            TypeError, ValueError: an argument is no such number.
            MemoryError: it does not fit.

        Ctrl-C stops it; other Python threads go on meanwhile.
        """
        index = _number("index", index)
        return Sample(self._recipe.sample(index, self._seed(seed), thread_count(threads)), self._facts, dark=dark)

    def samples(
        self, numbers: int | range, seed: int | None = None, *, threads: int | None = None, dark: bool = True
    ) -> Iterator[Sample]:
        """Renders samples one after the other, several side by side; a few for each thread are made ahead.

        >>> import sheetlight
        >>> recipe = sheetlight.Recipe.load("wood-small", scan={"columns": 128, "profiles": 64})
        >>> [sample.index for sample in recipe.samples(range(2, 8, 2))]
        [2, 4, 6]

        Args:
            numbers: their numbers as a range, or how many from 0 on
            seed, threads, dark: as for `sample`
        """
        if not isinstance(numbers, range):
            try:
                count = whole("numbers", numbers)
            except TypeError:
                raise TypeError(f"numbers: give a range or how many, not {type(numbers).__name__}") from None
            if count < 0:
                raise IndexError(f"numbers: {count}: give how many, 0 or more, or a range")
            numbers = range(count)
        if numbers:
            _number("numbers", min(numbers[0], numbers[-1]))
            _number("numbers", max(numbers[0], numbers[-1]))
        first = numbers.start if numbers else 0
        rendered = self._recipe.samples((first, numbers.step, len(numbers)), self._seed(seed), thread_count(threads))
        return (Sample(sample, self._facts, dark=dark) for sample in rendered)

    def _seed(self, seed: int | None) -> int:
        if seed is None:
            return self.seed
        seed = whole("seed", seed)
        if not 0 <= seed < 2**64:
            raise ValueError(f"seed: {seed} is none, these are 0 to 2^64 - 1")
        return seed


def recipes() -> dict[str, str]:
    """The built-in recipes: what each is, in a few words, by name.

    >>> import sheetlight
    >>> sheetlight.recipes()["wood-small"]
    'a small one to try things with'
    """
    return dict(_sheetlight.built_in_recipes())


def _number(name: str, index: int) -> int:
    index = whole(name, index)
    if not 0 <= index < MOST_SAMPLES:
        raise IndexError(f"{name}: {index} is no number of a sample, these are 0 to {MOST_SAMPLES - 1}")
    return index


def _changes(overrides: Mapping[str, Any] | None) -> dict[str, Any]:
    """Changes by the path of the key."""
    if not isinstance(overrides, Mapping | None):
        raise TypeError(f"overrides: give a mapping such as {{'camera.tilt_deg': 30}}, not {type(overrides).__name__}")
    return dict(overrides or {})


def _all_changes(overrides: Mapping[str, Any] | None, sections: Mapping[str, Any]) -> dict[str, Any]:
    """Changes by the path of the key, those by section too."""
    changes = _changes(overrides)
    for section, values in sections.items():
        if isinstance(values, Mapping):
            changes.update({f"{section}.{key}": value for key, value in values.items()})
        else:
            changes[section] = values
    return changes


def _texts(overrides: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Changes as keys and values in YAML."""
    for key in overrides:
        if not isinstance(key, str):
            raise TypeError(f"overrides: {key!r} is no key; give the path of one as a text, such as 'camera.tilt_deg'")
    return [(key, override_text(key, value)) for key, value in overrides.items()]


def reload_arguments(
    recipe: Recipe | str | os.PathLike[str], overrides: Mapping[str, Any] | None
) -> tuple[Iterable[str], str | None]:
    """What tells `gen` of a recipe: --recipe and --set, and what it reads on standard input."""
    said = None
    if isinstance(recipe, Recipe):
        # The program reads the file again: refused where that means something else by now.
        name, said = recipe._name, recipe._text
        texts = list(Recipe._load(name, recipe._overrides, recipe.hash, said)._overrides)
    else:
        name, texts = os.fspath(recipe), []
    texts += _texts(_changes(overrides))
    return ["--recipe", name, *(word for key, text in texts for word in ("--set", f"{key}={text}"))], said
