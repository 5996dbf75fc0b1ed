"""How much simulated boards are like photographs: figures of texture, tone, size and count, and what tells them apart.

    make likeness REAL=photographs
    python python/likeness.py --real photographs --simulated out/boards --out out/likeness

`--real` is a folder of photographs with a truth.json (python/board_windows.py says what stands in it) and, if there is
one, a statistics.json with percentiles of many more; without it the photographs themselves are the reference. Pictures
that truth.json calls sealed are left alone but for `--part sealed` or `all`. `--simulated` are datasets of one kind of
board, unbinned, with PNG images of a map and of labels.

Simulated boxes are widened as python/board_inputs.py says.

Prints Markdown, and writes into `--out` likeness.json and, by size of window, told_apart_SIDE_SHRINK.png: windows that
are told most surely, photographs above, simulated ones below. Parts of it (`--only`):

    table    medians and spread of python/board_measures.py against the quartiles of the photographs
    ring     sound against dead knots by the clear wood around them, in each map of RING_MAPS that the datasets hold:
             simulated boards should not tell more than photographs
    network  windows of clear wood, simulated ones through the photographs' JPEG, by a small network: 0.5 is chance.
             By size of window; by one thing alone, all else taken out (board_tests.reduced); power by wavelength.
             Controls deal the boards of one set into two, which should be told by chance; `--control` names a dataset
             whose Reflectance should be told nearly always.
"""

import json
import sys
from pathlib import Path

from board_inputs import begun, boards_of, loosened, parser_of
from board_measures import measured
from board_tests import (SIDE, as_few, control, cut_windows, octaves, reduced, ring_test, rings_of, shuffled, spectra,
                         told_apart)
from board_windows import (PIXEL_MM, WINDOW_MM, Image, listed, maps_of, np, photographs, simulated, through_jpeg,
                           widened, written)

PERCENTILES = [5, 25, 50, 75, 95]
# Windows that the network is asked about: side [px], and how many pixels of a photograph are one of them along a side.
WINDOWS = ((16, 1), (32, 1), (64, 1), (128, 1), (64, 2), (64, 4), (64, 8))
# Those of which is asked what tells them.
LOOKED_AT = ((64, 1), (64, 4))
RING_MAPS = ("grey", "reflectance", "scatter")
PARTS = ("table", "ring", "network")


def collected(windows):
    """Every figure of the table by name, a list of values each, and counts of boxes by kind on an area of WINDOW_MM."""
    found, counts, area = {}, {}, 0.0

    def add(name, value):
        found.setdefault(name, []).append(value)

    for window in windows:
        figures, tones = measured(window)
        for name, value in figures.items():
            add(name, value)
        for kind, tone, dark in tones:
            add(f"{kind} tone", tone)
            add(f"{kind} dark", dark)
        for kind, _, _, w, h in window.boxes:
            along, across = h * PIXEL_MM[0], w * PIXEL_MM[1]
            add(f"{kind} across", across)
            add(f"{kind} along", along)
            add(f"{kind} aspect", across / along)
            counts[kind] = counts.get(kind, 0) + 1
        area += window.known.sum() * PIXEL_MM[0] * PIXEL_MM[1]
    share = WINDOW_MM[0] * WINDOW_MM[1] / area
    return found, {kind: count * share for kind, count in counts.items()}


def reference(folder, windows):
    """Percentiles of the photographs by name of a figure, mean counts, and how many pictures they are of."""
    path = Path(folder) / "statistics.json"
    if not path.is_file():
        found, counts = collected(windows)
        wanted = {name: np.percentile(values, PERCENTILES).tolist() for name, values in found.items()}
        return wanted, counts, len(windows)
    held = json.loads(path.read_text())
    by_measure, wanted = held["by_measure_py"], {}
    for name, value in by_measure.items():
        if isinstance(value, dict):
            wanted.update({f"{name} {what}": value[what] for what in ("tone", "dark")})
        elif name not in ("pictures", "percentiles"):
            wanted[name] = value
    for kind, sides in held["box_mm_assumed_0.05_across_0.08_along"].items():
        for what, side in sides.items():
            wanted[f"{kind} {what.split('_')[0]}"] = side["p05_p25_p50_p75_p95"]
    counts = {name.removeprefix("count of "): value["mean"] for name, value in held["per_board"].items()
              if name.startswith("count of ")}
    return wanted, counts, by_measure["pictures"]


