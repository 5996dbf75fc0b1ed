"""Sheetlight: laser triangulation scans with subsurface scattering, simulated.

    import sheetlight

    sample = sheetlight.Recipe.load("wood-small").sample(0)     # rendered in this process
    sample.range_mm, sample.scatter, sample.label               # NumPy arrays [rows, cols]
    sheetlight.generate("wood-small", 100, "out/boards")        # a dataset in a folder
    sheetlight.open("out/boards")[0].scatter                    # the same attributes, read

`sheetlight.torch` has datasets for PyTorch's DataLoader, `sheetlight.scale` makes datasets with many machines and in buckets,
`sheetlight.rerun` writes recordings for a viewer.
Lengths are in mm, angles in degrees, digital numbers (DN) as the camera gives them.
"""

import importlib.util
from typing import Any

if importlib.util.find_spec("sheetlight._sheetlight") is None:
    raise ImportError(
        f"{__path__[0]} is the package's source, without its compiled part: `pip install .` in the checkout builds and installs both; "
        "run Python elsewhere, or with -P, for it to be found"
    )

from sheetlight import _commands
from sheetlight._commands import *
from sheetlight._dataset import Dataset, open
from sheetlight._errors import DatasetError, RecipeError, RecipeFault, RecipeNotFoundError
from sheetlight._gen import GenError
from sheetlight._program import estimate, generate, report, validate
from sheetlight._recipe import Recipe, recipes
from sheetlight._result import Result
from sheetlight._sample import Sample
from sheetlight._sheetlight import version as __version__

__all__ = [
    "Dataset",
    "DatasetError",
    "GenError",
    "Recipe",
    "RecipeError",
    "RecipeFault",
    "RecipeNotFoundError",
    "Result",
    "Sample",
    "__version__",
    "estimate",
    "generate",
    "open",
    "recipes",
    "report",
    "validate",
]
__all__ += _commands.__all__


def __getattr__(name: str) -> Any:
    """The parts that bring more than NumPy, imported when they are asked for: `sheetlight.rerun`, `sheetlight.scale`, `sheetlight.torch`."""
    if name in ("rerun", "scale", "torch"):
        return importlib.import_module(f"sheetlight.{name}")
    raise AttributeError(f"module 'sheetlight' has no attribute {name!r}")
