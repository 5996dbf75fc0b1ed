"""Windows of boards, photographed or simulated, in one form, for likeness.py and transfer.py.

A photograph is an image beside a `truth.json`: {"pictures": [{"file", "crop_px" [x0, y0, x1, y1], "sealed", "labels":
[{"class", "box_px" [x, y, width, height in the crop]}]}]}, rows along the board. Its tone is red, decoded from sRGB to
linear (IEC 61966-2-1). A simulated board is a sample of a dataset with PNG images of one map and of labels; its tone is
that map less its dark level.

Windows have at most 82 mm along the board and 122 mm across, as photographs of the set do that docs/real.md names.
Pixels of a photograph are 0.08 mm along and 0.05 mm across, unless `pixel_mm_assumed` of truth.json says otherwise.
"""

import io
import json
import sys
from collections import namedtuple
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent / "examples"))
from sheetlight_schema import images, needed, open_dataset

with needed():
    import cv2
    import numpy as np
    import pyarrow.parquet as pq
    from PIL import Image, JpegImagePlugin

# What the figures of statistics.json were measured at: a pixel and a window (along, across) [mm].
PIXEL_MM = (0.08, 0.05)
WINDOW_MM = (82.0, 122.0)

# Pixel classes of datasets under the names that people gave such things on photographs.
PHOTOGRAPHED = {"sound_knot": "Live_Knot", "dead_knot": "Dead_Knot", "knot_hole": "Knot_missing",
                "loose_knot": "Dead_Knot", "resin_pocket": "resin", "bark_pocket": "Quartzity",
                "resin_streak": "Quartzity", "pith": "Marrow", "check": "Crack", "split": "Crack", "shake": "Crack"}
KNOTS = ("Live_Knot", "Dead_Knot", "knot_with_crack")
# Thin things, and by how much people's boxes of them are longer and wider than what is seen [mm]: median of the four on
# photographs that are not sealed (three of resin, a crack), by hand; single ones lie from 1.8 to 3.2.
THIN = ("resin", "Crack", "Quartzity")
THIN_MARGIN_MM = 2.7

# A box (class, first column, first row, columns, rows) [px].
Box = namedtuple("Box", "kind x y w h")
# Part of a board: its name, linear tone [rows, columns] above dark, where it is measured, its boxes, and what any label
# covers.
Window = namedtuple("Window", "board tone known boxes labelled")


def gaussian(plane, sigma):
    """Gaussian mean with `sigma` (along, across) [px], cut at four of them, edges mirrored."""
    places = [np.arange(-int(4 * s + 0.5), int(4 * s + 0.5) + 1) for s in sigma]
    kernels = [np.exp(-0.5 * (place / max(s, 1e-9)) ** 2) for place, s in zip(places, sigma)]
    along, across = (kernel / kernel.sum() for kernel in kernels)
    return cv2.sepFilter2D(np.asarray(plane, np.float32), -1, across, along, borderType=cv2.BORDER_REFLECT)


def weighted(values, weight, sigma):
    """Gaussian mean of what has weight."""
    weight = np.asarray(weight, np.float32)
    if weight.min() == 1:
        return gaussian(values, sigma)
    return gaussian(values * weight, sigma) / np.maximum(gaussian(weight, sigma), 1e-3)


def resized(plane, scale):
    """A map whose pixels are `scale` (along, across) times as large: means where they grow, cubic between them where
    they shrink."""
    for axis, step in enumerate(scale):
        size = list(plane.shape)
        size[axis] = max(1, round(size[axis] / step))
        plane = cv2.resize(plane, size[::-1], interpolation=cv2.INTER_AREA if step >= 1 else cv2.INTER_CUBIC)
    return plane


