"""What the commands of `gen` do, as functions. Made by python/make_commands.py: change the command, not this file."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from sheetlight._recipe import Recipe
from sheetlight._result import Result
from sheetlight._run import Words, run_command

RecipeLike = Recipe | str | os.PathLike[str] | Mapping[str, Any]
"""A loaded recipe, what `Recipe.load` takes of a name, or a dict of it."""

__all__ = [
    "check",
    "compare",
    "cover",
    "export_coco",
    "export_icon",
    "export_mvtec",
    "export_mvtec3d",
    "export_png",
    "export_webdataset",
    "export_yolo",
    "fibres",
    "finish",
    "fit",
    "icon",
    "list_datasets",
    "preview",
    "recipe_list",
    "recipe_new",
    "recipe_presets",
    "recipe_show",
    "rig",
    "schema",
    "study_laser",
    "study_packs",
    "study_point",
    "study_profile",
    "study_sensor",
    "study_speckle",
    "study_transport",
    "study_triangulation",
    "transport",
]


def check(
    folder: str | os.PathLike[str] | None = None,
    *,
    model: str | os.PathLike[str],
    sidecar: str | os.PathLike[str] | None = None,
    split: Literal["train", "validation", "test", "all"] | None = None,
    slice: Words | Sequence[Words] | None = None,
    batch: int | None = None,
    threads: int | None = None,
    seed: int | None = None,
    worst: int | None = None,
    out: str | os.PathLike[str] | None = None,
    save: bool = False,
    min_accuracy: float | None = None,
    sweep: bool = False,
    recipe: RecipeLike | None = None,
    overrides: Mapping[str, Any] | None = None,
    keys: Words | Sequence[Words] | None = None,
    samples: int | None = None,
    estimate: bool = False,
) -> Result:
    """Run a trained model (ONNX) over a dataset: confusion, accuracy, calibration, slices, the worst answers.

    Args:
        folder: folder of the dataset
        model: the model (ONNX)
        sidecar: what the model takes and answers (YAML or JSON), - for standard input [default: the model's name with .yaml, .yml
            or .json]
        split: part of the dataset; test where it is None
        slice: accuracy by this number too; may be given several times [default: knot width, film pigment, exposure]
        batch: windows that the model gets at once, 1 to 65536 [default: up to 64]
        threads: threads [default: all cores]
        seed: seed of the pixels that are drawn, and of the samples of a sweep; 0 where it is None
        worst: how many of the most confidently wrong answers are kept, at most 1000; 16 where it is None
        out: folder for pictures of them and for the report as check.json; made where it is not there. Of a sweep the folder for
            sweep.json and for what it keeps while it runs [default: MODEL-sweep]
        save: keep the report beside the dataset, as DIR/reports/check-MODEL-SPLIT.json with its pictures, for `gen report`; that of
            the same model file and split is replaced, that of another file of the same name is numbered beside it
        min_accuracy: end with status 3 where the accuracy is below this
        sweep: draw fresh samples of --recipe with each key at both ends and in the middle of its range, and rank the keys by what
            they cost the model
        recipe: a loaded one, the name of a file or of a built-in one, the folder of a dataset, or a dict
        overrides: changes to the recipe, by the path of the key
        keys: with --sweep: the keys [default: every key that varies]
        samples: with --sweep: samples at each value; 60 where it is None
        estimate: with --sweep: say which values would be asked and what it would take, and stop

    Returns:
        What the command prints with `--json`, as a dict with attributes.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "json",
        ["check"],
        places={"folder": folder},
        recipe=recipe,
        overrides=overrides,
        options={
            "--model": model,
            "--sidecar": sidecar,
            "--split": split,
            "--slice": slice,
            "--batch": batch,
            "--threads": threads,
            "--seed": seed,
            "--worst": worst,
            "--out": out,
            "--save": save,
            "--min-accuracy": min_accuracy,
            "--sweep": sweep,
            "--keys": keys,
            "--samples": samples,
            "--estimate": estimate,
        },
        paths=["folder", "model", "sidecar", "out"],
    )


