"""How much simulated boards are like photographs: figures of texture, tone, size and count, and what tells them apart.

    python python/likeness.py --real photographs --simulated out/boards --out out/likeness      (make likeness REAL=photographs)

`--real` is a folder of photographs with a truth.json (python/board_windows.py says what stands in it) and, if there is one, a
statistics.json with percentiles of many more; without it the photographs themselves are the reference. Pictures that truth.json calls
sealed are left alone but for `--part sealed` or `all`. `--simulated` are datasets of one kind of board, unbinned, with PNG images
of a map and of labels.

People's boxes are loose, and a simulated box holds exactly what is seen. Looseness is a side of the box over what is seen by the
picture alone: the dark piece at half contrast (board_measures.seen_extent). Simulated boxes are widened by the ratio of the medians of
both, along and across, so that the same thing has the same box.

Prints Markdown, and writes likeness.json and told_apart.png into `--out`. Parts of it (`--only`):

    table    medians and spread of python/board_measures.py against the quartiles of the photographs
    ring     sound against dead knots by the clear wood around them: simulated boards should not tell more than photographs
    network  windows of 64 x 64 px of clear wood by a small network, by size of window, simulated ones through the photographs' JPEG;
             0.5 is chance. Controls deal the boards of one set into two: 0.5 but for chance. With power by wavelength.
"""

import argparse
import json
import sys
from pathlib import Path

from board_measures import looseness, measured
from board_tests import (SIDE, as_few, control, cut_windows, ring_test, rings_of, shuffled, spectra, told_apart,
                         torch)
from board_windows import KNOTS, PIXEL_MM, WINDOW_MM, Image, listed, np, photographs, simulated, through_jpeg, widened, written

PERCENTILES = [5, 25, 50, 75, 95]
# Shrinking of windows: 64 px are 5 x 3 mm to 41 x 26 mm.
SHRINKS = (1, 2, 4, 8)
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
        return {name: np.percentile(values, PERCENTILES).tolist() for name, values in found.items()}, counts, len(windows)
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
    counts = {name.removeprefix("count of "): value["mean"] for name, value in held["per_board"].items() if name.startswith("count of ")}
    return wanted, counts, by_measure["pictures"]


def compared(wanted, found):
    """A row for each figure of the photographs: name, their percentiles, ours, how many, whether the median lies in the quartiles, and
    the spread from 5 to 95 % over theirs."""
    rows = []
    for name, theirs in wanted.items():
        values = found.get(name, [])
        ours = np.percentile(values, PERCENTILES).tolist() if values else None
        inside = bool(ours and theirs[1] <= ours[2] <= theirs[3])
        width = theirs[4] - theirs[0]
        spread = (ours[4] - ours[0]) / width if ours and width > 0 else None
        rows.append({"figure": name, "photographs": theirs, "simulated": ours, "n": len(values), "inside": inside, "spread": spread})
    return rows


def print_table(rows, counts, their_counts):
    print("| figure | photographs: quartiles | 5 to 95 % | simulated: median | 5 to 95 % | of | inside | spread |\n|---|---|---|---|---|---|---|---|")
    for row in rows:
        low, first, _, third, high = row["photographs"]
        ours = row["simulated"]
        mine = f"{ours[2]:.3g} | {ours[0]:.3g} to {ours[4]:.3g}" if ours else "none | "
        print(f"| {row['figure']} | {first:.3g} to {third:.3g} | {low:.3g} to {high:.3g} | {mine} | {row['n']} | "
              f"{'yes' if row['inside'] else '**no**'} | {'' if row['spread'] is None else format(row['spread'], '.2f')} |")
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


def ring_part(real, ours, given):
    """Prints how well the wood around knots tells sound from dead, and what chance is; what is written of it."""
    print("\n| sound against dead by the ring around | balanced accuracy | 95 % by board | knots |\n|---|---|---|---|")
    told, (theirs, mine) = {}, map(rings_of, (real, ours))
    for name, rings in (("photographs", theirs), ("simulated", mine)):
        found = ring_test(rings)
        told[name] = found and found._asdict()
        print(f"| {name} | {found.share:.3f} | {found.low:.3f} to {found.high:.3f} | {found.answers} |" if found
              else f"| {name} | one kind is not there | | |", flush=True)
    draws = {"photographs, kinds shuffled": [shuffled(theirs, seed) for seed in range(given.deals)],
             "simulated, as few as photographs": [as_few(mine, theirs, seed) for seed in range(given.deals)]}
    for name, drawn in draws.items():
        shares = [found.share for rings in drawn if rings is not None for found in [ring_test(rings)] if found]
        if shares:
            told[name] = {"mean": float(np.mean(shares)), "sd": float(np.std(shares))}
            print(f"| {name} | {np.mean(shares):.3f} | standard deviation {np.std(shares):.3f} of {len(shares)} draws | |", flush=True)
    return told