def resampled(window, pixel, to):
    """A window of pixels `pixel` with pixels `to` (along, across) [mm]; what is not measured takes the tone around
    it."""
    scale = [new / old for new, old in zip(to, pixel)]
    if all(abs(step - 1) < 1e-6 for step in scale):
        return window
    known = window.known.astype(np.float32)
    # Up to 2 mm beside what is measured, beyond it the median: nothing rings there.
    near = weighted(window.tone, known, [0.5 / side for side in pixel])
    tone = np.where(window.known, window.tone, np.where(near > 0, near, np.median(window.tone[window.known])))
    boxes = [Box(kind, x / scale[1], y / scale[0], w / scale[1], h / scale[0]) for kind, x, y, w, h in window.boxes]
    tone, labelled = (resized(plane.astype(np.float32), scale) for plane in (tone, window.labelled))
    return Window(window.board, np.maximum(tone, 0), resized(known, scale) > 0.99, boxes, labelled > 0.01)


def covered(shape, boxes, grow=0.0):
    """Pixels in boxes that are wider by a share `grow` of their size on each side."""
    inside = np.zeros(shape, bool)
    for _, x, y, w, h in boxes:
        top, left = max(0, int(y - grow * h)), max(0, int(x - grow * w))
        inside[top:int(y + (1 + grow) * h), left:int(x + (1 + grow) * w)] = True
    return inside


def linear(values):
    """sRGB [0 to 1] as linear light."""
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def photograph(path, crop):
    """Red of a photograph's crop (x0, y0, x1, y1), linear [0 to 1]."""
    x0, y0, x1, y1 = crop
    return linear(np.asarray(Image.open(path).convert("RGB"))[y0:y1, x0:x1, 0] / 255.0).astype(np.float32)


def through_jpeg(window, like, white):
    """A simulated window as the camera of a photograph `like` would have kept it: its median at `white` of linear
    light, in sRGB of eight bits, through the photograph's own tables of JPEG."""
    light = np.clip(window.tone * (white / np.median(window.tone[window.known])), 0, 1)
    coded = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    picture, file = Image.open(like), io.BytesIO()
    grey = Image.fromarray(np.round(255 * coded).astype(np.uint8)).convert("RGB")
    grey.save(file, "JPEG", qtables=picture.quantization, subsampling=JpegImagePlugin.get_sampling(picture))
    red = np.asarray(Image.open(file))[..., 0] / 255.0
    return window._replace(tone=linear(red).astype(np.float32))


def listed(folder, part):
    """Pictures of truth.json: "open" ones, "sealed" ones or "all", and the size of their pixels (along, across)
    [mm]."""
    path = Path(folder) / "truth.json"
    try:
        truth = json.loads(path.read_text())
    except (OSError, ValueError) as fault:
        sys.exit(f"{path}: {fault}; name a folder with photographs and their truth.json (docs/real.md)")
    chosen = [picture for picture in truth["pictures"]
              if part == "all" or picture.get("sealed", False) == (part == "sealed")]
    if not chosen:
        sys.exit(f"{path} lists no {part} pictures: --part takes open, sealed or all")
    return chosen, tuple(truth.get("pixel_mm_assumed", PIXEL_MM))


def photographs(folder, part, to=PIXEL_MM):
    """The photographs of a folder as windows of pixels `to` [mm]."""
    pictures, pixel = listed(folder, part)
    for picture in pictures:
        tone = photograph(Path(folder) / picture["file"], picture["crop_px"])
        # Some boxes that people drew are empty.
        boxes = [Box(label["class"], *label["box_px"]) for label in picture["labels"] if min(label["box_px"][2:]) > 0]
        window = Window(picture["file"], tone, np.ones(tone.shape, bool), boxes, covered(tone.shape, boxes))
        yield resampled(window, pixel, to)


def maps_of(folders):
    """Maps of which all datasets hold images."""
    return set.intersection(*(set(open_dataset(folder)["images"]["png"]) for folder in folders))


def dark_of(row, channel, bits):
    """What the dark level adds to a map of a sample [DN]."""
    if channel == "scatter":
        return row["physics"]["scatter_dark_dn"]
    if channel == "grey":
        return row["lamps"]["dark_level_dn"] * (2**bits - 1) / 255
    exposure = row["exposure"]
    gathered = (exposure["dark_current_e_per_s"] or 0) * exposure["time_us"] * 1e-6
    return exposure["dark_level_dn"] * (2**bits - 1) / 255 + gathered * row["physics"]["gain_dn_per_e"]