def compare(
    sim: str | os.PathLike[str],
    real: str | os.PathLike[str],
    *,
    scans: int | None = None,
    out: str | os.PathLike[str] | None = None,
    gap: bool = False,
    python: str | os.PathLike[str] | None = None,
    region: Words | None = None,
    mask: str | os.PathLike[str] | None = None,
    sim_region: Words | None = None,
    sim_mask: str | os.PathLike[str] | None = None,
    whole: bool = False,
    mm_per_count: float | None = None,
    um_per_count: float | None = None,
    px_per_count: float | None = None,
    offset: float | None = None,
    missing: Words | None = None,
    col_mm: float | None = None,
    row_mm: float | None = None,
    bits: int | None = None,
    cols: int | None = None,
    csv: Literal["grid", "points"] | None = None,
    reflectance: str | os.PathLike[str] | None = None,
    scatter: str | os.PathLike[str] | None = None,
) -> Result:
    """Put the statistics of a simulated and a real scan side by side: noise, speckle, distances, plots.

    Args:
        sim: simulated side: a dataset, a folder of scans, or a scan
        real: real side, in the same way
        scans: most scans of each side, spread evenly; 8 where it is None
        out: where a page of plots goes (PNG) [default: none is drawn]
        gap: train a classifier to tell both sides apart, and print its accuracy on windows that it has not seen: 0.5 where it
            cannot. Takes a minute or two, and Python with numpy and torch
        python: python for --gap [default: $SHEETLIGHT_PYTHON, else python3]
        region: the part of each scan of REAL that counts [px]
        mask: picture (PNG) of the size of REAL's scans; where it is black, nothing counts
        sim_region: the same as --region for SIM
        sim_mask: the same as --mask for SIM
        whole: of datasets count all pixels, not the object's alone, which their labels tell
        mm_per_count: what one count of Range is, in mm; 1 where the numbers are mm already
        um_per_count: the same in um
        px_per_count: the same in sensor rows, for scans that are not calibrated
        offset: added to heights after that [mm, or px with --px-per-count; default: 0]
        missing: number of Range that stands for a missing height, or none; needed for whole numbers, beside NaN for others
        col_mm: distance between two columns, in mm [default: of points that of their grid; else unknown]
        row_mm: distance between two profiles, in mm [default: of points that of their grid; else unknown]
        bits: bits of the camera's digital numbers; needed for Reflectance and Scatter in files of more than 8 bits
        cols: columns of a cloud of points that is stored profile by profile, missing points too
        csv: what the lines of a CSV file are: profiles of a grid, or points x, y, z [default: what its header says]
        reflectance: reflectance of the side that is one file of Range, on the same grid
        scatter: scatter of that side

    Returns:
        What the command prints with `--json`, as a dict with attributes.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "json",
        ["compare"],
        places={"sim": sim, "real": real},
        options={
            "--scans": scans,
            "--out": out,
            "--gap": gap,
            "--python": python,
            "--region": region,
            "--mask": mask,
            "--sim-region": sim_region,
            "--sim-mask": sim_mask,
            "--whole": whole,
            "--mm-per-count": mm_per_count,
            "--um-per-count": um_per_count,
            "--px-per-count": px_per_count,
            "--offset": offset,
            "--missing": missing,
            "--col-mm": col_mm,
            "--row-mm": row_mm,
            "--bits": bits,
            "--cols": cols,
            "--csv": csv,
            "--reflectance": reflectance,
            "--scatter": scatter,
        },
        paths=["sim", "real", "out", "python", "mask", "sim_mask", "reflectance", "scatter"],
    )


def cover(
    recipe: RecipeLike,
    *,
    overrides: Mapping[str, Any] | None = None,
    real: str | os.PathLike[str] | Sequence[str | os.PathLike[str]] | None = None,
    out: str | os.PathLike[str] | None = None,
    simulations: int | None = None,
    seed: int | None = None,
    threads: int | None = None,
    scans: int | None = None,
    region: Words | None = None,
    mask: str | os.PathLike[str] | None = None,
    mm_per_count: float | None = None,
    um_per_count: float | None = None,
    px_per_count: float | None = None,
    offset: float | None = None,
    missing: Words | None = None,
    col_mm: float | None = None,
    row_mm: float | None = None,
    bits: int | None = None,
    cols: int | None = None,
    csv: Literal["grid", "points"] | None = None,
    reflectance: str | os.PathLike[str] | None = None,
    scatter: str | os.PathLike[str] | None = None,
) -> Result:
    """Say where real scans lie in the spread of a recipe's own, and which keys to widen; without any, what it varies.

    Args:
        recipe: a loaded one, the name of a file or of a built-in one, the folder of a dataset, or a dict
        overrides: changes to the recipe, by the path of the key
        real: scans of the real camera: whatever gen compare reads
        out: where the page goes [default: <recipe name>-cover.html]
        simulations: scans of the recipe as it is; of a dataset its first ones, drawn again; 400 where it is None
        seed: seed of all that is drawn [default: that of the dataset, else 0]
        threads: threads [default: all cores]
        scans: most scans of each --real, spread evenly; 4 where it is None
        region: the part of each real scan that counts [px]; of simulated scans the object alone then counts
        mask: picture (PNG) of the real scans' size; where it is black, nothing counts; of simulated scans the object alone then
            does
        mm_per_count: what one count of Range is, in mm; 1 where the numbers are mm already
        um_per_count: the same in um
        px_per_count: the same in sensor rows, for scans that are not calibrated
        offset: added to heights after that [mm, or px with --px-per-count; default: 0]
        missing: number of Range that stands for a missing height, or none; needed for whole numbers, beside NaN for others
        col_mm: distance between two columns, in mm [default: of points that of their grid; else unknown]
        row_mm: distance between two profiles, in mm [default: of points that of their grid; else unknown]
        bits: bits of the camera's digital numbers; needed for Reflectance and Scatter in files of more than 8 bits
        cols: columns of a cloud of points that is stored profile by profile, missing points too
        csv: what the lines of a CSV file are: profiles of a grid, or points x, y, z [default: what its header says]
        reflectance: reflectance of the side that is one file of Range, on the same grid
        scatter: scatter of that side

    Returns:
        What the command prints with `--json`, as a dict with attributes.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "json",
        ["cover"],
        recipe=recipe,
        overrides=overrides,
        options={
            "--real": real,
            "--out": out,
            "--simulations": simulations,
            "--seed": seed,
            "--threads": threads,
            "--scans": scans,
            "--region": region,
            "--mask": mask,
            "--mm-per-count": mm_per_count,
            "--um-per-count": um_per_count,
            "--px-per-count": px_per_count,
            "--offset": offset,
            "--missing": missing,
            "--col-mm": col_mm,
            "--row-mm": row_mm,
            "--bits": bits,
            "--cols": cols,
            "--csv": csv,
            "--reflectance": reflectance,
            "--scatter": scatter,
        },
        paths=["real", "out", "mask", "reflectance", "scatter"],
    )


