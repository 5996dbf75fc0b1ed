"""Pictures of samples: maps side by side as PNG, without a library, and as a figure of matplotlib."""

from __future__ import annotations

import base64
import contextlib
import struct
import tempfile
import webbrowser
import zlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sheetlight import _sheetlight

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sheetlight._sample import Sample

SHOWN = ("range_mm", "range_px", "reflectance", "scatter", "grey", "label")
"""Maps that a picture shows, where a sample has them."""
MOST_PIXELS = 480
"""Longest side of a map in a picture of several [px]."""
ENDS = (1.0, 99.0)
"""What is black and what is white in a grey picture [%]."""
GAP = 4
"""White between two maps [px]."""


def shown(sample: Sample, maps: list[str] | None) -> list[str]:
    """Names of the maps to show.

    Raises:
        ValueError: the sample has none of that name.
    """
    if maps is None:
        return [name for name in SHOWN if name in sample.maps]
    unknown = [name for name in maps if name not in sample.maps]
    if unknown:
        raise ValueError(f"maps: {', '.join(unknown)}; the sample has {', '.join(sample.maps)}")
    return list(maps)


def ends(sample: Sample, name: str) -> tuple[float, float]:
    """Where the grey of a map begins and ends: at those per cents of what shows the object, or of all where nothing tells."""
    pixels = sample.maps[name]
    seen = np.isfinite(pixels)
    if "label" in sample.maps and (on := seen & (sample.maps["label"] > 0)).any():
        seen = on
    low, high = np.percentile(pixels[seen], ENDS) if seen.any() else (0.0, 1.0)
    return float(low), float(high)


def coloured(sample: Sample, name: str) -> NDArray[np.uint8]:
    """A map as red, green and blue: labels in the colours of previews, numbers as grey, missing ones black."""
    pixels = sample.maps[name]
    if name in ("label", "instance"):
        palette = np.array([list(_sheetlight.class_colour(number % 64)) for number in range(256)], np.uint8)
        return palette[pixels.astype(np.intp) & 255]
    (low, high), seen = ends(sample, name), np.isfinite(pixels)
    grey = np.clip((np.where(seen, pixels, low) - low) / max(high - low, 1e-12), 0.0, 1.0) * 254.0 + 1.0
    return np.repeat(np.where(seen, grey, 0.0).astype(np.uint8)[..., None], 3, axis=2)


def picture(sample: Sample, maps: list[str] | None = None) -> bytes:
    """Maps side by side as PNG, every k-th pixel of them where they are large."""
    step = max(1, -(-max(sample.shape) // MOST_PIXELS))
    panels = [coloured(sample, name)[::step, ::step] for name in shown(sample, maps)]
    if not panels:
        raise ValueError(f"{sample!r} has no maps to show")
    white = np.full((panels[0].shape[0], GAP, 3), 255, np.uint8)
    parts = [part for panel in panels for part in (white, panel)][1:]
    return png(np.concatenate(parts, axis=1))


def png(pixels: NDArray[np.uint8]) -> bytes:
    """An image `[rows, cols, 3]` as PNG."""

    def chunk(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    rows, cols, _ = pixels.shape
    lines = np.zeros((rows, 1 + 3 * cols), np.uint8)
    lines[:, 1:] = pixels.reshape(rows, -1)
    head = struct.pack(">IIBBBBB", cols, rows, 8, 2, 0, 0, 0)
    body = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(lines.tobytes())) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + body


def as_html(sample: Sample, maps: list[str] | None = None) -> str:
    """The picture as an element of a page, with the names of its maps."""
    names = shown(sample, maps)
    if not names:
        return ""
    data = base64.b64encode(picture(sample, maps)).decode()
    return f'<div>{" | ".join(names)}</div><img alt="{", ".join(names)}" src="data:image/png;base64,{data}">'


def show(sample: Sample, maps: list[str] | None) -> None:
    """In a notebook below the cell, else as a file in the browser."""
    with contextlib.suppress(ModuleNotFoundError, NameError):
        from IPython import get_ipython

        if get_ipython() is not None:
            from IPython.display import HTML, display

            display(HTML(as_html(sample, maps)))
            return
    place = Path(tempfile.mkdtemp(prefix="sheetlight-")) / f"sample-{sample.index}.png"
    place.write_bytes(picture(sample, maps))
    if not webbrowser.open(place.as_uri()):
        print(place)


def plot(sample: Sample, maps: list[str] | None = None) -> Figure:
    """Maps as a figure in mm, with scales; labels with the names of their classes."""
    from sheetlight._need import needed

    with needed("matplotlib", "plot"):
        from matplotlib.colors import BoundaryNorm, ListedColormap
        from matplotlib.figure import Figure

    names = shown(sample, maps)
    rows, cols = sample.shape
    extent = (0.0, cols * sample.col_mm, rows * sample.row_mm, 0.0)
    figure = Figure(figsize=(4.0 * len(names), 4.0), layout="constrained")
    for axes, name in zip(np.atleast_1d(figure.subplots(1, len(names))), names, strict=True):
        pixels = sample.maps[name]
        if name == "label":
            values = [int(value) for value in np.unique(pixels)]
            colours = [tuple(part / 255 for part in _sheetlight.class_colour(value)) for value in values]
            norm = BoundaryNorm([*(value - 0.5 for value in values), values[-1] + 0.5], len(values))
            image = axes.imshow(pixels, cmap=ListedColormap(colours), norm=norm, extent=extent, interpolation="nearest")
            scale = figure.colorbar(image, ax=axes, ticks=values)
            scale.set_ticklabels([sample.pixel_classes[value] for value in values])
        else:
            low, high = ends(sample, name)
            image = axes.imshow(pixels, vmin=low, vmax=high, extent=extent, interpolation="nearest")
            figure.colorbar(image, ax=axes)
        axes.set_title(name)
        axes.set_xlabel("mm along the line")
        axes.set_ylabel("mm along the scan")
    return figure
