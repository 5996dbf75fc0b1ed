"""Opens exports of a dataset with the tools they are made for and compares them with the dataset, number by number.

    check_exports.py FORMAT DATASET EXPORT [options that `gen export` was given]
"""

import io
import json
import sys
from pathlib import Path

import numpy as np
from PIL import Image

import exports_asked
from exports_asked import GOOD, check_document, check_picture, check_scaling, chosen


def coco(asked, export, head, rows, told):
    """pycocotools loads every document; each mask, box and area is that of the instance image."""
    from pycocotools import mask as tools
    from pycocotools.coco import COCO

    samples = chosen(asked, rows)
    check_scaling(asked, head, rows, told["scaling"])
    seen, objects, nested = set(), 0, 0
    for path in sorted((export / "annotations").glob("instances_*.json")):
        split = path.stem.removeprefix("instances_")
        found = COCO(str(path))
        assert found.dataset["info"]["scaling"] == told["scaling"]
        for category in found.dataset["categories"]:
            assert head["pixel_classes"][category["label_value"]] == category["name"] and category["supercategory"], category
        values = {category["id"]: category["label_value"] for category in found.dataset["categories"]}
        assert list(values) == list(range(1, len(values) + 1)), "ids without gaps"
        assert len({a["id"] for a in found.dataset["annotations"]}) == len(found.dataset["annotations"])
        assert all(a["id"] > 0 for a in found.dataset["annotations"])
        counts = {"images": len(found.dataset["images"]), "annotations": len(found.dataset["annotations"])}
        assert told["splits"][split] == counts, (split, counts)
        for image in found.loadImgs(found.getImgIds()):
            sample = samples[image["index"]]
            row, instances = sample["row"], sample["images"]["instance"]
            assert (row["split"], row["id"]) == (split, image["sample_id"]) and image["id"] not in seen
            assert head["classes"][row["class"]] == image["sample_class"]
            assert (image["seed"], image["row_mm"], image["col_mm"]) == (row["seed"], row["row_mm"], row["col_mm"])
            seen.add(image["id"])
            picture = np.array(Image.open(export / "images" / split / image["file_name"]))
            assert picture.shape[:2] == (image["height"], image["width"]) == instances.shape
            check_picture(asked, picture, sample, told["scaling"])
            inside = {o["instance"]: o["within"] for o in row["objects"]}
            annotations = found.loadAnns(found.getAnnIds(imgIds=image["id"]))
            expected = {}
            for item in row["objects"]:
                members = {item["instance"]}
                for inner in sorted(inside):
                    if inside[inner] in members:
                        members.add(inner)
                nested += len(members) > 1
                if asked.mask == "own":
                    members = {item["instance"]}
                truth = np.isin(instances, list(members))
                if truth.any():
                    expected[item["instance"]] = (item, truth)
            assert [a["attributes"]["instance"] for a in annotations] == list(expected), "every object once"
            for annotation in annotations:
                item, truth = expected[annotation["attributes"]["instance"]]
                segmentation = annotation["segmentation"]["counts"]
                assert isinstance(segmentation, list if asked.plain_rle else str), type(segmentation)
                runs = found.annToRLE(annotation)
                assert (tools.decode(runs) == truth).all(), annotation["id"]
                assert tools.toBbox(runs).tolist() == [float(n) for n in annotation["bbox"]]
                assert int(tools.area(runs)) == annotation["area"] == int(truth.sum())
                if asked.mask == "whole":
                    assert annotation["bbox"] == item["bbox"] and annotation["area"] == item["area_px"]
                assert values[annotation["category_id"]] == item["class"] and annotation["iscrowd"] == 0
                attributes = annotation["attributes"]
                assert attributes["state"] == head["pixel_classes"][item["state"]]
                for key in ["within", "area_mm2", "x_mm", "y_mm", "diameter_mm", "severity", "dive_deg"]:
                    assert attributes[key] == item[key], key
                objects += 1
    assert seen == set(samples), "every sample once"
    return f"{len(seen)} images, {objects} objects, {nested} with others inside"


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