def compared(wanted, found):
    """A row for each figure of the photographs: name, their percentiles, ours, how many, whether the median lies in the
    quartiles, and the spread from 5 to 95 % over theirs."""
    rows = []
    for name, theirs in wanted.items():
        values = found.get(name, [])
        ours = np.percentile(values, PERCENTILES).tolist() if values else None
        inside = bool(ours and theirs[1] <= ours[2] <= theirs[3])
        width = theirs[4] - theirs[0]
        spread = (ours[4] - ours[0]) / width if ours and width > 0 else None
        rows.append({"figure": name, "photographs": theirs, "simulated": ours, "n": len(values), "inside": inside,
                     "spread": spread})
    return rows


def print_table(rows, counts, their_counts):
    print("| figure | photographs: quartiles | 5 to 95 % | simulated: median | 5 to 95 % | of | inside | spread |")
    print("|---|---|---|---|---|---|---|---|")
    for row in rows:
        low, first, _, third, high = row["photographs"]
        ours = row["simulated"]
        mine = f"{ours[2]:.3g} | {ours[0]:.3g} to {ours[4]:.3g}" if ours else "none | "
        print(f"| {row['figure']} | {first:.3g} to {third:.3g} | {low:.3g} to {high:.3g} | {mine} | {row['n']} | "
              f"{'yes' if row['inside'] else '**no**'} | "
              f"{'' if row['spread'] is None else format(row['spread'], '.2f')} |")
    print("\n| mean count on 82 x 122 mm | photographs | simulated | factor |\n|---|---|---|---|")
    for kind, theirs in their_counts.items():
        ours = counts.get(kind, 0.0)
        print(f"| {kind} | {theirs:.3f} | {ours:.3f} | {ours / theirs:.2f} |")


def beside(one, other, logits, path, count=12):
    """A picture of the windows that are told most surely: photographs above, simulated ones below."""
    rows = []
    for windows, answers in ((one.x, -logits[:len(one.x)]), (other.x, logits[len(one.x):])):
        best = windows[np.argsort(-answers)[:count]]
        rows.append(np.concatenate([np.pad(np.clip(128 + 42 * x, 0, 255), 2) for x in best], axis=1))
    picture = Image.fromarray(np.concatenate(rows).astype(np.uint8))
    picture.resize((picture.width * 2, picture.height * 2), Image.Resampling.NEAREST).save(path)


def ring_part(real, tight, widening, given):
    """Prints how well the wood around knots tells sound from dead, and what chance is; what is written of it."""
    print("\n| sound against dead by the ring around | balanced accuracy | 95 % by board | knots |\n|---|---|---|---|")
    told, theirs = {}, rings_of(real)

    def asked(name, rings):
        found = ring_test(rings)
        told[name] = found and found._asdict()
        print(f"| {name} | {found.share:.3f} | {found.low:.3f} to {found.high:.3f} | {found.answers} |" if found
              else f"| {name} | one kind is not there | | |", flush=True)

    def drawn(name, draws):
        shares = [found.share for rings in draws if rings for found in [ring_test(rings)] if found]
        if shares:
            told[name] = {"mean": float(np.mean(shares)), "sd": float(np.std(shares))}
            print("| {} | {mean:.3f} | standard deviation {sd:.3f} of {} draws | |".format(
                name, len(shares), **told[name]), flush=True)

    asked("photographs", theirs)
    drawn("photographs, kinds shuffled", (shuffled(theirs, seed) for seed in range(given.deals)))
    for channel in dict.fromkeys((given.map, *RING_MAPS)):
        if channel != given.map and channel not in maps_of(given.simulated):
            continue
        windows = tight if channel == given.map else boards_of(given, channel=channel)
        mine = rings_of(widened(window, widening) for window in windows)
        asked(f"simulated, {channel}", mine)
        few = (as_few(mine, theirs, seed) for seed in range(given.deals))
        drawn(f"simulated, {channel}, as few as photographs", few)
    return told


def print_told(name, found):
    print(f"| {name} | {found.share:.3f} | {found.low:.3f} to {found.high:.3f} | {found.answers} |", flush=True)


