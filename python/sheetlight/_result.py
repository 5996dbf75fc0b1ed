"""What a command found: a dict with attributes, as a table of Arrow, and in a notebook."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pyarrow

MOST_ROWS = 20
"""Entries of a list that a notebook shows."""


class Result(dict[str, Any]):
    """The JSON document of a command, by its keys: `result["warnings"]`, or `result.warnings` where dict has no such name."""

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"there is no {name!r} in it; it has {', '.join(self)}") from None

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self]

    def to_dict(self) -> dict[str, Any]:
        """A plain dict."""
        return dict(self)

    def to_arrow(self, key: str | None = None) -> pyarrow.Table:
        """The list of dicts under `key` as a table, a row each; without a key all of it as one row.

        Needs pyarrow (`pip install "sheetlight[arrow]"`).

        Raises:
            KeyError, TypeError: there is no such key, or no list of dicts under it.
        """
        from sheetlight._need import needed

        with needed("pyarrow", "arrow"):
            import pyarrow
        rows = [dict(self)] if key is None else self[key]
        if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
            raise TypeError(f"key: {key!r} is no list of dicts")
        return pyarrow.Table.from_pylist(rows)

    def _repr_html_(self) -> str:
        return as_html(self)


def as_html(value: Any) -> str:
    """A document as nested tables."""
    if isinstance(value, dict):
        rows = (f"<tr><th style='text-align:left'>{html.escape(str(key))}</th><td>{as_html(part)}</td></tr>" for key, part in value.items())
        return f"<table>{''.join(rows)}</table>"
    if isinstance(value, list):
        more = [f"and {len(value) - MOST_ROWS} more"] if len(value) > MOST_ROWS else []
        parts = [as_html(part) for part in [*value[:MOST_ROWS], *more]]
        return "<br>".join(parts) if any(isinstance(part, (dict, list)) for part in value) else ", ".join(parts)
    return html.escape(f"{value:.6g}" if isinstance(value, float) else "" if value is None else str(value))