def export_coco(
    folder: str | os.PathLike[str],
    *,
    out: str | os.PathLike[str],
    split: Literal["train", "validation", "test", "all"] | None = None,
    index: Words | Sequence[Words] | None = None,
    threads: int | None = None,
    image: Literal["reflectance", "scatter", "grey", "range", "rgb"] | None = None,
    range_ends: Words | None = None,
    scatter_ends: Words | None = None,
    bits: Literal["8", "16"] | None = None,
    mask: Literal["whole", "own"] | None = None,
    plain_rle: bool = False,
    polygons: bool = False,
) -> Result:
    """COCO instances: pictures, boxes, run-length masks, one document for each split.

    Args:
        folder: folder of the dataset
        out: folder of the export: a new or empty one, or that of the same export, stopped
        split: part of the dataset; all where it is None
        index: samples by number: 3, 0-99, or several: 0-99,205 [default: all]
        threads: threads [default: all cores]
        image: what pictures show; rgb is Range, Reflectance and Scatter as red, green and blue; reflectance where it is None
        range_ends: heights (or sensor rows) at the ends of 8 bits [default: from 64 samples of the dataset]
        scatter_ends: scatter at the ends of 8 bits, in DN [default: from 64 samples of the dataset]
        bits: 16 writes one map as it is stored instead of scaling it to 8 bits; 8 where it is None
        mask: pixels of an object that others lie in: with them, or its own alone; whole where it is None
        plain_rle: masks as lists of run lengths instead of packed strings
        polygons: masks as polygons instead of run lengths: one for each part of an object, with bridges to its holes

    Returns:
        What the command prints with `--json`, as a dict with attributes.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "json",
        ["export", "coco"],
        places={"folder": folder},
        options={
            "--out": out,
            "--split": split,
            "--index": index,
            "--threads": threads,
            "--image": image,
            "--range-ends": range_ends,
            "--scatter-ends": scatter_ends,
            "--bits": bits,
            "--mask": mask,
            "--plain-rle": plain_rle,
            "--polygons": polygons,
        },
        paths=["folder", "out"],
    )


def export_icon(
    folder: str | os.PathLike[str],
    *,
    out: str | os.PathLike[str],
    split: Literal["train", "validation", "test", "all"] | None = None,
    index: Words | Sequence[Words] | None = None,
    threads: int | None = None,
    words: bool = False,
    rate: float | None = None,
    sensor: bool = False,
) -> Result:
    """Files of the real camera (iCon .dat and .xml), one pair for each sample.

    Args:
        folder: folder of the dataset
        out: folder of the export: a new or empty one, or that of the same export, stopped
        split: part of the dataset; all where it is None
        index: samples by number: 3, 0-99, or several: 0-99,205 [default: all]
        threads: threads [default: all cores]
        words: heights as WORD instead of FLOAT
        rate: profiles a second, for the timestamps in Mark [default: 1000]
        sensor: the middle sensor frame of each sample instead of its scan

    Returns:
        What the command prints with `--json`, as a dict with attributes.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "json",
        ["export", "icon"],
        places={"folder": folder},
        options={
            "--out": out,
            "--split": split,
            "--index": index,
            "--threads": threads,
            "--words": words,
            "--rate": rate,
            "--sensor": sensor,
        },
        paths=["folder", "out"],
    )


