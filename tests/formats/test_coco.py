"""COCO documents with polygons, by pycocotools and by the converter of Ultralytics."""

import numpy as np
import pytest
from conftest import Difference, masks
from pycocotools.coco import COCO
from ultralytics.data.converter import convert_coco
from ultralytics.data.utils import polygon2mask


@pytest.mark.parametrize("extent", ["whole", "own"])
def test_pycocotools_fills_polygons_to_the_pixel(made, extent):
    export = made.export("coco", "--polygons", "--mask", extent)
    seen = 0
    for path in sorted((export / "annotations").glob("*.json")):
        found = COCO(str(path))
        categories = found.dataset["categories"]
        assert [one["id"] for one in categories] == list(range(1, len(categories) + 1))
        assert all(made.head["pixel_classes"][one["label_value"]] == one["name"] for one in categories)
        for image in found.loadImgs(found.getImgIds()):
            annotations = found.loadAnns(found.getAnnIds(imgIds=image["id"]))
            wanted = masks(made.rows[image["index"]], extent)
            for annotation, (one, mask) in zip(annotations, wanted, strict=True):
                assert isinstance(annotation["segmentation"], list)
                assert categories[annotation["category_id"] - 1]["label_value"] == one["class"]
                assert (found.annToMask(annotation) == mask).all()
                assert annotation["area"] == mask.sum()
                seen += 1
    assert seen > 10


def test_ultralytics_converts_them(made, tmp_path):
    export = made.export("coco", "--polygons", "--index", "0-9")
    convert_coco(str(export / "annotations"), str(tmp_path / "yolo"), use_segments=True, cls91to80=False)
    off = Difference()
    for index, sample in made.rows.items():
        wanted = masks(sample)
        text = tmp_path / "yolo" / "labels" / sample["row"]["split"] / f"{index:08}.txt"
        lines = text.read_text().splitlines() if text.exists() else []
        shape = sample["images"]["instance"].shape
        values = [value for value in made.head["pixel_classes"] if value]
        names = [one["name"] for one in categories(export)]
        assert len(lines) == len(wanted) and values
        for line, (one, mask) in zip(lines, wanted, strict=True):
            cls, *numbers = line.split()
            assert names[int(cls)] == made.head["pixel_classes"][one["class"]]
            points = np.array(numbers, dtype=np.float32).reshape(-1, 2) * np.array(shape[::-1], dtype=np.float32)
            off.add(polygon2mask(shape, [points.reshape(-1)]), mask)
    print(f"\n{made.folder.name}: {off.told()}")


def categories(export):
    return COCO(str(next(iter(sorted((export / "annotations").glob("*.json")))))).dataset["categories"]
