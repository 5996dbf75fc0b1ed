"""Samples as a recording for the viewer Rerun: maps, labels, boxes, and points in mm.

    import sheetlight, sheetlight.rerun

    sheetlight.rerun.save(sheetlight.open("out/boards"), "boards.rrd")     # then: rerun boards.rrd

The timeline `sample` has the number of each sample. Entities:

- `scan/range`, `scan/reflectance`, `scan/scatter`, `scan/grey`: measured maps, float32, 0 where missing
- `scan/label`, `scan/instance`: what pixels really show, with the names of the classes
- `scan/objects`: boxes of the objects, with class and state
- `points`: x along the laser line, y along the scan, z upwards [mm], as bright as Reflectance
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from sheetlight._arguments import local
from sheetlight._need import needed
from sheetlight._sample import Sample

with needed("rerun", "rerun"):
    import rerun

if TYPE_CHECKING:
    from numpy.typing import NDArray

IMAGES = ("reflectance", "scatter", "grey")
"""Maps of light."""


def save(samples: Iterable[Sample], path: str | os.PathLike[str], *, points: bool = True) -> None:
    """Writes samples into a recording, one after the other: memory holds one.

    Args:
        samples: a dataset, a list, or what `Recipe.samples` gives
        path: file on this machine, which is replaced; Rerun wants the ending .rrd
        points: False leaves the points out: 16 bytes for each measured pixel

    Raises:
        ValueError: there is no sample.
    """
    path = local("path", path, "save it on this machine")
    recording = rerun.RecordingStream("sheetlight")
    recording.save(path)
    count = 0
    for sample in samples:
        log(sample, recording, points=points)
        count += 1
    recording.flush()
    recording.disconnect()
    if count == 0:
        os.remove(path)
        raise ValueError("samples: there is none")


def log(sample: Sample, recording: Any = None, *, points: bool = True) -> None:
    """Logs one sample to a recording of Rerun, or to the one that `rerun.init` has made."""
    rerun.set_time("sample", sequence=sample.index, recording=recording)
    maps = sample.maps
    classes = [(value, name) for value, name in enumerate(sample.pixel_classes)]
    rerun.log("scan", rerun.AnnotationContext(classes), static=True, recording=recording)
    heights = next((maps[name] for name in ("range_mm", "range_px") if name in maps), None)
    if heights is not None:
        # A metre has 1000 mm; sensor rows have no length.
        metre = 1000.0 if "range_mm" in maps else None
        rerun.log("scan/range", rerun.DepthImage(_filled(heights), meter=metre), recording=recording)
    for name in IMAGES:
        if name in maps:
            rerun.log(f"scan/{name}", rerun.Image(_filled(maps[name]), color_model="L"), recording=recording)
    for name in ("label", "instance"):
        if name in maps:
            rerun.log(f"scan/{name}", rerun.SegmentationImage(maps[name]), recording=recording)
    _log_objects(sample, recording)
    if points and "range_mm" in maps:
        places, levels = _points(sample)
        rerun.log("points", rerun.Points3D(places, colors=levels, radii=sample.col_mm / 2), recording=recording)


def _log_objects(sample: Sample, recording: Any) -> None:
    """Boxes of a sample; none where it has no objects, so that those of the sample before go."""
    objects = sample.objects
    names = sample.pixel_classes
    labels = [one["class"] if one["state"] == one["class"] else f"{one['class']}: {one['state']}" for one in objects]
    boxes = rerun.Boxes2D(
        array=np.array([one["bbox"] for one in objects], dtype=np.float32).reshape(-1, 4),
        array_format=rerun.Box2DFormat.XYWH,
        labels=labels,
        class_ids=[names.index(one["class"]) for one in objects],
    )
    rerun.log("scan/objects", boxes, recording=recording)


def _filled(values: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.nan_to_num(values, nan=0.0)


def _points(sample: Sample) -> tuple[NDArray[np.float32], NDArray[np.uint8] | None]:
    """Places of the measured pixels [mm], and their grey levels where Reflectance is kept.

    Columns are taken to be `col_mm` apart: of rectified scans they are, of others at the height of the upper surface.
    """
    heights = sample.range_mm
    rows, cols = np.nonzero(~np.isnan(heights))
    places = np.column_stack([cols * sample.col_mm, rows * sample.row_mm, heights[rows, cols]]).astype(np.float32)
    if "reflectance" not in sample.maps:
        return places, None
    light = _filled(sample.reflectance)[rows, cols]
    levels = np.rint(255.0 * light / max(float(light.max(initial=0.0)), 1.0)).astype(np.uint8)
    return places, np.repeat(levels[:, None], 3, axis=1)
