"""What is rendered in this process is what `gen` writes, by readers of other people."""

import io
import json

import numpy as np
import OpenEXR
import pyarrow.parquet as pq
import pytest
import sheetlight
from conftest import FULL, SMALL, write
from PIL import Image

SAMPLES = 50 if FULL else 1
CHANNELS = {
    "height_mm": "Height", "fibre_azimuth_deg": "FibreAzimuth", "fibre_dive_deg": "FibreDive",
    "film_thickness_mm": "FilmThickness", "film_gap_mm": "FilmGap",
}  # fmt: skip


def same(a, b):
    """Bit for bit; NaN is NaN."""
    return a.shape == b.shape and np.array_equal(a, b, equal_nan=a.dtype.kind == "f")


def stepped(heights):
    """Heights as EXR files hold them: steps of 2^-13 mm."""
    whole = np.sign(heights) * np.floor(np.abs(heights * np.float32(8192)) + np.float32(0.5))
    return (whole / np.float32(8192)).astype(np.float32)


def half(values):
    return values.astype(np.float16).astype(np.float32)


def pixels(row, name):
    return np.array(Image.open(io.BytesIO(row[name]["bytes"])))


def away(values):
    """Rounded, halves away from zero."""
    return np.floor(values.astype(np.float64) + 0.5)


# Recipes with lamps beside the laser.
LAMPS = {"wood-sawmill"}


@pytest.mark.parametrize("name", sheetlight.recipes())
def test_arrays_are_those_of_gen(name, tmp_path):
    changes = dict(SMALL)
    full = ["range", "reflectance", "scatter", "label", "instance"]
    full += ["grey"] if name in LAMPS else []
    changes |= {"output.png": json.dumps(full), "output.exr": json.dumps(full), "output.truth_maps": "true"}
    write(name, SAMPLES, tmp_path / "out", changes, "--seed", 3)
    recipe = sheetlight.Recipe.load(name, {**SMALL, "output.png": full, "output.exr": full, "output.truth_maps": True})
    head = json.loads((tmp_path / "out" / "dataset.json").read_text())
    assert recipe.hash == head["recipe"]["hash"] and recipe.classes == head["classes"]
    assert recipe.shape == (head["images"]["rows"], head["images"]["cols"])

    tables = [pq.read_table(path) for path in sorted((tmp_path / "out").rglob("data/**/*.parquet"))]
    rows = {table["index"][at].as_py(): table.slice(at, 1) for table in tables for at in range(len(table))}
    assert sorted(rows) == list(range(SAMPLES))
    stored = sheetlight.open(tmp_path / "out")
    for sample in recipe.samples(range(SAMPLES), seed=3):
        table = rows[sample.index]
        # The row as a whole: every number, object and image, and what the schema says about them.
        assert sample.to_arrow().combine_chunks().equals(table.combine_chunks(), check_metadata=True)
        row = table.to_pylist()[0]
        assert (sample.id, sample.split, sample.class_name) == (row["id"], row["split"], head["classes"][row["class"]])

        # The images, by Pillow.
        unit = sample.range_unit
        range_, valid = sample.maps[f"range_{unit}"], sample.valid
        offset, scale = row[f"range_offset_{unit}"], row[f"range_scale_{unit}"]
        numbers = np.zeros(sample.shape)
        numbers[valid] = np.clip(away((range_[valid].astype(np.float64) - offset) / scale), 1, 65535)
        assert same(pixels(row, "range").astype(float), numbers)
        for dn in ("reflectance", "scatter"):
            measured = getattr(sample, dn)
            assert same(np.isnan(measured), ~valid)
            assert same(pixels(row, dn).astype(float), away(np.where(valid, measured, 0)))
        if name in LAMPS:
            assert same(pixels(row, "grey").astype(float), np.nan_to_num(sample.maps["grey"]))
        assert same(pixels(row, "label"), sample.label)
        assert same(pixels(row, "instance").astype(np.uint16), sample.instance)

        # The EXR file, by OpenEXR.
        [file] = (tmp_path / "out" / "exr").rglob(f"{sample.id}.exr")
        channels = {key: value.pixels for key, value in OpenEXR.File(str(file), separate_channels=True).channels().items()}
        rounded = half if head["images"]["bits"] == 8 else np.asarray
        assert same(channels["Range"], stepped(range_))
        assert same(channels["Scatter"], sample.scatter)
        assert same(channels["Reflectance"].astype(np.float32), rounded(sample.reflectance))
        assert same(channels["Label"].astype(np.uint8), sample.label)
        assert same(channels["Instance"].astype(np.uint16), sample.instance)
        for key, values in sample.truth.items():
            kept = stepped(values) if key == "height_mm" else half(values)
            assert same(channels[CHANNELS[key]].astype(np.float32), kept)
        assert {CHANNELS[key] for key in sample.truth} | {
            "Range", "Scatter", "Reflectance", "Label", "Instance", "Y", *(["Grey"] if name in LAMPS else [])
        } == set(channels)  # fmt: skip

        # And the package's own reader: EXR files where they are.
        read = stored.sample(sample.index)
        assert list(read.maps) == list(sample.maps)
        assert same(read.maps[f"range_{unit}"], stepped(range_)) and same(read.scatter, sample.scatter)
        assert same(read.label, sample.label) and same(read.instance, sample.instance)
        for what in ("parameters", "physics", "calibration", "objects", "shares", "class_area_px", "columns", "dark_dn"):
            assert json.dumps(getattr(read, what)) == json.dumps(getattr(sample, what)), what
        assert read.defect_classes == sample.defect_classes and read.unseen_classes == sample.unseen_classes
        assert read.shape == sample.shape


