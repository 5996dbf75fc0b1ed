"""Boards of datasets side by side, each as Reflectance, Scatter and label with the names of what is labelled: `make gallery`.

    python python/gallery.py out/gallery/grading out/gallery/stem --out docs/pictures/gallery.jpg --boards 12

Takes the boards of each dataset in turn, of every class of samples as evenly as there are, until a picture holds `--boards`; each board
is cut to what is not background. Light is scaled alike in all boards of a map (99.5 % of the brightest board's median is white).
Range is shown by its slope along the scan, since the cracks and marks of a face are too small beside its cup.

Needs numpy, pyarrow and pillow: `make venv` installs them.
"""

import argparse
import colorsys
import io
import itertools
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent / "examples"))
from sheetlight_schema import needed, open_dataset

with needed():
    import numpy as np
    import pyarrow.parquet as pq
    from PIL import Image, ImageDraw

# Pixels of the label from which on a class is named.
NAMED = 12
GAP = 4
TEXT = 13


def boards(folder):
    """The samples of a dataset, classes in turn."""
    head = open_dataset(folder)
    columns = ["index", "class", "range", "reflectance", "scatter", "label"]
    samples = [row for table in sorted((folder / "data").rglob("*.parquet"))
               for row in pq.read_table(table, columns=columns).to_pylist()]
    kinds = {}
    for row in sorted(samples, key=lambda row: row["index"]):
        kinds.setdefault(head["classes"][row["class"]] if isinstance(row["class"], int) else row["class"], []).append(row)
    for turn in itertools.zip_longest(*(kinds[name] for name in sorted(kinds))):
        for name, row in zip(sorted(kinds), turn):
            if row is not None:
                yield head, name, row


def plane(row, name):
    return np.asarray(Image.open(io.BytesIO(row[name]["bytes"])))


def colour(number, count):
    """Clear wood grey, the rest around the wheel, neighbours in the list far apart."""
    if number <= 1:
        return (0, 0, 0) if number == 0 else (70, 70, 70)
    return tuple(int(255 * part) for part in colorsys.hsv_to_rgb(number * 0.381966 % 1, 0.75, 1 - 0.35 * (number % 2)))


def grey(light, white):
    return Image.fromarray(np.clip(light * (235 / white), 0, 255).astype(np.uint8)).convert("RGB")


def relief(heights):
    """Range by its slope along the scan; missing pixels black."""
    known = heights > 0
    slope = np.gradient(np.where(known, heights, np.median(heights[known])).astype(float), axis=0)
    spread = 1.48 * np.median(np.abs(slope[known])) + 1e-9
    return Image.fromarray(np.where(known, np.clip(128 + 30 * slope / spread, 1, 255), 0).astype(np.uint8)).convert("RGB")


def cell(head, name, row, wide):
    """One board: a caption, four maps, and the names of its labels in their colours."""
    label = plane(row, "label")
    there = label > 0
    rows, columns = (np.flatnonzero(there.any(axis=side)) for side in (1, 0))
    cut = np.s_[rows[0]:rows[-1] + 1, columns[0]:columns[-1] + 1]
    classes = head["pixel_classes"]
    palette = np.array([colour(number, len(classes)) for number in range(256)], np.uint8)
    light = [plane(row, channel)[cut] for channel in ("reflectance", "scatter")]
    maps = [grey(map, np.percentile(map[label[cut] > 0], 99.5)) for map in light]
    maps += [relief(plane(row, "range")[cut]), Image.fromarray(palette[label[cut]])]
    high = round(wide * maps[0].height / maps[0].width)
    maps = [map.resize((wide, high), Image.Resampling.LANCZOS if number < 3 else Image.Resampling.NEAREST)
            for number, map in enumerate(maps)]
    counts = np.bincount(label[cut].ravel(), minlength=len(classes))
    named = [number for number in np.argsort(-counts) if number > 1 and counts[number] >= NAMED]
    picture = Image.new("RGB", (4 * wide + 3 * GAP, high + TEXT * (2 + max(0, len(named) - 1) // 4)))
    draw = ImageDraw.Draw(picture)
    draw.text((0, 0), f"{head['recipe']['name']} {row['index']}: {name}", fill=(255, 255, 255))
    for number, map in enumerate(maps):
        picture.paste(map, (number * (wide + GAP), TEXT))
    for place, number in enumerate(named):
        draw.text((place % 4 * (wide + GAP), high + TEXT * (1 + place // 4)), classes[number], fill=tuple(int(c) for c in palette[number]))
    return picture


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", type=Path, nargs="+", metavar="DIR", help="datasets with PNG images of all maps and labels")
    parser.add_argument("--out", type=Path, required=True, help="the picture (JPEG or PNG)")
    parser.add_argument("--boards", type=int, default=12, help="boards of all datasets together (default: %(default)s)")
    parser.add_argument("--skip", type=int, default=0, help="boards to leave out first (default: %(default)s)")
    parser.add_argument("--across", type=int, default=3, help="boards in a line (default: %(default)s)")
    parser.add_argument("--width", type=int, default=110, help="pixels across one map (default: %(default)s)")
    given = parser.parse_args()
    if min(given.boards, given.across, given.width) < 1 or given.skip < 0:
        parser.error("--boards, --across and --width are at least 1, --skip at least 0")
    turns = itertools.zip_longest(*(boards(folder) for folder in given.folders))
    drawn = (board for turn in turns for board in turn if board is not None)
    cells = [cell(*board, given.width) for board in itertools.islice(drawn, given.skip, given.skip + given.boards)]
    if len(cells) < given.boards:
        sys.exit(f"{', '.join(map(str, given.folders))}: {len(cells)} boards for {given.boards}: make more samples (--n)")
    lines = [cells[start:start + given.across] for start in range(0, len(cells), given.across)]
    wide, highs = cells[0].width + 3 * GAP, [max(cell.height for cell in line) + 2 * GAP for line in lines]
    sheet = Image.new("RGB", (wide * given.across, sum(highs)), (24, 24, 24))
    for number, line in enumerate(lines):
        for place, cell_ in enumerate(line):
            sheet.paste(cell_, (place * wide + GAP, sum(highs[:number]) + GAP))
    sheet.save(given.out, quality=82)
    print(f"{given.out}: {len(cells)} boards, {given.out.stat().st_size} bytes")


if __name__ == "__main__":
    main()
