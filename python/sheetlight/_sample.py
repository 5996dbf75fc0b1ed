"""One sample: maps as NumPy arrays, labels, objects and numbers."""

from __future__ import annotations

import contextlib
import copy
import html
import json
import math
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import matplotlib.figure
    import numpy as np
    import pyarrow
    from numpy.typing import NDArray

    from sheetlight import _sheetlight

TRUTH = {
    "height_mm": "Height of the surface [mm].",
    "fibre_azimuth_deg": "Angle of the fibre in the surface against the scan direction [deg].",
    "fibre_dive_deg": "Angle by which the fibre runs below the surface [deg].",
    "film_thickness_mm": "Thickness of the film [mm]; 0 where there is none.",
    "film_gap_mm": "Air between the film and what it covers [mm].",
}
"""Maps of noise-free truth, each with its meaning; those of other subjects are not there."""


class Facts:
    """What all samples of a recipe or dataset have in common: the head of the dataset."""

    __slots__ = ("head",)

    def __init__(self, head: dict[str, Any]) -> None:
        self.head = head

    @property
    def range_unit(self) -> str:
        """Unit of Range."""
        return "px" if self.head["images"]["range"] == "uncalibrated" else "mm"

    def __reduce__(self) -> tuple[Any, ...]:
        # The texts of a recipe and the descriptions of hundreds of numbers are not needed for a sample.
        needed = ("classes", "pixel_classes", "images", "subject")
        head = {key: self.head[key] for key in needed}
        head["parameters"] = [{"group": number["group"], "key": number["key"]} for number in self.head["parameters"]]
        return Facts, (head,)


