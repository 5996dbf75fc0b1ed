"""Opens exports of a dataset with the tools they are made for and compares them with the dataset, number by number.

    check_exports.py coco|mvtec|webdataset|png DATASET EXPORT [own]
"""

import io
import json
import sys
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
from PIL import Image

IMAGES = ["range", "reflectance", "scatter", "label", "instance"]


def stored(dataset):
    """Every row of the dataset by index: numbers, and images decoded by Pillow; from EXR where there is no image."""
    head = json.loads((dataset / "dataset.json").read_text())
    rows = {}
    for path in sorted((dataset / "data").glob("*.parquet")):
        for row in pq.read_table(path).to_pylist():
            images, png = {}, {}
            for name in IMAGES:
                if name in row:
                    png[name] = row.pop(name)["bytes"]
                    images[name] = np.array(Image.open(io.BytesIO(png[name])))
            shard = f"{row['index'] // head['samples_per_shard']:05}"
            if len(images) < 5 and (exr := dataset / "exr" / shard / f"{row['id']}.exr").exists():
                images = from_exr(exr, row) | images
            rows[row["index"]] = {"row": row, "images": images, "png": png}
    return head, rows


def from_exr(path, row):
    """The maps of an EXR file in the numbers of PNG columns."""
    import OpenEXR

    found = OpenEXR.File(str(path), separate_channels=True).channels()
    maps = {name: found[name.capitalize()].pixels.astype(float) for name in IMAGES if name.capitalize() in found}
    for name, pixels in maps.items():
        if name == "range":
            pixels = np.clip(np.rint((pixels - row["range_offset_mm"]) / row["range_scale_mm"]), 1, 65535)
            pixels[np.isnan(maps["range"])] = 0
        maps[name] = np.rint(np.nan_to_num(pixels, nan=0.0)).astype(int)
    return maps


def scaled(sample, scaling):
    """One map of a sample in 8 bits, as the scaling of an export says; and how far levels may lie off."""
    name = scaling["map"]
    numbers = sample["images"][name].astype(float)
    values = numbers
    if name == "range":
        row = sample["row"]
        unit = scaling["unit"]
        values = row[f"range_offset_{unit}"] + row[f"range_scale_{unit}"] * numbers
    levels = np.clip((values - scaling["offset"]) / scaling["scale"], 1, 255)
    return np.where(numbers == 0, 0, levels)


def same_picture(picture, sample, scalings):
    """Whether a picture is what its scaling says, each level rounded to the nearest."""
    planes = picture if picture.ndim == 3 else picture[..., None]
    assert planes.shape[-1] == len(scalings), (planes.shape, scalings)
    for channel, scaling in enumerate(scalings):
        levels = scaled(sample, scaling)
        worst = np.abs(planes[..., channel] - levels).max()
        assert worst <= 0.5 + 1e-6, f"{scaling['map']}: levels differ by {worst}"
        assert ((planes[..., channel] == 0) == (levels == 0)).all(), "missing is 0 and nothing else is"


