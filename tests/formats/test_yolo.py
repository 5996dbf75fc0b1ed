"""YOLO folders, by the loader of Ultralytics and by a training."""

import logging

import numpy as np
import pytest
from conftest import Difference, masks
from ultralytics import YOLO
from ultralytics.cfg import get_cfg
from ultralytics.data.dataset import YOLODataset
from ultralytics.data.utils import check_det_dataset
from ultralytics.utils import LOGGER


@pytest.fixture
def warnings():
    """What Ultralytics warns of meanwhile, but for how fast the disk is."""
    heard = []

    class Ear(logging.Handler):
        def emit(self, record):
            if "image access" not in record.getMessage():
                heard.append(record.getMessage())

    ear = Ear(logging.WARNING)
    LOGGER.addHandler(ear)
    yield heard
    LOGGER.removeHandler(ear)


def loader(export, split, side, task):
    """The loader of a training, which neither scales nor changes pictures."""
    data = check_det_dataset(str(export / "data.yaml"))
    hyp = get_cfg(overrides={"mask_ratio": 1, "overlap_mask": False})
    return data, YOLODataset(img_path=data[split], imgsz=side, augment=False, hyp=hyp, rect=False, data=data, task=task)


@pytest.mark.parametrize("task", ["segment", "detect"])
@pytest.mark.parametrize("extent", ["whole", "own"])
def test_the_loader_finds_every_mask_and_box(made, warnings, task, extent):
    export = made.export("yolo", "--task", task, "--mask", extent)
    rows, cols = next(iter(made.rows.values()))["images"]["label"].shape
    side, off, seen = max(rows, cols), Difference(), 0
    top, left = (side - rows) // 2, (side - cols) // 2
    for split, name in [("train", "train"), ("val", "validation"), ("test", "test")]:
        data, found = loader(export, split, side, task)
        samples = made.of_split(name)
        assert [path.rsplit("/", 1)[1] for path in found.im_files] == [f"{index:08}.png" for index in samples]
        for item, sample in zip((found[i] for i in range(len(found))), samples.values(), strict=True):
            window = np.s_[top : top + rows, left : left + cols]
            assert (item["img"].numpy()[0][window] == sample["images"]["reflectance"]).all()
            wanted = masks(sample, extent)
            classes = [made.head["pixel_classes"][one["class"]] for one, _ in wanted]
            assert [data["names"][int(cls)] for cls in item["cls"].flatten()] == classes
            for at, (one, mask) in enumerate(wanted):
                ys, xs = np.nonzero(mask)
                box = [xs.min() + left, ys.min() + top, xs.max() + 1 + left, ys.max() + 1 + top]
                x, y, w, h = item["bboxes"][at].numpy() * side
                # A polygon runs 0.02 px inside.
                assert np.abs(np.subtract([x - w / 2, y - h / 2, x + w / 2, y + h / 2], box)).max() < 0.03
                if task == "segment":
                    off.add(item["masks"][at].numpy()[window], mask)
                seen += 1
    assert list(data["names"]) == list(range(len(data["names"]))) and seen > 10
    assert warnings == []
    print(f"\n{made.folder.name} {task} {extent}: {off.told()}")


def test_a_network_trains_for_an_epoch(made, warnings, tmp_path):
    export = made.export("yolo")
    model = YOLO("yolo11n-seg.yaml")
    model.train(
        data=str(export / "data.yaml"), epochs=1, imgsz=64, batch=4, workers=0, device="cpu", amp=False, plots=False,
        project=str(tmp_path), optimizer="SGD", verbose=False,
    )  # fmt: skip
    assert (tmp_path / "train" / "weights" / "last.pt").exists()
    words = ("label", "corrupt", "duplicate", "segment", "box", "image", "missing")
    assert not [said for said in warnings if any(word in said.lower() for word in words)], warnings
