"""Folders for anomaly detection, by the readers of anomalib."""

import calibrate
import exports_asked
import numpy as np
import pytest
from anomalib.data.datasets import MVTec3DDataset, MVTecADDataset
from PIL import Image

SIDE = 96


def good(made):
    names = ["background", *exports_asked.GOOD[made.head["subject"]]]
    return [made.head["pixel_classes"].index(name) for name in names]


def window(path):
    """The sample of a patch and where that lies, by its name."""
    index, row, col = path.rsplit("/", 1)[1].split(".")[0].split("_")[:3]
    top, left = int(row[1:]), int(col[1:])
    return int(index), np.s_[top : top + SIDE, left : left + SIDE]


def places(made, sample):
    """x, y, z of each pixel by the camera's own formulae, zeros where nothing is measured."""
    row, numbers = sample["row"], sample["images"]["range"].astype(float)
    z = row["range_offset_mm"] + row["range_scale_mm"] * numbers
    rows, cols = numbers.shape
    scale = made.head["images"]["sensor_cols"] / cols
    x = calibrate.along(row["calibration"], (np.arange(cols) + 0.5) * scale - 0.5, z)
    y = np.arange(rows)[:, None] * row["row_mm"] + np.zeros_like(z)
    return np.where(numbers[..., None] == 0, 0.0, np.stack([x, y, z], axis=-1))


@pytest.mark.parametrize("image", ["reflectance", "rgb"])
def test_anomalib_reads_pictures_places_and_masks(made, image):
    export = made.export("mvtec3d", "--patch-px", str(SIDE), "--image", image)
    wanted = {index: places(made, sample) for index, sample in made.rows.items()}
    defects, worst = 0, 0.0
    for split in ["train", "validation", "test"]:
        found = MVTec3DDataset(root=export.parent, category=export.name, split=split)
        assert len(found) > 0
        for item in (found[i] for i in range(len(found))):
            index, part = window(item.image_path)
            sample = made.rows[index]
            assert sample["row"]["split"] == split and item.image.shape == (3, SIDE, SIDE)
            if image == "reflectance":
                levels = np.rint(item.image.numpy() * 255).astype(int)
                assert (levels == sample["images"]["reflectance"][part]).all()
            worst = max(worst, np.abs(item.depth_map.numpy().transpose(1, 2, 0) - wanted[index][part]).max())
            mask = ~np.isin(sample["images"]["label"][part], good(made))
            assert (item.gt_mask.numpy().astype(bool) == mask).all() and bool(item.gt_label) == mask.any()
            assert split == "test" or not mask.any()
            if split == "test":
                gt = np.array(Image.open(item.image_path.replace("/rgb/", "/gt/")))
                assert (gt == np.where(mask, 255, 0)).all()
            defects += mask.any()
    assert defects > 0
    # Single precision of numbers of some hundred mm.
    assert worst < 2e-5, worst


def test_anomalib_reads_pictures_and_masks(made):
    export = made.export("mvtec", "--patch-px", str(SIDE))
    seen = 0
    for split in ["train", "test"]:
        found = MVTecADDataset(root=export.parent, category=export.name, split=split)
        for item in (found[i] for i in range(len(found))):
            index, part = window(item.image_path)
            mask = ~np.isin(made.rows[index]["images"]["label"][part], good(made))
            assert (item.gt_mask.numpy().astype(bool) == mask).all() and bool(item.gt_label) == mask.any()
            seen += mask.any()
    assert seen > 0