@pytest.mark.parametrize("form", ["calibrated", "rectified", "uncalibrated"])
@pytest.mark.parametrize("bits", [8, 12])
def test_files_round_what_the_page_says(form, bits, tmp_path):
    """The table of docs/guide/python.md: what is equal, and steps of what is not."""
    changes = {**SMALL, "extraction.range": form, "exposure.bits": bits, "output.truth_maps": True}
    recipe = sheetlight.Recipe.load("wood-small", changes)
    images = {"output.png": "[range, reflectance, scatter, label, instance]", "output.exr": "[]", "output.truth_maps": "false"}
    read = []
    for place, more in [("exr", {"output.truth_maps": "true"}), ("png", images)]:
        write("wood-small", 1, tmp_path / place, {**SMALL, "extraction.range": form, "exposure.bits": bits, **more})
        read.append(sheetlight.open(tmp_path / place)[0])
    (exr, png), sample = read, recipe.sample(0)
    key, there = f"range_{sample.range_unit}", sample.valid
    assert same(exr.scatter, sample.scatter) and same(exr.label, sample.label) and same(exr.instance, sample.instance)
    assert same(png.label, sample.label) and same(png.instance, sample.instance)
    is_whole = form != "rectified"
    assert bool((sample.reflectance[there] == away(sample.reflectance[there])).all()) == is_whole
    assert same(exr.reflectance, sample.reflectance if is_whole or bits == 12 else half(sample.reflectance))
    assert same(exr.reflectance, sample.reflectance) == (is_whole or bits == 12)
    assert same(png.reflectance[there].astype(float), away(sample.reflectance[there])) and same(png.scatter[there].astype(float), away(sample.scatter[there]))
    assert same(exr.maps[key], stepped(sample.maps[key])) and same(exr.truth["height_mm"], stepped(sample.truth["height_mm"]))
    step = png.to_arrow()[f"range_scale_{sample.range_unit}"][0].as_py()
    assert np.nanmax(np.abs(png.maps[key].astype(float) - sample.maps[key])) <= step * 0.5001 + 2**-14
    assert same(png.maps[key], sample.maps[key]) == (form == "uncalibrated")
    for name in ("fibre_azimuth_deg", "fibre_dive_deg"):
        assert same(exr.truth[name], half(sample.truth[name]))


def test_sensor_frames_are_those_of_gen(boards):
    recipe = sheetlight.Recipe.load(boards)
    rows = pq.read_table(boards / "stacks" / "00001.parquet").to_pylist()
    sample = recipe.sample(8, seed=7)
    wanted = {row["profile"]: row["frame"] for row in rows if row["index"] == 8}
    assert list(wanted) == [0, 20] == list(sample.frames) == list(sheetlight.open(boards).sample(8).frames)
    for profile, frame in wanted.items():
        assert sample.frames[profile].shape == (recipe.size["rows"], 96) and sample.frames[profile].dtype == np.uint16
        assert sample.frames[profile].ravel().tolist() == frame
        assert same(sheetlight.open(boards).sample(8).frames[profile], sample.frames[profile])


def test_threads_order_and_seed_change_what_they_should(boards):
    recipe = sheetlight.Recipe.load("wood-small", SMALL)
    alone = recipe.sample(5, seed=7, threads=1)
    for threads in (1, 2, 3):
        found = list(recipe.samples(range(6, 3, -1), seed=7, threads=threads))
        assert [sample.index for sample in found] == [6, 5, 4]
        assert same(found[1].scatter, alone.scatter) and found[1].parameters == alone.parameters
    assert not same(recipe.sample(5, seed=8).scatter, alone.scatter)
    assert [sample.index for sample in recipe.samples(3, threads=2)] == [0, 1, 2] and not list(recipe.samples(range(0)))
    # An iterator that is left alone does not keep its threads.
    next(recipe.samples(10_000, threads=2))
    assert recipe.sample(5, seed=7).index == 5