def network_part(real, ours, given):
    """Prints how well windows of each size are told apart, and where the spectra differ; what is written of it."""
    told, like = [], Path(given.real) / listed(given.real, given.part)[0][0]["file"]
    white = float(np.median([np.median(window.tone) for window in real]))
    ours = [through_jpeg(window, like, white) for window in ours]
    print("\n| window | balanced accuracy | 95 % by board | windows |\n|---|---|---|---|")
    for shrink in SHRINKS:
        one, other = (cut_windows(windows, shrink) for windows in (real, ours))
        size = " x ".join(f"{SIDE * side * shrink:.1f}" for side in PIXEL_MM)
        if min(len(np.unique(cut.board)) for cut in (one, other)) < 4:
            print(f"| {size} mm | too few boards have such windows | | |")
            continue
        found, logits = told_apart(one, other)
        print(f"| {size} mm | {found.share:.3f} | {found.low:.3f} to {found.high:.3f} | {found.answers} |", flush=True)
        told.append({"window_mm": size, **found._asdict(), "spectra": spectra(one, other, [side * shrink for side in PIXEL_MM])})
        beside(one, other, logits, given.out / f"told_apart_{shrink}.png")
    for name, windows in (("photographs", real), ("simulated", ours)):
        share, error = control(cut_windows(windows, 2), given.deals)
        print(f"| {name} against {name} | {share:.3f} | standard error {error:.3f} of {given.deals} deals | |", flush=True)
        told.append({"control": name, "share": share, "standard_error": error})
    print("\n| window | direction | wavelength | ln of power over photographs' | over the spread of boards |\n|---|---|---|---|---|")
    for one in told:
        for direction, low, high, apart, sure in one.get("spectra", []):
            if abs(sure) > 1:
                print(f"| {one['window_mm']} | {direction} | {low:.2f} to {high:.2f} mm | {apart:+.2f} | {sure:+.1f} |")
    return told


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--real", type=Path, required=True, metavar="DIR", help="photographs with truth.json")
    parser.add_argument("--simulated", type=Path, required=True, nargs="+", metavar="DIR", help="datasets")
    parser.add_argument("--map", default="grey", help="map to compare (default: %(default)s)")
    parser.add_argument("--part", choices=("open", "sealed", "all"), default="open", help="pictures to look at (default: %(default)s)")
    parser.add_argument("--boards", type=int, metavar="N", help="boards of each dataset (default: all)")
    parser.add_argument("--only", nargs="+", choices=PARTS, default=PARTS, metavar="PART", help="some of table, ring, network")
    parser.add_argument("--deals", type=int, default=6, help="deals of each control (default: %(default)s)")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder for what is written")
    given = parser.parse_args()
    if given.deals < 2 or given.boards is not None and given.boards < 1:
        parser.error("--deals is at least 2, --boards at least 1")
    return given


def main():
    given = arguments()
    torch.set_num_threads(1)
    torch.use_deterministic_algorithms(True)
    given.out.mkdir(parents=True, exist_ok=True)
    real = list(photographs(given.real, given.part))
    tight = [window for folder in given.simulated for window in simulated(folder, given.map, most=given.boards)]
    if not tight:
        sys.exit(f"{', '.join(map(str, given.simulated))}: no board is measured: make samples (--n)")
    seen = [looseness(windows, KNOTS) for windows in (real, tight)]
    if min(map(len, seen)) == 0:
        sys.exit("no knot is seen whole on one side: give more boards with knots")
    medians = [np.median(sides, axis=0) for sides in seen]
    factors = np.maximum(medians[0] / medians[1], 1)
    ours = [widened(window, factors) for window in tight]
    told = {"looseness": {"photographs": medians[0].tolist(), "of": len(seen[0]), "simulated": medians[1].tolist(), "widened": factors.tolist()}}
    print(f"Boxes over what is seen, along and across: {medians[0].round(2)} on photographs ({len(seen[0])} knots), {medians[1].round(2)} "
          f"simulated ({len(seen[1])}); simulated boxes widened by {factors.round(2)}.\n")
    if "table" in given.only:
        wanted, their_counts, pictures = reference(given.real, real)
        found, counts = collected(ours)
        told["pictures"], told["table"] = pictures, compared(wanted, found)
        told["counts"] = {"photographs": their_counts, "simulated": counts}
        print_table(told["table"], counts, their_counts)
    if "ring" in given.only:
        told["ring"] = ring_part(real, ours, given)
    if "network" in given.only:
        told["network"] = network_part(real, ours, given)
    written(given.out / "likeness.json", told)


if __name__ == "__main__":
    main()