def coco(dataset, export, own=False):
    """pycocotools loads every document; each mask, box and area is that of the instance image."""
    from pycocotools import mask as tools
    from pycocotools.coco import COCO

    head, rows = stored(dataset)
    seen, objects = set(), 0
    for path in sorted((export / "annotations").glob("instances_*.json")):
        split = path.stem.removeprefix("instances_")
        found = COCO(str(path))
        scalings = found.dataset["info"]["scaling"]
        for category in found.dataset["categories"]:
            assert head["pixel_classes"][category["id"]] == category["name"] and category["supercategory"], category
        assert len({a["id"] for a in found.dataset["annotations"]}) == len(found.dataset["annotations"])
        assert all(a["id"] > 0 for a in found.dataset["annotations"])
        for image in found.loadImgs(found.getImgIds()):
            sample = rows[image["index"]]
            row, instances = sample["row"], sample["images"]["instance"]
            assert (row["split"], row["id"]) == (split, image["sample_id"]) and image["id"] not in seen
            assert head["classes"][row["class"]] == image["sample_class"]
            assert (image["seed"], image["row_mm"], image["col_mm"]) == (row["seed"], row["row_mm"], row["col_mm"])
            seen.add(image["id"])
            picture = np.array(Image.open(export / "images" / split / image["file_name"]))
            assert picture.shape[:2] == (image["height"], image["width"]) == instances.shape
            if scalings:
                same_picture(picture, sample, scalings)
            else:
                assert any((picture == sample["images"][name]).all() for name in ["range", "reflectance", "scatter"])
            inside = {o["instance"]: o["within"] for o in row["objects"]}
            annotations = found.loadAnns(found.getAnnIds(imgIds=image["id"]))
            expected = {}
            for item in row["objects"]:
                members = {item["instance"]}
                if not own:
                    for inner in sorted(inside):
                        if inside[inner] in members:
                            members.add(inner)
                truth = np.isin(instances, list(members))
                if truth.any():
                    expected[item["instance"]] = (item, truth)
            assert [a["attributes"]["instance"] for a in annotations] == list(expected), "every object once"
            for annotation in annotations:
                item, truth = expected[annotation["attributes"]["instance"]]
                runs = found.annToRLE(annotation)
                assert (tools.decode(runs) == truth).all(), annotation["id"]
                assert tools.toBbox(runs).tolist() == [float(n) for n in annotation["bbox"]]
                assert int(tools.area(runs)) == annotation["area"] == int(truth.sum())
                if not own:
                    assert annotation["bbox"] == item["bbox"] and annotation["area"] == item["area_px"]
                assert annotation["category_id"] == item["class"] and annotation["iscrowd"] == 0
                attributes = annotation["attributes"]
                assert attributes["state"] == head["pixel_classes"][item["state"]]
                for key in ["within", "area_mm2", "x_mm", "y_mm", "diameter_mm", "severity", "dive_deg"]:
                    assert attributes[key] == item[key], key
                objects += 1
    assert seen == set(rows), "every sample once"
    print(f"coco: {len(seen)} images, {objects} objects")


def anomaly_folders(root):
    """Train and test as readers of MVTec AD folders pair them: by the order of their paths, stems held together."""
    files = [path.relative_to(root).parts[-3:] for path in sorted(root.rglob("*.png"))]
    masks = sorted(parts for parts in files if parts[0] == "ground_truth")
    images = sorted(parts for parts in files if parts[0] != "ground_truth")
    assert {parts[0] for parts in images} <= {"train", "test"}, "no other folder"
    assert all(parts[1] == "good" for parts in images if parts[0] == "train"), "only good ones are learnt from"
    abnormal = [parts for parts in images if parts[1] != "good"]
    assert len(masks) == len(abnormal)
    paired = dict(zip(abnormal, masks))
    for image, mask in paired.items():
        assert Path(image[2]).stem in Path(mask[2]).stem and image[1] == mask[1], (image, mask)
    return images, paired


def mvtec(dataset, export):
    """Every picture lies where its labels say, and every mask is those labels."""
    head, rows = stored(dataset)
    told = json.loads((export / "export.json").read_text())["result"]
    good = [head["pixel_classes"].index(name) for name in told["good"]]
    images, masks = anomaly_folders(export)
    counts, covered = {}, {index: np.zeros(s["images"]["label"].shape, bool) for index, s in rows.items()}
    for split, folder, name in images:
        key, *corner = Path(name).stem.split("_")
        sample = rows[int(key)]
        picture = np.array(Image.open(export / split / folder / name))
        top, left = (int(part[1:]) for part in corner) if corner else (0, 0)
        part = np.s_[top : top + picture.shape[0], left : left + picture.shape[1]]
        labels = sample["images"]["label"][part]
        cut = {"row": sample["row"], "images": {n: m[part] for n, m in sample["images"].items()}}
        same_picture(picture, cut, told["scaling"])
        assert sample["row"]["split"] == split
        defects = sorted(set(np.unique(labels).tolist()) - set(good))
        names = [head["pixel_classes"][value] for value in defects]
        assert folder == ("good" if not names else names[0] if len(names) == 1 else "combined"), (name, names)
        if names:
            mask = np.array(Image.open(export.joinpath(*masks[(split, folder, name)])))
            assert mask.dtype == np.uint8 and (mask == np.where(np.isin(labels, good), 0, 255)).all(), name
        counts[f"{split}/{folder}"] = counts.get(f"{split}/{folder}", 0) + 1
        covered[int(key)][part] = True
    assert counts == told["pictures"], (counts, told)
    for index, sample in rows.items():
        whole = covered[index].all()
        is_good = np.isin(sample["images"]["label"], good).all()
        split = sample["row"]["split"]
        assert split != "test" or whole, f"sample {index} is not all there"
        assert split != "train" or whole or not is_good, f"sample {index} is good and not there"
        assert split != "validation" or not covered[index].any(), f"sample {index} has no place"
    print(f"mvtec: {counts}")