def cut(window, pixel):
    """Parts of a board of at most WINDOW_MM: as many along it as fit whole, the middle across it."""
    rows, columns = (np.flatnonzero(window.known.any(axis=side)) for side in (1, 0))
    if not len(rows):
        return
    high, wide = (min(round(most / side), seen[-1] + 1 - seen[0])
                  for most, side, seen in zip(WINDOW_MM, pixel, (rows, columns)))
    left = (columns[0] + columns[-1] + 1 - wide) // 2
    count = max(1, int((rows[-1] + 1 - rows[0]) // high))
    for top in range(rows[0], rows[0] + count * high, high):
        here, boxes = np.s_[top:top + high, left:left + wide], []
        for kind, x, y, w, h in window.boxes:
            x0, y0, x1, y1 = max(x, left), max(y, top), min(x + w, left + wide), min(y + h, top + high)
            if x1 > x0 and y1 > y0:
                boxes.append(Box(kind, x0 - left, y0 - top, x1 - x0, y1 - y0))
        yield Window(window.board, window.tone[here], window.known[here], boxes, window.labelled[here])


def photographed(thing, names):
    """What people call an object of a dataset on a photograph; None where they have no word."""
    cracked = "crack" in (thing.get("knot_names") or "").split()
    return "knot_with_crack" if cracked else PHOTOGRAPHED.get(names[thing["state"]])


def simulated(folder, channel, to=PIXEL_MM, most=None):
    """The boards of a dataset, at most `most` of them, as windows of pixels `to` [mm]; boxes are those of what is
    seen."""
    head = open_dataset(folder)
    images(head, channel, "label")
    names, left = head["pixel_classes"], most
    columns = ["index", "row_mm", "col_mm", "exposure", "physics", "objects", "label", channel]
    columns += ["lamps"] if channel == "grey" else []
    for table in sorted((Path(folder) / "data").rglob("*.parquet")):
        with pq.ParquetFile(table) as file:
            for batch in file.iter_batches(batch_size=1, columns=columns):
                if left == 0:
                    return
                left = None if left is None else left - 1
                row = batch.to_pylist()[0]
                light, label = (np.asarray(Image.open(io.BytesIO(row[name]["bytes"]))) for name in (channel, "label"))
                named = [(photographed(thing, names), thing["bbox"]) for thing in row["objects"]]
                boxes = [Box(kind, *box) for kind, box in named if kind]
                tone = np.maximum(light.astype(np.float32) - dark_of(row, channel, head["images"]["bits"]), 0)
                known = (light > 0) & (label != names.index("background"))
                plain = (label == names.index("clear")) | (label == names.index("background"))
                whole = Window(f"{Path(folder).name} {row['index']}", tone, known, boxes, ~plain)
                pixel = row["row_mm"], row["col_mm"]
                for part in cut(whole, pixel):
                    yield resampled(part, pixel, to)


def widened(window, factors, mm=PIXEL_MM):
    """A window whose boxes are larger by `factors` (along, across) about their middles, those of THIN by a margin,
    within the window; its pixels are `mm`."""
    rows, columns = window.tone.shape
    boxes = []
    for kind, x, y, w, h in window.boxes:
        more_w, more_h = w * (factors[1] - 1) / 2, h * (factors[0] - 1) / 2
        if kind in THIN:
            more_h, more_w = (THIN_MARGIN_MM / side / 2 for side in mm)
        x0, y0, x1, y1 = max(0, x - more_w), max(0, y - more_h), min(columns, x + w + more_w), min(rows, y + h + more_h)
        boxes.append(Box(kind, x0, y0, x1 - x0, y1 - y0))
    return window._replace(boxes=boxes)


def written(path, told):
    """Writes what was told as JSON; what is no number, as a mean of nothing, is null."""
    def finite(value):
        if isinstance(value, dict):
            return {key: finite(one) for key, one in value.items()}
        if isinstance(value, (list, tuple)):
            return [finite(one) for one in value]
        return None if isinstance(value, float) and not np.isfinite(value) else value
    path.write_text(json.dumps(finite(told), indent=1, allow_nan=False) + "\n")