def export_mvtec(
    folder: str | os.PathLike[str],
    *,
    out: str | os.PathLike[str],
    split: Literal["train", "validation", "test", "all"] | None = None,
    index: Words | Sequence[Words] | None = None,
    threads: int | None = None,
    image: Literal["reflectance", "scatter", "grey", "range", "rgb"] | None = None,
    range_ends: Words | None = None,
    scatter_ends: Words | None = None,
    good: Words | Sequence[Words] | None = None,
    patch_px: int | None = None,
) -> Result:
    """Folders as MVTec AD has them: train/good, test/good, test/<defect>, ground_truth/<defect>.

    Args:
        folder: folder of the dataset
        out: folder of the export: a new or empty one, or that of the same export, stopped
        split: part of the dataset; all where it is None
        index: samples by number: 3, 0-99, or several: 0-99,205 [default: all]
        threads: threads [default: all cores]
        image: what pictures show; rgb is Range, Reflectance and Scatter as red, green and blue; reflectance where it is None
        range_ends: heights (or sensor rows) at the ends of 8 bits [default: from 64 samples of the dataset]
        scatter_ends: scatter at the ends of 8 bits, in DN [default: from 64 samples of the dataset]
        good: pixel classes that count as good [default: clear of wood, flange and pocket of packs; none of others]
        patch_px: cut pictures into square patches of this side, good or not by their own pixels

    Returns:
        What the command prints with `--json`, as a dict with attributes.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "json",
        ["export", "mvtec"],
        places={"folder": folder},
        options={
            "--out": out,
            "--split": split,
            "--index": index,
            "--threads": threads,
            "--image": image,
            "--range-ends": range_ends,
            "--scatter-ends": scatter_ends,
            "--good": good,
            "--patch-px": patch_px,
        },
        paths=["folder", "out"],
    )


def export_mvtec3d(
    folder: str | os.PathLike[str],
    *,
    out: str | os.PathLike[str],
    split: Literal["train", "validation", "test", "all"] | None = None,
    index: Words | Sequence[Words] | None = None,
    threads: int | None = None,
    image: Literal["reflectance", "scatter", "grey", "range", "rgb"] | None = None,
    range_ends: Words | None = None,
    scatter_ends: Words | None = None,
    good: Words | Sequence[Words] | None = None,
    patch_px: int | None = None,
) -> Result:
    """Folders as MVTec 3D-AD has them: rgb, xyz and gt of each picture.

    Args:
        folder: folder of the dataset
        out: folder of the export: a new or empty one, or that of the same export, stopped
        split: part of the dataset; all where it is None
        index: samples by number: 3, 0-99, or several: 0-99,205 [default: all]
        threads: threads [default: all cores]
        image: what pictures show; rgb is Range, Reflectance and Scatter as red, green and blue; reflectance where it is None
        range_ends: heights (or sensor rows) at the ends of 8 bits [default: from 64 samples of the dataset]
        scatter_ends: scatter at the ends of 8 bits, in DN [default: from 64 samples of the dataset]
        good: pixel classes that count as good [default: clear of wood, flange and pocket of packs; none of others]
        patch_px: cut pictures into square patches of this side, good or not by their own pixels

    Returns:
        What the command prints with `--json`, as a dict with attributes.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "json",
        ["export", "mvtec3d"],
        places={"folder": folder},
        options={
            "--out": out,
            "--split": split,
            "--index": index,
            "--threads": threads,
            "--image": image,
            "--range-ends": range_ends,
            "--scatter-ends": scatter_ends,
            "--good": good,
            "--patch-px": patch_px,
        },
        paths=["folder", "out"],
    )


def export_png(
    folder: str | os.PathLike[str],
    *,
    out: str | os.PathLike[str],
    split: Literal["train", "validation", "test", "all"] | None = None,
    index: Words | Sequence[Words] | None = None,
    threads: int | None = None,
    maps: Literal["range", "reflectance", "scatter", "grey", "label", "instance"] | Sequence[Literal["range", "reflectance", "scatter", "grey", "label", "instance"]] | None = None,
    colour: bool = False,
) -> Result:
    """Folders of PNG files as they are stored, and the rows as lines of JSON.

    Args:
        folder: folder of the dataset
        out: folder of the export: a new or empty one, or that of the same export, stopped
        split: part of the dataset; all where it is None
        index: samples by number: 3, 0-99, or several: 0-99,205 [default: all]
        threads: threads [default: all cores]
        maps: maps [default: all that the dataset has]
        colour: labels as coloured pictures too

    Returns:
        What the command prints with `--json`, as a dict with attributes.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "json",
        ["export", "png"],
        places={"folder": folder},
        options={
            "--out": out,
            "--split": split,
            "--index": index,
            "--threads": threads,
            "--maps": maps,
            "--colour": colour,
        },
        paths=["folder", "out"],
    )


def export_webdataset(
    folder: str | os.PathLike[str],
    *,
    out: str | os.PathLike[str],
    split: Literal["train", "validation", "test", "all"] | None = None,
    index: Words | Sequence[Words] | None = None,
    threads: int | None = None,
    maps: Literal["range", "reflectance", "scatter", "grey", "label", "instance"] | Sequence[Literal["range", "reflectance", "scatter", "grey", "label", "instance"]] | None = None,
    tar_mb: int | None = None,
) -> Result:
    """WebDataset tars: every map as PNG and every number as JSON.

    Args:
        folder: folder of the dataset
        out: folder of the export: a new or empty one, or that of the same export, stopped
        split: part of the dataset; all where it is None
        index: samples by number: 3, 0-99, or several: 0-99,205 [default: all]
        threads: threads [default: all cores]
        maps: maps [default: all that the dataset has]
        tar_mb: largest tar, in MB; a sample that is larger has one for itself; 500 where it is None

    Returns:
        What the command prints with `--json`, as a dict with attributes.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "json",
        ["export", "webdataset"],
        places={"folder": folder},
        options={
            "--out": out,
            "--split": split,
            "--index": index,
            "--threads": threads,
            "--maps": maps,
            "--tar-mb": tar_mb,
        },
        paths=["folder", "out"],
    )