def looked_at(one, other, name, pixel):
    """Prints how well windows are told apart by one thing alone; a dictionary of it."""
    told = {}
    for what in ("tones", "spectra", "phases", *octaves(pixel)):
        label = what if isinstance(what, str) else "waves of {:.1f} to {:.1f} mm".format(*what)
        found, _ = told_apart(*reduced((one, other), what, pixel))
        print_told(f"{name}, {label} alone", found)
        told[label] = found._asdict()
    return told


def network_part(real, ours, given):
    """Prints how well windows are told apart, by what, and where the spectra differ; what is written of it."""
    like = Path(given.real) / listed(given.real, given.part)[0][0]["file"]
    white, told = float(np.median([np.median(window.tone) for window in real])), []
    ours = [through_jpeg(window, like, white) for window in ours]
    print("\n| window | balanced accuracy | 95 % by board | windows |\n|---|---|---|---|")
    for side, shrink in WINDOWS:
        one, other = (cut_windows(windows, shrink, side) for windows in (real, ours))
        pixel = [length * shrink for length in PIXEL_MM]
        name = "{:.1f} x {:.1f} mm of {} px".format(*(side * length for length in pixel), side)
        if min(len(np.unique(cut.board)) for cut in (one, other)) < 4:
            print(f"| {name} | too few boards have such windows | | |")
            continue
        found, logits = told_apart(one, other)
        print_told(name, found)
        told.append({"window": name, **found._asdict()})
        beside(one, other, logits, given.out / f"told_apart_{side}_{shrink}.png")
        if side == SIDE:
            told[-1]["spectra"] = spectra(one, other, pixel)
        if (side, shrink) in LOOKED_AT:
            told[-1]["alone"] = looked_at(one, other, name, pixel)
    for name, windows in (("photographs", real), ("simulated", ours)):
        share, error = control(cut_windows(windows, 2), given.deals)
        print(f"| {name} against {name} | {share:.3f} | standard error {error:.3f} of {given.deals} deals | |",
              flush=True)
        told.append({"control": name, "share": share, "standard_error": error})
    if given.control:
        plain = [through_jpeg(window, like, white) for window in simulated(given.control, "reflectance")]
        found, _ = told_apart(cut_windows(real, 1), cut_windows(plain, 1))
        print_told(f"photographs against Reflectance of {given.control.name}", found)
        told.append({"control": given.control.name, **found._asdict()})
    print("\n| window | direction | wavelength | ln of power over photographs' | over the spread of boards |")
    print("|---|---|---|---|---|")
    for one in told:
        for direction, low, high, apart, sure in one.get("spectra", []):
            if abs(sure) > 1:
                print(f"| {one['window']} | {direction} | {low:.2f} to {high:.2f} mm | {apart:+.2f} | {sure:+.1f} |")
    return told


def main():
    parser = parser_of(__doc__, ("open", "sealed", "all"))
    parser.add_argument("--only", nargs="+", choices=PARTS, default=PARTS, metavar="PART", help="some of them")
    parser.add_argument("--deals", type=int, default=6, help="deals of each control (default: %(default)s)")
    parser.add_argument("--control", type=Path, metavar="DIR", help="dataset whose Reflectance is no photograph")
    given = begun(parser, deals=2)
    real = list(photographs(given.real, given.part))
    tight = list(boards_of(given))
    if not tight:
        sys.exit(f"{', '.join(map(str, given.simulated))}: no board is measured: make samples (--n)")
    loose = loosened(real, tight)
    ours = [widened(window, loose.widened) for window in tight]
    print("Boxes over what is seen, along and across: {} on photographs ({} knots), {} simulated ({}); simulated boxes "
          "widened by {}.\n".format(*(value if isinstance(value, int) else value.round(2) for value in loose)))
    told = {"looseness": {name: np.asarray(value).tolist() for name, value in loose._asdict().items()}}
    if "table" in given.only:
        wanted, their_counts, pictures = reference(given.real, real)
        found, counts = collected(ours)
        told["pictures"], told["table"] = pictures, compared(wanted, found)
        told["counts"] = {"photographs": their_counts, "simulated": counts}
        print_table(told["table"], counts, their_counts)
    if "ring" in given.only:
        told["ring"] = ring_part(real, tight, loose.widened, given)
    if "network" in given.only:
        told["network"] = network_part(real, ours, given)
    written(given.out / "likeness.json", told)


if __name__ == "__main__":
    main()
