"""Exports and recordings, read by the libraries that they are for. `make test-formats` runs these: the installed package with
python/requirements-formats.txt. What must be there is read from the dataset, never from the export.
"""

import os
import signal
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

# Before anything imports them: what these libraries keep goes into a folder of its own, and they ask no server.
HOME = tempfile.mkdtemp(prefix="formats-")
os.environ.update(
    YOLO_CONFIG_DIR=HOME, YOLO_OFFLINE="true", MPLCONFIGDIR=HOME, HF_HOME=HOME, HF_HUB_OFFLINE="1", NO_ALBUMENTATIONS_UPDATE="1"
)

ROOT = Path(__file__).parents[2]
sys.path.append(str(ROOT / "python"))

import cv2  # noqa: E402
import exports_asked  # noqa: E402
import numpy as np  # noqa: E402
import pytest  # noqa: E402

# A shell that runs tests in the background has them, and what they start, ignore Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)

GEN = Path(sysconfig.get_path("scripts")) / "gen"
IMAGES = "output.png=[range, reflectance, scatter, label, instance]"
SPLITS = "splits={train: 0.5, validation: 0.25, test: 0.25}"


def gen(*arguments):
    """Runs the console script of the wheel."""
    done = subprocess.run([GEN, *map(str, arguments)], capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, (arguments, done.returncode, done.stderr)
    return done


class Made:
    """A dataset, with its rows and images, and exports of it."""

    def __init__(self, recipe, folder):
        self.folder = folder / recipe
        gen("--recipe", recipe, "--n", 10, "--out", self.folder, "--quiet", "--set", IMAGES, "--set", SPLITS)
        self.head, self.rows = exports_asked.stored(self.folder)

    def export(self, name, *options):
        out = self.folder.parent / "-".join([self.folder.name, name, *(word.strip("-") for word in options)])
        gen("export", name, self.folder, "--out", out, *options)
        return out

    def of_split(self, split):
        """Index and sample of a split, in order."""
        return {index: one for index, one in self.rows.items() if one["row"]["split"] == split}


@pytest.fixture(scope="session", params=["blister-small", "wood-small"])
def made(request, tmp_path_factory):
    return Made(request.param, tmp_path_factory.mktemp("datasets"))


def masks(sample, extent="whole"):
    """The objects of a sample, each with its mask by the instance image."""
    found, inside = [], {one["instance"]: one["within"] for one in sample["row"]["objects"]}
    for one in sample["row"]["objects"]:
        members = {one["instance"]}
        for inner in sorted(inside) if extent == "whole" else []:
            if inside[inner] in members:
                members.add(inner)
        mask = np.isin(sample["images"]["instance"], list(members))
        if mask.any():
            found.append((one, mask))
    return found


def parts(mask):
    """How many parts a mask has that do not touch, not even at corners."""
    return cv2.connectedComponents(mask.astype(np.uint8), connectivity=8)[0] - 1


class Difference:
    """How masks of tools differ from those of the dataset: not at all where a mask has one part."""

    def __init__(self):
        self.objects = self.several = self.pixels = self.area = 0

    def add(self, found, wanted):
        off = int((found != wanted).sum())
        count = parts(wanted)
        assert off == 0 or count > 1, f"{off} pixels of {int(wanted.sum())} differ"
        assert not (wanted & ~found.astype(bool)).any(), "a pixel of the mask is lost"
        self.objects, self.several = self.objects + 1, self.several + (count > 1)
        self.pixels, self.area = self.pixels + off, self.area + int(wanted.sum())

    def told(self):
        return f"{self.objects} objects of {self.area} px, {self.several} in several parts: {self.pixels} px more"