def export_yolo(
    folder: str | os.PathLike[str],
    *,
    out: str | os.PathLike[str],
    split: Literal["train", "validation", "test", "all"] | None = None,
    index: Words | Sequence[Words] | None = None,
    threads: int | None = None,
    image: Literal["reflectance", "scatter", "grey", "range", "rgb"] | None = None,
    range_ends: Words | None = None,
    scatter_ends: Words | None = None,
    task: Literal["detect", "segment"] | None = None,
    mask: Literal["whole", "own"] | None = None,
) -> Result:
    """Folders as Ultralytics trains from: pictures of 8 bits, labels as text, data.yaml.

    Args:
        folder: folder of the dataset
        out: folder of the export: a new or empty one, or that of the same export, stopped
        split: part of the dataset; all where it is None
        index: samples by number: 3, 0-99, or several: 0-99,205 [default: all]
        threads: threads [default: all cores]
        image: what pictures show; rgb is Range, Reflectance and Scatter as red, green and blue; reflectance where it is None
        range_ends: heights (or sensor rows) at the ends of 8 bits [default: from 64 samples of the dataset]
        scatter_ends: scatter at the ends of 8 bits, in DN [default: from 64 samples of the dataset]
        task: what labels are: boxes, or polygons; segment where it is None
        mask: pixels of an object that others lie in: with them, or its own alone; whole where it is None

    Returns:
        What the command prints with `--json`, as a dict with attributes.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "json",
        ["export", "yolo"],
        places={"folder": folder},
        options={
            "--out": out,
            "--split": split,
            "--index": index,
            "--threads": threads,
            "--image": image,
            "--range-ends": range_ends,
            "--scatter-ends": scatter_ends,
            "--task": task,
            "--mask": mask,
        },
        paths=["folder", "out"],
    )


def fibres(
    picture: str | os.PathLike[str],
    *,
    pixel_mm: Words,
    encoding: Literal["linear", "srgb", "gamma"],
    gamma: float | None = None,
    length: Literal["down", "across"] | None = None,
    face: Literal["bark", "pith"] | None = None,
    board_mm: Words | None = None,
    least_knot_mm: float | None = None,
    out: str | os.PathLike[str] | None = None,
) -> Result:
    """Find fibre directions, knots and absorption of a board in a picture of it.

    Args:
        picture: JPEG, PNG, TIFF or BMP, - for standard input; of a colour picture the red channel counts, nearest to the laser. A
            dark belt around the board is cut off
        pixel_mm: size of a pixel, or down the rows and across them [mm]
        encoding: how its numbers go with light; absorption follows from light
        gamma: the power of light that a number to 1 is turned into, for `--encoding gamma`
        length: which way the length of the board lies in it; fibres run within 45 degrees of that; down where it is None
        face: which side of the board it shows; bark where it is None
        board_mm: length (down the rows) and width of the board, if the picture shows all of it: its size is then checked [mm]
        least_knot_mm: least width of a knot [mm]; 2 where it is None
        out: where the maps go [default: the picture's name with .fibres.exr]; a picture of them lies beside it, .png

    Returns:
        What the command prints with `--json`, as a dict with attributes.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "json",
        ["fibres"],
        places={"picture": picture},
        options={
            "--pixel-mm": pixel_mm,
            "--encoding": encoding,
            "--gamma": gamma,
            "--length": length,
            "--face": face,
            "--board-mm": board_mm,
            "--least-knot-mm": least_knot_mm,
            "--out": out,
        },
        paths=["picture", "out"],
    )