def test_a_recipe_of_a_dataset_draws_its_samples(boards):
    recipe = sheetlight.Recipe.load(boards)
    assert recipe.seed == 7 and sheetlight.Recipe.load("wood-small").seed == 0
    assert recipe.sample(4).id == recipe.sample(4, seed=7).id == next(recipe.samples(range(4, 5))).id == sheetlight.open(boards).sample(4).id


def test_arrays_are_handed_over():
    sample = sheetlight.Recipe.load("wood-small", SMALL).sample(0)
    for values in sample.maps.values():
        assert values.flags.c_contiguous and not values.flags.writeable and values.flags.aligned
        with pytest.raises(ValueError, match="read-only"):
            values[0, 0] = 1
        # A view of memory that Rust gave, which the base holds and NumPy did not allocate.
        assert not values.flags.owndata and type(values.base).__name__ == "PySliceContainer"
    assert sample.scatter is sample.scatter
    kept = sample.scatter
    total = np.nansum(kept)
    del sample
    assert np.nansum(kept) == total


def test_lamps_show_a_grey_map(tmp_path):
    maps = ["range", "grey"]
    changes = {**SMALL, "lamps.number": "two", "output.png": maps, "output.exr": maps}
    written = {key: json.dumps(value) if isinstance(value, list) else value for key, value in changes.items()}
    write("wood-small", 1, tmp_path / "out", written, "--seed", 3)
    recipe = sheetlight.Recipe.load("wood-small", changes)
    sample, stored = recipe.sample(0, seed=3), sheetlight.open(tmp_path / "out")[0]
    assert same(sample.grey, stored.grey) and "grey" in sample.maps
    table = pq.read_table(next((tmp_path / "out").rglob("data/**/*.parquet")))
    assert np.array_equal(pixels(table.to_pylist()[0], "grey"), away(np.nan_to_num(sample.grey)).astype(np.uint8))
    bare = recipe.sample(0, seed=3, dark=False)
    level = sample.parameters["lamps.dark_level_dn"]
    assert sample.dark_dn["grey"] == level and np.nanmax(np.abs(sample.grey - bare.grey - level)) < 1e-4


def test_dark_level_is_taken_off_on_request(boards):
    recipe = sheetlight.Recipe.load(boards)
    lit, bare = recipe.sample(2, seed=7), recipe.sample(2, seed=7, dark=False)
    level = lit.parameters["exposure.dark_level_dn"]
    # By default Scatter sums 8 rows on both sides; a little more than the level comes from dark current.
    assert level < lit.dark_dn["reflectance"] < level + 1e-3
    assert np.isclose(lit.dark_dn["scatter"], 16 * lit.dark_dn["reflectance"], rtol=1e-7)
    assert same(bare.reflectance, lit.reflectance - np.float32(lit.dark_dn["reflectance"]))
    assert same(bare.scatter, lit.scatter - np.float32(lit.dark_dn["scatter"]))
    assert same(bare.range_mm, lit.range_mm) and bare.to_arrow().equals(lit.to_arrow())
    assert same(sheetlight.open(boards, dark=False).sample(2).scatter, bare.scatter)
    assert same(sheetlight.open(boards).sample(2, dark=False).scatter, bare.scatter)
    # Of 12 bits, 4095 / 255 times as many.
    changes = {**SMALL, "exposure.bits": 12, "extraction.scatter_dark": "subtracted"}
    fine = sheetlight.Recipe.load("wood-small", changes).sample(2, seed=7)
    assert np.isclose(fine.dark_dn["reflectance"], lit.dark_dn["reflectance"] * 4095 / 255, rtol=1e-6)
    assert fine.dark_dn["scatter"] == 0


def test_maps_that_are_left_out_are_told():
    sample = sheetlight.Recipe.load("wood-train", SMALL).sample(0)
    with pytest.raises(KeyError):
        sample.truth["height_mm"]
    with pytest.raises(AttributeError, match="is calibrated, so it is range_mm and not range_px"):
        sample.range_px
    pixel = sheetlight.Recipe.load("wood-small", SMALL, extraction={"range": "uncalibrated"}).sample(0)
    assert pixel.range_unit == "px" and np.nanmax(pixel.range_px) < 832 and not hasattr(pixel, "range_mm")


def test_samples_go_to_other_processes():
    import pickle

    sample = sheetlight.Recipe.load("wood-small", SMALL).sample(1)
    twin = pickle.loads(pickle.dumps(sample))
    assert repr(twin) == repr(sample) and list(twin.maps) == list(sample.maps) and twin.objects == sample.objects
    assert all(same(twin.maps[name], sample.maps[name]) for name in sample.maps) and same(twin.valid, sample.valid)
    assert not twin.label.flags.writeable and twin.parameters == sample.parameters
    with pytest.raises(ValueError, match="came from another process"):
        twin.to_arrow()