class Sample:
    """One sample, rendered or read: the same attributes either way.

    Maps are arrays `[rows, cols]`: row 0 was exposed first, columns run along the laser line. They cannot be written to; `copy()`
    one that you want to change. A map that recipe or dataset leave out is no attribute: reading it raises an AttributeError with
    the reason, and `maps` lists those that are there.
    """

    __slots__ = ("_raw", "_facts", "_row", "_cache", "_dark", "_reading")

    def __init__(
        self,
        raw: _sheetlight.Sample,
        facts: Facts,
        *,
        dark: bool = True,
        reading: Callable[[], contextlib.AbstractContextManager[None]] = contextlib.nullcontext,
    ) -> None:
        # `reading` is put around what may raise.
        self._reading = reading
        self._raw: _sheetlight.Sample | None = raw
        self._facts = facts
        self._row: dict[str, Any] = json.loads(raw.numbers)
        self._cache: dict[str, Any] = {}
        self._dark = dark

    def __repr__(self) -> str:
        return f"<Sample {self.index} of seed {self.seed}: {self.class_name}, {self.split}, {self.shape[0]} x {self.shape[1]} px>"

    def _repr_html_(self) -> str:
        from sheetlight._picture import as_html

        return f"<div>{html.escape(repr(self))}</div>{as_html(self)}"

    def __getstate__(self) -> dict[str, Any]:
        maps = {name: self._map(name) for name in self._names()}
        return {"facts": self._facts, "row": self._row, "maps": maps, "frames": self.frames, "dark": self._dark}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self._raw, self._facts, self._row, self._dark = None, state["facts"], state["row"], state["dark"]
        self._reading = contextlib.nullcontext
        for array in (*state["maps"].values(), *state["frames"].values()):
            array.flags.writeable = False
        self._cache = {**state["maps"], "frames": state["frames"]}
        self._cache["names"] = list(state["maps"])

    # What it is.

    @property
    def index(self) -> int:
        """Its number, from 0."""
        return self._row["index"]

    @property
    def seed(self) -> int:
        """Seed of all draws."""
        return self._row["seed"]

    @property
    def id(self) -> str:
        """UUID that follows from recipe, seed and index."""
        return self._row["id"]

    @property
    def split(self) -> str:
        """Part of a dataset that it belongs to: "train", "validation" or "test"."""
        return self._row["split"]

    @property
    def class_name(self) -> str:
        """Class of the recipe that it was drawn from."""
        return self._facts.head["classes"][self._row["class"]]

    @property
    def class_index(self) -> int:
        """The same as its position among the recipe's classes."""
        return self._row["class"]

    @property
    def pixel_classes(self) -> list[str]:
        """Names of the classes of pixels; the position is the value in `label`."""
        return self._facts.head["pixel_classes"]

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the maps [px]."""
        return self._row["rows"], self._row["cols"]

    @property
    def row_mm(self) -> float:
        """Distance between two rows [mm]."""
        return self._row["row_mm"]

    @property
    def col_mm(self) -> float:
        """Distance between two columns at the height of the upper surface [mm]."""
        return self._row["col_mm"]

    @property
    def range_form(self) -> str:
        """What Range is: "calibrated" or "rectified" [mm], or "uncalibrated" [px]."""
        return self._facts.head["images"]["range"]

    @property
    def range_unit(self) -> str:
        """Unit of Range: "mm", or "px" where it is uncalibrated."""
        return self._facts.range_unit

    # What was measured.

    @property
    def range_mm(self) -> NDArray[np.float32]:
        """Range: measured height [mm], float32; NaN where missing. Not there where the recipe's `range_form` is "uncalibrated"."""
        return self._range("mm")

    @property
    def range_px(self) -> NDArray[np.float32]:
        """Range of uncalibrated scans: sensor row of the line [px], row 0 at the top, float32; NaN where missing."""
        return self._range("px")

    @property
    def reflectance(self) -> NDArray[np.float32]:
        """Digital number at the peak of the laser line [DN], float32; NaN where missing. Dark level included, unless `dark=False`."""
        return self._measured("reflectance")

    @property
    def scatter(self) -> NDArray[np.float32]:
        """Sum of digital numbers beside the peak [DN], float32; NaN where missing. Dark level included, unless `dark=False`."""
        return self._measured("scatter")

    @property
    def grey(self) -> NDArray[np.float32]:
        """Digital number under lamps beside the laser [DN], float32; NaN where the lens does not see the pixel's point.

        Only where the recipe has `lamps`. Dark level included, unless `dark=False`.
        """
        return self._measured("grey")

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Whether a pixel is measured, bool."""
        import numpy as np

        if "valid" not in self._cache:
            held = self._names()
            name = next((name for name in ("range", "reflectance", "scatter") if name in held), None)
            if name is None:
                raise AttributeError("nothing measured is kept of this sample, so what is missing is not known")
            self._cache["valid"] = ~np.isnan(self._map(name))
            self._cache["valid"].flags.writeable = False
        return self._cache["valid"]

    @property
    def frames(self) -> dict[int, NDArray[np.uint16]]:
        """Sensor frames that the recipe keeps (`output.sensor_stack`), by the number of the profile: uint16 `[sensor rows, sensor columns]` [DN]."""
        if "frames" not in self._cache:
            with self._reading():
                self._cache["frames"] = self._there().frames()
        return self._cache["frames"]

    # What is true.

    @property
    def label(self) -> NDArray[np.uint8]:
        """Class of what each pixel really shows, uint8: a position in `pixel_classes`; 0 for background."""
        return self._map("label")

    @property
    def instance(self) -> NDArray[np.uint16]:
        """Which defect, pocket, tooth or part each pixel really shows, uint16: `instance` of `objects`; 0 for none."""
        return self._map("instance")

    @property
    def truth(self) -> Mapping[str, NDArray[np.float32]]:
        """Noise-free truth by name (`height_mm`, `fibre_azimuth_deg`, ...), float32; NaN off the object.

        Only where the recipe asks for it (`output.truth_maps`).
        """
        return _Maps(self, [name for name in self._names() if name in TRUTH])

    @property
    def objects(self) -> list[dict[str, Any]]:
        """Defects, pockets, teeth and parts of which at least one pixel shows something, by number.

        Each is a dict: `instance` (its value in the instance image), `class` and `state` (names of pixel classes), `within` (the
        instance that it lies in, 0 for none), `bbox` (first column, first row, columns, rows [px]), `area_px`, `area_mm2`, `x_mm`,
        `y_mm`, `diameter_mm`, `dive_deg`, `death_radius_mm`, `severity`, `length_mm`, `width_mm`, `depth_mm` (NaN where a number has
        no meaning) and `knot_names` (None where it is no knot).
        """
        if "objects" not in self._cache:
            names = self.pixel_classes
            objects = [{key: _known(value, key) for key, value in found.items()} for found in self._row["objects"]]
            for found in objects:
                found.update({key: names[found[key]] for key in ("class", "state")})
            self._cache["objects"] = objects
        return self._cache["objects"]

    @property
    def defect_classes(self) -> list[str]:
        """Class of every defect of which at least one pixel shows something; before schema 1.7 of every defect, seen or not."""
        return self._row["defect_classes"]

    @property
    def unseen_classes(self) -> list[str] | None:
        """Class of every defect that the object has and no pixel shows; None before schema 1.7, which has them in `defect_classes`."""
        return self._row.get("unseen_classes")

    @property
    def class_area_px(self) -> dict[str, int]:
        """Pixels of each class of pixels of the subject [px]."""
        return self._row["class_area_px"]

    # Numbers.

    @property
    def parameters(self) -> dict[str, float]:
        """Every drawn number by its path, such as "camera.tilt_deg"; the unit ends the name."""
        drawn = self._facts.head["parameters"]
        return {f"{number['group']}.{number['key']}": self._number(number["group"], number["key"]) for number in drawn}

    @property
    def physics(self) -> dict[str, float]:
        """Numbers that follow from the drawn ones; NaN where one has no meaning."""
        return {key: _known(value) for key, value in self._row["physics"].items()}

    @property
    def calibration(self) -> dict[str, float]:
        """Camera against laser plane: from a column and row of the sensor to x and z; NaN where a number has no meaning."""
        return {key: _known(value) for key, value in (self._row.get("calibration") or {}).items()}

    @property
    def shares(self) -> dict[str, float]:
        """`measured_share`, `saturated_share` and `object_in_view`, 0 to 1; NaN where one has no meaning."""
        names = ("measured_share", "saturated_share", "object_in_view")
        return {name: _known(self._row[name]) for name in names if name in self._row}

    @property
    def columns(self) -> dict[str, Any]:
        """Every column that a dataset has of it but images, by name and as it is stored: also those that have no attribute here."""
        return copy.deepcopy(self._row)

    @property
    def dark_dn(self) -> dict[str, float]:
        """What the sensor's dark level, dark current included, adds to `reflectance`, `scatter` and `grey` [DN]; `dark=False` takes it off."""
        most = 2 ** self._facts.head["images"]["bits"] - 1
        gathered = self._number("exposure", "dark_current_e_per_s") * self._number("exposure", "time_us") * 1e-6
        level = self._number("exposure", "dark_level_dn") * most / 255 + gathered * _known(self._row["physics"]["gain_dn_per_e"])
        dark = {"reflectance": level, "scatter": _known(self._row["physics"]["scatter_dark_dn"])}
        if "grey" in self._names():
            dark["grey"] = self._number("lamps", "dark_level_dn") * most / 255
        return dark

    # All of it.

    @property
    def maps(self) -> Mapping[str, NDArray[Any]]:
        """Every map that is there by name: `range_mm` or `range_px`, `reflectance`, `scatter`, `grey`, `label`, `instance`, and the truth."""
        unit = self._facts.range_unit
        return _Maps(self, [f"range_{unit}" if name == "range" else name for name in self._names()])

    def picture(self, maps: list[str] | None = None) -> bytes:
        """Maps side by side as PNG: numbers as grey from the first to the 99th per cent of those on the object, labels in the colours of previews.

        Args:
            maps: names of `maps`; None for those that are measured and the labels
        """
        from sheetlight._picture import picture

        return picture(self, maps)

    def show(self, maps: list[str] | None = None) -> None:
        """Shows the picture: in a notebook below the cell, else in the browser of this machine."""
        from sheetlight._picture import show

        show(self, maps)

    def plot(self, maps: list[str] | None = None) -> matplotlib.figure.Figure:
        """Maps as a figure in mm with scales. Needs matplotlib (`pip install "sheetlight[plot]"`)."""
        from sheetlight._picture import plot

        return plot(self, maps)

    def to_arrow(self) -> pyarrow.Table:
        """The row that a dataset has of this sample: a table of one row with the schema of `data/*.parquet`, images as PNG.

        Needs pyarrow (`pip install "sheetlight[arrow]"`). The dark level is in it, as the camera has it.
        """
        from sheetlight._need import needed

        with needed("pyarrow", "arrow"):
            import pyarrow
            import pyarrow.ipc
        return pyarrow.ipc.open_stream(self._there("make its row").row()).read_all()

    # How it is read.

    def _there(self, what: str = "read it") -> _sheetlight.Sample:
        if self._raw is None:
            raise ValueError(f"this sample came from another process, which alone can {what}: do that there")
        return self._raw

    def _names(self) -> list[str]:
        if "names" not in self._cache:
            self._cache["names"] = self._there().maps()
        return self._cache["names"]

    def _map(self, name: str) -> NDArray[Any]:
        if name not in self._cache:
            if name not in self._names():
                raise AttributeError(self._absent(name))
            with self._reading():
                self._cache[name] = self._there().map(name)
        return self._cache[name]

    def _absent(self, name: str) -> str:
        held = ", ".join(self.maps) or "none"
        if name in TRUTH:
            remedy = f"`output.truth_maps` of the recipe asks for those of its subject, which is {self._facts.head['subject']}"
        else:
            remedy = "`output.png` and `output.exr` of a dataset's recipe say which are kept"
        return f"this sample has no map {name!r}; it has {held}; {remedy}"

    def _range(self, unit: str) -> NDArray[np.float32]:
        if unit != self._facts.range_unit:
            has = f"range_{self._facts.range_unit}"
            raise AttributeError(f"Range of this sample is {self.range_form}, so it is {has} and not range_{unit}")
        return self._map("range")

    def _measured(self, name: str) -> NDArray[np.float32]:
        measured = self._map(name)
        if self._dark:
            return measured
        key = f"{name} without dark"
        if key not in self._cache:
            import numpy as np

            self._cache[key] = measured - np.float32(self.dark_dn[name])
            self._cache[key].flags.writeable = False
        return self._cache[key]

    def _number(self, group: str, key: str) -> float:
        return _known(self._row[group][key])


class _Maps(Mapping[str, Any]):
    """Maps of a sample by name, read when they are asked for."""

    __slots__ = ("_sample", "_names")

    def __init__(self, sample: Sample, names: list[str]) -> None:
        self._sample, self._names = sample, names

    def __getitem__(self, name: str) -> NDArray[Any]:
        if name not in self._names:
            raise KeyError(name)
        return self._sample._map(name) if name in TRUTH else getattr(self._sample, name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __repr__(self) -> str:
        return f"<maps {', '.join(self._names)}>"


def _known(value: Any, key: str = "") -> Any:
    """A number as it is, NaN for a missing one; names of knots may be none."""
    return math.nan if value is None and key != "knot_names" else value
