"""PNG folders, by `datasets` of Hugging Face."""

import json

import datasets
import numpy as np


def test_a_sample_is_a_row(made, tmp_path):
    export = made.export("png", "--colour")
    found = datasets.load_dataset(str(export), cache_dir=str(tmp_path))
    assert set(found) == {"train", "validation", "test"}
    for split, rows in found.items():
        samples = made.of_split(split)
        assert rows["index"] == list(samples)
        for row, sample in zip(rows, samples.values(), strict=True):
            for name, wanted in sample["images"].items():
                if name in sample["png"]:
                    assert (np.array(row[name]).astype(int) == wanted).all(), name
            assert row["colour"].size == row["label"].size
            truth = sample["row"]
            assert (row["id"], row["seed"], row["row_mm"], row["col_mm"]) == tuple(truth[key] for key in ("id", "seed", "row_mm", "col_mm"))
            assert row["class_name"] == made.head["classes"][truth["class"]]
            objects = json.loads(row["objects"])
            assert [one["bbox"] for one in objects] == [one["bbox"] for one in truth["objects"]]


def test_splits_without_an_object_have_the_same_columns(made, tmp_path):
    """One type for each column, whatever the samples of a split lack."""
    export = made.export("png", "--maps", "reflectance")
    features = datasets.load_dataset(str(export), cache_dir=str(tmp_path))["train"].features
    assert {str(features[name].dtype) for name in ("objects", "id", "class_name")} == {"string"}
    assert isinstance(features["reflectance"], datasets.Image)