def finish(
    folder: str | os.PathLike[str],
) -> Result:
    """Write card and metadata of a dataset from its dataset.json and manifests alone: its other files may lie elsewhere.

    Args:
        folder: folder with dataset.json and shards/; README.md and croissant.json are written there

    Returns:
        What the command prints with `--json`, as a dict with attributes.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "json",
        ["finish"],
        places={"folder": folder},
        paths=["folder"],
    )


def fit(
    recipe: RecipeLike,
    *,
    overrides: Mapping[str, Any] | None = None,
    real: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    keys: Words | Sequence[Words] | None = None,
    out: str | os.PathLike[str] | None = None,
    time: Words | None = None,
    simulations: int | None = None,
    rounds: int | None = None,
    one_object: bool = False,
    classes: Words | Sequence[Words] | None = None,
    matter: str | os.PathLike[str] | None = None,
    seed: int | None = None,
    threads: int | None = None,
    scans: int | None = None,
    region: Words | None = None,
    mask: str | os.PathLike[str] | None = None,
    mm_per_count: float | None = None,
    um_per_count: float | None = None,
    px_per_count: float | None = None,
    offset: float | None = None,
    missing: Words | None = None,
    col_mm: float | None = None,
    row_mm: float | None = None,
    bits: int | None = None,
    cols: int | None = None,
    csv: Literal["grid", "points"] | None = None,
    reflectance: str | os.PathLike[str] | None = None,
    scatter: str | os.PathLike[str] | None = None,
) -> Result:
    """Turn scans of a real camera into a recipe: which values of its keys make simulated scans look like them.

    Args:
        recipe: a loaded one, the name of a file or of a built-in one, the folder of a dataset, or a dict
        overrides: changes to the recipe, by the path of the key
        real: scans of the real camera: whatever gen compare reads
        keys: keys to fit [default: every key of bench and matter that the recipe draws from a distribution]
        out: where the recipe goes; the page beside it [default: <recipe name>-fitted.yaml]
        time: begin no round of simulated scans that would not end within this time: 90s, 20m, 2h; 20m where it is None
        simulations: simulated scans, all rounds together; 3000 where it is None
        rounds: rounds in which they are made, each nearer to the real scans; 7 where it is None
        one_object: all scans are of one object: matter, too, is common to them
        classes: class of the recipe that each scan is of, in their order: one matter and one bench, scanned in several ways
        matter: where what is found of matter goes alone, for other recipes: `extends: [wood, FILE]`
        seed: seed of all that is drawn; 0 where it is None
        threads: threads [default: all cores]
        scans: most scans of each --real, spread evenly; 4 where it is None
        region: the part of each real scan that counts [px]; of simulated scans the object alone then counts
        mask: picture (PNG) of the real scans' size; where it is black, nothing counts; of simulated scans the object alone then
            does
        mm_per_count: what one count of Range is, in mm; 1 where the numbers are mm already
        um_per_count: the same in um
        px_per_count: the same in sensor rows, for scans that are not calibrated
        offset: added to heights after that [mm, or px with --px-per-count; default: 0]
        missing: number of Range that stands for a missing height, or none; needed for whole numbers, beside NaN for others
        col_mm: distance between two columns, in mm [default: of points that of their grid; else unknown]
        row_mm: distance between two profiles, in mm [default: of points that of their grid; else unknown]
        bits: bits of the camera's digital numbers; needed for Reflectance and Scatter in files of more than 8 bits
        cols: columns of a cloud of points that is stored profile by profile, missing points too
        csv: what the lines of a CSV file are: profiles of a grid, or points x, y, z [default: what its header says]
        reflectance: reflectance of the side that is one file of Range, on the same grid
        scatter: scatter of that side

    Returns:
        What the command prints with `--json`, as a dict with attributes.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "json",
        ["fit"],
        recipe=recipe,
        overrides=overrides,
        options={
            "--real": real,
            "--keys": keys,
            "--out": out,
            "--time": time,
            "--simulations": simulations,
            "--rounds": rounds,
            "--one-object": one_object,
            "--classes": classes,
            "--matter": matter,
            "--seed": seed,
            "--threads": threads,
            "--scans": scans,
            "--region": region,
            "--mask": mask,
            "--mm-per-count": mm_per_count,
            "--um-per-count": um_per_count,
            "--px-per-count": px_per_count,
            "--offset": offset,
            "--missing": missing,
            "--col-mm": col_mm,
            "--row-mm": row_mm,
            "--bits": bits,
            "--cols": cols,
            "--csv": csv,
            "--reflectance": reflectance,
            "--scatter": scatter,
        },
        paths=["real", "out", "matter", "mask", "reflectance", "scatter"],
    )


def icon(
    path: str | os.PathLike[str],
) -> Result:
    """Say what files of the real camera (iCon .dat and .xml) hold.

    Args:
        path: the .xml of a file to look at, with its .dat beside it

    Returns:
        What the command prints with `--json`, as a dict with attributes.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "json",
        ["icon"],
        places={"path": path},
        paths=["path"],
    )


def list_datasets(
    folders: str | os.PathLike[str] | Sequence[str | os.PathLike[str]] | None = None,
) -> list[Result]:
    """List datasets with their facts: recipe, seed, samples, classes, splits, size.

    Args:
        folders: folders of datasets, or folders that hold some; out where it is None

    Returns:
        What the command prints with `--json`, an entry each.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "list",
        ["list"],
        places={"folders": folders},
        paths=["folders"],
    )


def preview(
    recipe: RecipeLike,
    *,
    overrides: Mapping[str, Any] | None = None,
    index: int | None = None,
    seed: int | None = None,
    out: str | os.PathLike[str] | None = None,
) -> Path:
    """Draw one sample: sensor frame, Range, Reflectance, Scatter and labels side by side.

    Args:
        recipe: a loaded one, the name of a file or of a built-in one, the folder of a dataset, or a dict
        overrides: changes to the recipe, by the path of the key
        index: which sample; 0 where it is None
        seed: seed [default: that of the dataset whose folder --recipe names, else 0]
        out: where the picture goes (PNG); - for standard output; preview.png where it is None

    Returns:
        Where it is.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "place",
        ["preview"],
        recipe=recipe,
        overrides=overrides,
        options={
            "--index": index,
            "--seed": seed,
            "--out": out,
        },
        paths=["out"],
    )


def recipe_list(
) -> list[Result]:
    """List the recipes that are built in.

    Args:

    Returns:
        What the command prints with `--json`, an entry each.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "list",
        ["recipe", "list"],
    )