def pixels(name, content):
    """For `decode` of webdataset, whose own decoders make 8-bit colours of every PNG."""
    return np.array(Image.open(io.BytesIO(content))) if name.endswith(".png") else None


def webdataset(dataset, export):
    """webdataset reads and decodes every sample; images and numbers are those of the dataset."""
    import webdataset as wds

    head, rows = stored(dataset)
    tars = sorted(export.glob("*.tar"))
    seen = []
    for tar in tars:
        for sample in wds.WebDataset(str(tar), shardshuffle=False).decode(pixels):
            index = int(sample["__key__"])
            seen.append(index)
            truth = rows[index]
            assert tar.name.startswith(truth["row"]["split"] + "-")
            for name, numbers in truth["images"].items():
                found = sample[f"{name}.png"]
                assert name not in truth["png"] or found.dtype == numbers.dtype, (name, found.dtype)
                assert found.shape == numbers.shape and (found.astype(int) == numbers).all(), (index, name)
            same_row(sample["json"], truth["row"], head)
    assert sorted(seen) == sorted(rows), "every sample once"
    print(f"webdataset: {len(tars)} tars, {len(seen)} samples")


def same_row(found, row, head):
    """Every number to the last bit, every word."""
    found = json.loads(json.dumps(found))
    assert found.pop("class_name") == head["classes"][row["class"]]
    for item in found["objects"]:
        for of in ["class", "state"]:
            assert item.pop(f"{of}_name") == head["pixel_classes"][item[of]]
    assert found == row, (found, row)


def png(dataset, export):
    """Files are the stored bytes, or the same numbers from EXR; coloured labels tell classes apart."""
    head, rows = stored(dataset)
    seen, colours = [], {}
    for table in sorted(export.glob("*.jsonl")):
        for line in table.read_text().splitlines():
            row = json.loads(line)
            files = row.pop("files")
            truth = rows[row["index"]]
            seen.append(row["index"])
            same_row(row, truth["row"], head)
            if colour := files.pop("colour", None):
                picture = np.array(Image.open(export / colour)).reshape(-1, 3)
                labels = truth["images"]["label"].reshape(-1)
                for value in np.unique(labels):
                    shades = np.unique(picture[labels == value], axis=0)
                    assert len(shades) == 1 and colours.setdefault(int(value), shades.tolist()) == shades.tolist()
            assert set(files) == set(truth["images"]), (files, set(truth["images"]))
            for name, path in files.items():
                content = (export / path).read_bytes()
                assert name not in truth["png"] or content == truth["png"][name], path
                assert (np.array(Image.open(io.BytesIO(content))).astype(int) == truth["images"][name]).all(), path
    assert sorted(seen) == sorted(rows), "every sample once"
    assert len({str(shades) for shades in colours.values()}) == len(colours), "each class has a colour of its own"
    print(f"png: {len(seen)} rows, {len(colours)} colours")


if __name__ == "__main__":
    kind, source, made, *rest = sys.argv[1:]
    arguments = [Path(source), Path(made)] + [True] * bool(rest)
    {"coco": coco, "mvtec": mvtec, "webdataset": webdataset, "png": png}[kind](*arguments)