def patches(asked, shape):
    """The names of a picture's parts after its index, and where they lie: evenly over all of it."""
    if not asked.patch_px:
        return {"": np.s_[:, :]}
    side = asked.patch_px
    starts = []
    for length in shape:
        more = -(-length // side) - 1
        starts.append([i * (length - side) // more if more else 0 for i in range(more + 1)])
    tops, lefts = starts
    return {f"_r{t:05}_c{l:05}": np.s_[t : t + side, l : l + side] for t in tops for l in lefts}


def mvtec(asked, export, head, rows, told):
    """Every picture lies where its labels say, and every mask is those labels; no other picture is there."""
    names = ["background", *(asked.good or GOOD[head["subject"]])]
    assert set(told["good"]) == set(names), (told["good"], names)
    good = [head["pixel_classes"].index(name) for name in names]
    check_scaling(asked, head, rows, told["scaling"])
    images, masks = anomaly_folders(export)
    counts, left_out, there = {}, 0, set(images)
    for index, sample in chosen(asked, rows).items():
        split = sample["row"]["split"]
        for corner, part in patches(asked, sample["images"]["label"].shape).items():
            labels = sample["images"]["label"][part]
            defects = sorted(set(np.unique(labels).tolist()) - set(good))
            if split == "train" and defects:
                left_out += 1
                continue
            classes = [head["pixel_classes"][value] for value in defects]
            folder = "good" if not classes else classes[0] if len(classes) == 1 else "combined"
            parts = (split, folder, f"{index:08}{corner}.png")
            assert parts in there, f"{parts} is not there"
            there.remove(parts)
            picture = np.array(Image.open(export.joinpath(*parts)))
            assert picture.shape[:2] == labels.shape, (picture.shape, labels.shape)
            cut = {"row": sample["row"], "images": {name: m[part] for name, m in sample["images"].items()}}
            check_picture(asked, picture, cut, told["scaling"])
            if classes:
                mask = np.array(Image.open(export.joinpath(*masks[parts])))
                assert mask.dtype == np.uint8 and (mask == np.where(np.isin(labels, good), 0, 255)).all(), parts
            counts[f"{split}/{folder}"] = counts.get(f"{split}/{folder}", 0) + 1
    assert not there, f"no sample has these: {there}"
    assert (counts, left_out) == (told["pictures"], told["left_out"]), (counts, left_out, told)
    return f"{counts}"


def pixels(name, content):
    """For `decode` of webdataset, whose own decoders make 8-bit colours of every PNG."""
    return np.array(Image.open(io.BytesIO(content))) if name.endswith(".png") else None


def webdataset(asked, export, head, rows, told):
    """webdataset reads and decodes every sample; images and numbers are those of the dataset."""
    import webdataset as wds

    samples, maps = chosen(asked, rows), exports_asked.maps(asked, rows)
    tars = sorted(export.glob("*.tar"))
    seen = []
    for tar in tars:
        assert tar.stat().st_size <= asked.tar_mb * 1_000_000, tar
        for sample in wds.WebDataset(str(tar), shardshuffle=False).decode(pixels):
            index = int(sample["__key__"])
            seen.append(index)
            truth = samples[index]
            assert tar.name.startswith(truth["row"]["split"] + "-")
            assert {name for name in sample if name[0] != "_"} == {*(f"{name}.png" for name in maps), "json"}
            for name in maps:
                found, numbers = sample[f"{name}.png"], truth["images"][name]
                assert name not in truth["png"] or found.dtype == numbers.dtype, (name, found.dtype)
                assert found.shape == numbers.shape and (found.astype(int) == numbers).all(), (index, name)
            same_row(sample["json"], truth["row"], head)
    assert sorted(seen) == sorted(samples), "every sample once"
    assert sum(split["tars"] for split in told["splits"].values()) == len(tars)
    return f"{len(tars)} tars, {len(seen)} samples"


def same_row(found, row, head):
    """Every number to the last bit, every word."""
    found = json.loads(json.dumps(found))
    assert found.pop("class_name") == head["classes"][row["class"]]
    for item in found["objects"]:
        for of in ["class", "state"]:
            assert item.pop(f"{of}_name") == head["pixel_classes"][item[of]]
    assert found == row, (found, row)


def png(asked, export, head, rows, told):
    """Files are the stored bytes, or the same numbers from EXR; coloured labels tell classes apart."""
    samples, maps = chosen(asked, rows), exports_asked.maps(asked, rows)
    seen, colours, named = [], {}, set()
    for table in sorted(export.glob("*.jsonl")):
        for line in table.read_text().splitlines():
            row = json.loads(line)
            files = row.pop("files")
            named.update(files.values())
            truth = samples[row["index"]]
            seen.append(row["index"])
            assert row["split"] == table.stem
            same_row(row, truth["row"], head)
            assert list(files) == maps + ["colour"] * asked.colour, (files, maps)
            if asked.colour:
                picture = np.array(Image.open(export / files.pop("colour"))).reshape(-1, 3)
                labels = truth["images"]["label"].reshape(-1)
                for value in np.unique(labels):
                    shades = np.unique(picture[labels == value], axis=0)
                    assert len(shades) == 1 and colours.setdefault(int(value), shades.tolist()) == shades.tolist()
            for name, path in files.items():
                content = (export / path).read_bytes()
                assert name not in truth["png"] or content == truth["png"][name], path
                assert (np.array(Image.open(io.BytesIO(content))).astype(int) == truth["images"][name]).all(), path
    assert sorted(seen) == sorted(samples), "every sample once"
    assert {path.relative_to(export).as_posix() for path in export.rglob("*.png")} == named, "no other picture"
    assert len({str(shades) for shades in colours.values()}) == len(colours), "each class has a colour of its own"
    assert told["label_values"] == {str(value): head["pixel_classes"][value] for value in head["label_values"]}
    return f"{len(seen)} rows, {len(colours)} colours"


def pictures(asked):
    return {"image": asked.image, "range": asked.range_ends, "scatter": asked.scatter_ends}


# Each format: its check, and the options that `export.json` holds.
FORMATS = {
    "coco": (
        coco,
        lambda asked, _: pictures(asked) | {"bits": asked.bits, "mask": asked.mask, "plain": asked.plain_rle, "polygons": False},
    ),
    "mvtec": (mvtec, lambda asked, _: pictures(asked) | {"good": asked.good, "patch_px": asked.patch_px}),
    "webdataset": (
        webdataset,
        lambda asked, rows: {"maps": exports_asked.maps(asked, rows), "most_bytes": asked.tar_mb * 1_000_000},
    ),
    "png": (png, lambda asked, rows: {"maps": exports_asked.maps(asked, rows), "colour": asked.colour}),
}

if __name__ == "__main__":
    asked = exports_asked.request(sys.argv[1:])
    dataset, export = Path(asked.dataset), Path(asked.export)
    head, rows = exports_asked.stored(dataset)
    check, wanted = FORMATS[asked.format]
    result = check_document(asked, wanted(asked, rows), dataset, export, head)
    print(f"{asked.format}: {check(asked, export, head, rows, result)}")