def recipe_new(
    *,
    subject: Literal["wood", "blister", "sawtooth", "mesh"],
) -> str:
    """Print a first recipe, to be changed: at most 20 lines with comments.

    Args:
        subject: what the objects are

    Returns:
        What it prints.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "text",
        ["recipe", "new"],
        options={
            "--subject": subject,
        },
    )


def recipe_presets(
) -> list[Result]:
    """List the presets: what data sheets say of cameras, lasers and materials, with sources.

    Args:

    Returns:
        What the command prints with `--json`, an entry each.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "list",
        ["recipe", "presets"],
    )


def recipe_show(
    recipe: RecipeLike,
    *,
    overrides: Mapping[str, Any] | None = None,
    flat: bool = False,
) -> Result:
    """Print the text of a recipe.

    Args:
        recipe: a loaded one, the name of a file or of a built-in one, the folder of a dataset, or a dict
        overrides: changes to the recipe, by the path of the key
        flat: print one text of what it states and what it inherits

    Returns:
        What the command prints with `--json`, as a dict with attributes.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "json",
        ["recipe", "show"],
        recipe=recipe,
        overrides=overrides,
        options={
            "--flat": flat,
        },
    )


def rig(
    recipe: RecipeLike,
    *,
    overrides: Mapping[str, Any] | None = None,
    index: int | None = None,
    seed: int | None = None,
    strict: bool = False,
) -> Result:
    """Say what the rig of a recipe is: field of view, resolution, line, exposure, speckle, noise, with warnings.

    Args:
        recipe: a loaded one, the name of a file or of a built-in one, the folder of a dataset, or a dict
        overrides: changes to the recipe, by the path of the key
        index: which sample's draws; 0 where it is None
        seed: seed [default: that of the dataset whose folder is named, else 0]
        strict: take warnings as errors: the numbers are printed, and the exit status is 1

    Returns:
        What the command prints with `--json`, as a dict with attributes.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "json",
        ["rig"],
        recipe=recipe,
        overrides=overrides,
        options={
            "--index": index,
            "--seed": seed,
            "--strict": strict,
        },
    )


def schema(
    what: Literal["recipe", "dataset", "recipe-reference", "commands"],
) -> str:
    """Print the JSON Schema of recipes or of datasets, or the reference of recipe keys.

    Args:
        what: what to print

    Returns:
        What it prints.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "text",
        ["schema"],
        places={"what": what},
    )


def study_laser(
    *,
    out: str | os.PathLike[str] | None = None,
    seed: int | None = None,
    threads: int | None = None,
    repeats: int | None = None,
) -> Path:
    """The laser line: width over height, evenness along it, electrons a column.

    Args:
        out: folder for the JSON file and the picture, or the picture's own name, ending in .png; folders are made; out/study where
            it is None
        seed: seed of all chance [default: that of the dataset whose folder --recipe names, else 0]
        threads: threads [default: all cores]
        repeats: independent repeats, from whose spread errors come [default: 16]

    Returns:
        Where it is.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "place",
        ["study", "laser"],
        options={
            "--out": out,
            "--seed": seed,
            "--threads": threads,
            "--repeats": repeats,
        },
        paths=["out"],
    )


def study_packs(
    *,
    out: str | os.PathLike[str] | None = None,
    seed: int | None = None,
    threads: int | None = None,
    recipe: RecipeLike | None = None,
    overrides: Mapping[str, Any] | None = None,
) -> Path:
    """One blister pack of each defect: Range, Reflectance, Scatter, and means of the pockets concerned.

    Args:
        out: folder for the JSON file and the picture, or the picture's own name, ending in .png; folders are made; out/study where
            it is None
        seed: seed of all chance [default: that of the dataset whose folder --recipe names, else 0]
        threads: threads [default: all cores]
        recipe: a loaded one, the name of a file or of a built-in one, the folder of a dataset, or a dict; blister-small where it is
            None
        overrides: changes to the recipe, by the path of the key

    Returns:
        Where it is.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "place",
        ["study", "packs"],
        recipe=recipe,
        overrides=overrides,
        options={
            "--out": out,
            "--seed": seed,
            "--threads": threads,
        },
        paths=["out"],
    )


def study_point(
    *,
    out: str | os.PathLike[str] | None = None,
    seed: int | None = None,
    threads: int | None = None,
    photons: int | None = None,
) -> Path:
    """A point of light on clear wood and on a knot: the ellipses that it makes.

    Args:
        out: folder for the JSON file and the picture, or the picture's own name, ending in .png; folders are made; out/study where
            it is None
        seed: seed of all chance [default: that of the dataset whose folder --recipe names, else 0]
        threads: threads [default: all cores]
        photons: photons for each question [default: 1000000 for point, 300000 for transport, 2000000 for profile]

    Returns:
        Where it is.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "place",
        ["study", "point"],
        options={
            "--out": out,
            "--seed": seed,
            "--threads": threads,
            "--photons": photons,
        },
        paths=["out"],
    )


