"""Packages that are only needed for a part of this one."""

import contextlib
from collections.abc import Iterator


@contextlib.contextmanager
def needed(package: str, extra: str) -> Iterator[None]:
    """Around an import: says how to get a package that is missing."""
    try:
        yield
    except ModuleNotFoundError as missing:
        if missing.name is None or missing.name.partition(".")[0] != package:
            raise
        raise ModuleNotFoundError(
            f'the package {package} is missing: pip install "sheetlight[{extra}]"', name=package
        ) from None
