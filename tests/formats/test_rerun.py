"""Recordings, by Rerun's own reader."""

import numpy as np
import pyarrow
import pytest
import rerun
import sheetlight
import sheetlight.rerun
from rerun.chunk import RrdReader


def logged(path):
    """What a recording has of each entity, by sample: a dict of components as Arrow has them."""
    found = {}
    for chunk in RrdReader(path).stream().to_chunks():
        batch = chunk.to_record_batch()
        for at in range(batch.num_rows):
            row = {name: batch.column(name)[at] for name in batch.schema.names}
            sample = row["sample"].as_py() if "sample" in row else None
            found.setdefault(chunk.entity_path, {}).setdefault(sample, {}).update(row)
    return found


def numbers(component):
    """The numbers of a component, without their lists."""
    values = component.values
    while pyarrow.types.is_nested(values.type):
        values = values.flatten()
    return values.to_numpy(zero_copy_only=False)


def image(row, kind):
    form = row[f"{kind}:format"].as_py()[0]
    dtype = rerun.ChannelDatatype(form["channel_datatype"]).to_np_dtype()
    return numbers(row[f"{kind}:buffer"]).view(dtype).reshape(form["height"], form["width"])


def test_a_recording_is_the_dataset(made, tmp_path):
    path = tmp_path / "scans.rrd"
    scans = sheetlight.open(made.folder)
    sheetlight.rerun.save(scans, path)
    found = logged(path)
    assert list(found["/scan/label"]) == scans.indices
    classes = found["/scan"][None]["AnnotationContext:context"].as_py()[0]
    names = {one["class_id"]: one["class_description"]["info"]["label"] for one in classes}
    assert names == dict(enumerate(made.head["pixel_classes"]))
    for sample in scans:
        at = sample.index
        stored = made.rows[at]
        for name in ("label", "instance"):
            assert (image(found[f"/scan/{name}"][at], "SegmentationImage") == stored["images"][name]).all()
        measured = ~np.isnan(sample.range_mm)
        heights = image(found["/scan/range"][at], "DepthImage")
        assert (heights == np.where(measured, sample.range_mm, 0)).all()
        assert (image(found["/scan/scatter"][at], "Image") == np.nan_to_num(sample.scatter)).all()
        boxes = found["/scan/objects"][at]
        centres, halves = (numbers(boxes[f"Boxes2D:{key}"]).reshape(-1, 2) for key in ("centers", "half_sizes"))
        assert np.hstack([centres - halves, 2 * halves]).tolist() == [one["bbox"] for one in stored["row"]["objects"]]
        assert boxes["Boxes2D:class_ids"].as_py() == [one["class"] for one in stored["row"]["objects"]]
        places = numbers(found["/points"][at]["Points3D:positions"]).reshape(-1, 3)
        assert len(places) == measured.sum() and np.allclose(places[:, 2], sample.range_mm[measured])


def test_what_cannot_be_saved_is_told(tmp_path):
    with pytest.raises(ValueError, match="there is none"):
        sheetlight.rerun.save([], tmp_path / "none.rrd")
    assert not (tmp_path / "none.rrd").exists()
    with pytest.raises(ValueError, match="on this machine"):
        sheetlight.rerun.save([], "s3://bucket/none.rrd")
    sample = next(sheetlight.Recipe.load("wood-small", {"scan.columns": 64, "scan.profiles": 48}).samples(range(1)))
    sheetlight.rerun.save([sample], tmp_path / "bare.rrd", points=False)
    assert "/points" not in logged(tmp_path / "bare.rrd")