def study_profile(
    recipe: RecipeLike,
    *,
    overrides: Mapping[str, Any] | None = None,
    index: int | None = None,
    profile: int | None = None,
    out: str | os.PathLike[str] | None = None,
    seed: int | None = None,
    threads: int | None = None,
    photons: int | None = None,
) -> Path:
    """One profile of a recipe's sample by every model, with the reference's standard errors.

    Args:
        recipe: a loaded one, the name of a file or of a built-in one, the folder of a dataset, or a dict
        overrides: changes to the recipe, by the path of the key
        index: which sample; 0 where it is None
        profile: which profile of it [default: the middle one]
        out: folder for the JSON file and the picture, or the picture's own name, ending in .png; folders are made; out/study where
            it is None
        seed: seed of all chance [default: that of the dataset whose folder --recipe names, else 0]
        threads: threads [default: all cores]
        photons: photons for each question [default: 1000000 for point, 300000 for transport, 2000000 for profile]

    Returns:
        Where it is.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "place",
        ["study", "profile"],
        recipe=recipe,
        overrides=overrides,
        options={
            "--index": index,
            "--profile": profile,
            "--out": out,
            "--seed": seed,
            "--threads": threads,
            "--photons": photons,
        },
        paths=["out"],
    )


def study_sensor(
    *,
    out: str | os.PathLike[str] | None = None,
    seed: int | None = None,
    threads: int | None = None,
    repeats: int | None = None,
) -> Path:
    """Photon transfer: gain, noise, linearity, full well, rows that stand out.

    Args:
        out: folder for the JSON file and the picture, or the picture's own name, ending in .png; folders are made; out/study where
            it is None
        seed: seed of all chance [default: that of the dataset whose folder --recipe names, else 0]
        threads: threads [default: all cores]
        repeats: independent repeats, from whose spread errors come [default: 16]

    Returns:
        Where it is.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "place",
        ["study", "sensor"],
        options={
            "--out": out,
            "--seed": seed,
            "--threads": threads,
            "--repeats": repeats,
        },
        paths=["out"],
    )


def study_speckle(
    *,
    out: str | os.PathLike[str] | None = None,
    seed: int | None = None,
    threads: int | None = None,
    repeats: int | None = None,
) -> Path:
    """Speckle: contrast in a pixel, its law, correlation and movement, what it does to the line's centre.

    Args:
        out: folder for the JSON file and the picture, or the picture's own name, ending in .png; folders are made; out/study where
            it is None
        seed: seed of all chance [default: that of the dataset whose folder --recipe names, else 0]
        threads: threads [default: all cores]
        repeats: independent repeats, from whose spread errors come [default: 16]

    Returns:
        Where it is.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "place",
        ["study", "speckle"],
        options={
            "--out": out,
            "--seed": seed,
            "--threads": threads,
            "--repeats": repeats,
        },
        paths=["out"],
    )


def study_transport(
    *,
    out: str | os.PathLike[str] | None = None,
    seed: int | None = None,
    threads: int | None = None,
    photons: int | None = None,
) -> Path:
    """A line of light on fifteen media: reflectance, spread, asymmetry.

    Args:
        out: folder for the JSON file and the picture, or the picture's own name, ending in .png; folders are made; out/study where
            it is None
        seed: seed of all chance [default: that of the dataset whose folder --recipe names, else 0]
        threads: threads [default: all cores]
        photons: photons for each question [default: 1000000 for point, 300000 for transport, 2000000 for profile]

    Returns:
        Where it is.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "place",
        ["study", "transport"],
        options={
            "--out": out,
            "--seed": seed,
            "--threads": threads,
            "--photons": photons,
        },
        paths=["out"],
    )


def study_triangulation(
    *,
    out: str | os.PathLike[str] | None = None,
    seed: int | None = None,
    threads: int | None = None,
    repeats: int | None = None,
) -> Path:
    """Flat targets, level and tilted: errors of Range, height of a row, width of a column.

    Args:
        out: folder for the JSON file and the picture, or the picture's own name, ending in .png; folders are made; out/study where
            it is None
        seed: seed of all chance [default: that of the dataset whose folder --recipe names, else 0]
        threads: threads [default: all cores]
        repeats: independent repeats, from whose spread errors come [default: 16]

    Returns:
        Where it is.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "place",
        ["study", "triangulation"],
        options={
            "--out": out,
            "--seed": seed,
            "--threads": threads,
            "--repeats": repeats,
        },
        paths=["out"],
    )


def transport(
    *,
    medium: str | os.PathLike[str],
    model: Literal["path", "diffusion", "kernel"],
    photons: int | None = None,
    seed: int | None = None,
    out: str | os.PathLike[str] | None = None,
    threads: int | None = None,
) -> Result:
    """Ask a model of light inside matter about plane layers: reflectance, spread, angles, with standard errors.

    Args:
        medium: layers and question: a YAML file, - for standard input, or one that is built in (clear-wood, sealed-flange, ...)
        model: who is asked
        photons: photons to walk, rounded up to 128 equal batches; models without chance take no notice; 1000000 where it is None
        seed: seed of all chance; 0 where it is None
        out: where the answer goes (JSON); - for standard output [default: standard output]
        threads: threads [default: all cores]

    Returns:
        The answer, also where `out` takes it; a dict with attributes.

    Raises:
        GenError: in the program's words.
    """
    return run_command(
        "answer",
        ["transport"],
        options={
            "--medium": medium,
            "--model": model,
            "--photons": photons,
            "--seed": seed,
            "--out": out,
            "--threads": threads,
        },
        paths=["medium", "out"],
    )
