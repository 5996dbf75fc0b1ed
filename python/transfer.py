"""What simulated boards are worth on photographs: finders of knots trained on simulated grey pictures alone, on few real boards, and
on both, all asked about the same photographs.

    python python/transfer.py --real photographs --simulated out/boards --out out/transfer      (make transfer REAL=photographs)

`--real` is a folder of photographs with a truth.json (python/board_windows.py says what stands in it), `--simulated` are datasets with
PNG images of a map and of labels, whose boxes are widened as likeness.py says. python/knot_finders.py says what the finders are and why,
python/knot_scores.py what average precision is.

By default half of the pictures that are not sealed are asked by finders that have learned from up to all of the other half, and the other
way round: for developing. `--part sealed` asks the sealed ones by finders that have learned from those that are not: once, at the end.

Prints Markdown; writes transfer.json and, for the network that learned from simulated boards alone, worst.png: photographs with the
surest wrong boxes and missed knots (labels green, boxes found red). The same seed gives the same figures on one machine.
"""

import argparse
import sys
import time
from pathlib import Path

from board_measures import looseness
from board_tests import torch
from board_windows import KNOTS, PIXEL_MM, Box, Image, cv2, np, photographs, simulated, widened, written
from knot_finders import (GRID_MM, forest_shares, lesson, network_shares, pieces, train_forest, train_network)
from knot_scores import KINDS, OVERLAPS, answers, difference, figure, scored

# What people's boxes of knots are larger by than what is seen in them is measured on so many boards of a dataset.
FOR_LOOSENESS = 60


def in_mm(window):
    """Boxes of a window of pixels GRID_MM [mm]."""
    along, across = GRID_MM
    return [Box(kind, x * across, y * along, w * across, h * along) for kind, x, y, w, h in window.boxes]


def widening(given):
    """By how much simulated boxes are made larger (along, across), as on the photographs that may be learned from."""
    real = looseness(photographs(given.real, "open"), KNOTS)
    ours = looseness((window for folder in given.simulated
                      for window in simulated(folder, given.map, most=FOR_LOOSENESS)), KNOTS)
    if not len(real) or not len(ours):
        sys.exit("no knot is seen whole on one side, so that looseness of boxes is not known: give more boards with knots")
    return np.maximum(np.median(real, axis=0) / np.median(ours, axis=0), 1)


def halves(given):
    """Pairs of boards to learn from and to ask about, windows each."""
    open_ones = list(photographs(given.real, "open", GRID_MM))
    order = np.random.default_rng(given.seed).permutation(len(open_ones))
    if given.part == "sealed":
        return [([open_ones[i] for i in order], list(photographs(given.real, "sealed", GRID_MM)))]
    parts = [[open_ones[i] for i in order[start::2]] for start in (0, 1)]
    return [(parts[0], parts[1]), (parts[1], parts[0])]


def network_finds(sources, windows, given):
    model = train_network(sources, given.seed, given.steps)
    return [pieces(network_shares(model, lesson(window).x)) for window in windows]


def forest_finds(sources, windows, given):
    made = train_forest(sources, given.seed)
    return [pieces(forest_shares(made, lesson(window).x)) for window in windows]


def everything_found(pairs, boards, given):
    """What each finder finds on all asked boards, by its name and what it learned from."""
    counts = [k for k in given.real_boards if k <= min(len(learn) for learn, _ in pairs)]
    if not counts:
        sys.exit(f"--real-boards {given.real_boards}: there are {min(len(learn) for learn, _ in pairs)} to learn from")
    lessons = [[lesson(window) for window in learn] for learn, _ in pairs]
    asked, found = [window for _, ask in pairs for window in ask], {}

    def note(name, find, sources):
        began = time.monotonic()
        found[name] = sources(find)
        print(f"{name}: {time.monotonic() - began:.0f} s", file=sys.stderr, flush=True)

    for name, find in (("network", network_finds), ("forest", forest_finds)):
        note(f"{name}, simulated", find, lambda find: find([boards], asked, given))
        for k in counts:
            note(f"{name}, {k} real", find, lambda find: [
                boxes for taught, (_, ask) in zip(lessons, pairs) for boxes in find([taught[:k]], ask, given)])
        note(f"{name}, simulated and {counts[-1]} real", find, lambda find: [
            boxes for taught, (_, ask) in zip(lessons, pairs) for boxes in find([boards, taught[:counts[-1]]], ask, given)])
    return found, asked, counts[-1]


def print_tables(scores, pairs_asked):
    print("| learned from | IoU | " + " | ".join(KINDS) + " |\n|" + "---|" * (2 + len(KINDS)))
    for name, of in scores.items():
        for least in OVERLAPS:
            cells = []
            for kind in KINDS:
                one = of["figures"][f"{kind} {least}"]
                cells.append("none to find" if one["ap"] is None else f"{one['ap']:.2f} ({one['low']:.2f} to {one['high']:.2f})")
            print(f"| {name} | {least} | " + " | ".join(cells) + " |")
    print("\n| difference of AP for knots | IoU | mean | 95 % by board |\n|---|---|---|---|")
    for (one, other, least), value in pairs_asked.items():
        print(f"| {one} less {other} | {least} | {value['difference']:+.2f} | {value['low']:+.2f} to {value['high']:+.2f} |")


def worst(asked, found, path, count=6):
    """The boards with the most surely wrong boxes and missed knots, as they are seen."""
    faults = []
    for window, boxes in zip(asked, found):
        told = answers(boxes, in_mm(window), "knots", OVERLAPS[0])
        false = sum(score for score, right in zip(told.scores, told.right) if not right)
        faults.append(false + told.truths - sum(score for score, right in zip(told.scores, told.right) if right))
    tiles = []
    for place in np.argsort(faults)[::-1][:count]:
        window = asked[place]
        grey = np.clip(160 * np.sqrt(window.tone / np.median(window.tone)), 0, 255).astype(np.uint8)
        tile = cv2.cvtColor(cv2.resize(grey, None, fx=2, fy=2), cv2.COLOR_GRAY2RGB)
        for colour, marks in (((0, 255, 0), [box[1:] for box in in_mm(window)]), ((255, 0, 0), [one.box for one in found[place]])):
            for x, y, w, h in marks:
                corners = [(int(2 * a / GRID_MM[1]), int(2 * b / GRID_MM[0])) for a, b in ((x, y), (x + w, y + h))]
                cv2.rectangle(tile, *corners, colour)
        for one in found[place]:
            at = int(2 * one.box[0] / GRID_MM[1]), int(2 * one.box[1] / GRID_MM[0]) - 3
            cv2.putText(tile, f"{sum(one.sure):.2f}", at, cv2.FONT_HERSHEY_SIMPLEX, 0.4, (255, 0, 0))
        cv2.putText(tile, window.board, (4, 12), cv2.FONT_HERSHEY_SIMPLEX, 0.4, (255, 255, 0))
        tiles.append(tile)
    high, wide = (max(tile.shape[axis] for tile in tiles) for axis in (0, 1))
    sheet = Image.new("RGB", (2 * wide, -(-len(tiles) // 2) * high))
    for place, tile in enumerate(tiles):
        sheet.paste(Image.fromarray(tile), (place % 2 * wide, place // 2 * high))
    sheet.save(path)


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--real", type=Path, required=True, metavar="DIR", help="photographs with truth.json")
    parser.add_argument("--simulated", type=Path, required=True, nargs="+", metavar="DIR", help="datasets to learn from")
    parser.add_argument("--map", default="grey", help="map to learn from (default: %(default)s)")
    parser.add_argument("--part", choices=("open", "sealed"), default="open", help="photographs to ask about (default: %(default)s)")
    parser.add_argument("--boards", type=int, metavar="N", help="boards of each dataset (default: all)")
    parser.add_argument("--real-boards", type=int, nargs="+", default=[5, 10, 20], metavar="K", help="(default: 5 10 20)")
    parser.add_argument("--steps", type=int, default=400, help="batches that a network learns from (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of deals, weights and crops (default: %(default)s)")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder for what is written")
    given = parser.parse_args()
    if min(given.steps, *given.real_boards) < 1 or given.boards is not None and given.boards < 1 or given.seed < 0:
        parser.error("--steps, --boards and --real-boards are at least 1, --seed at least 0")
    return given


def main():
    given = arguments()
    torch.set_num_threads(1)
    torch.use_deterministic_algorithms(True)
    given.out.mkdir(parents=True, exist_ok=True)
    factors = widening(given)
    boards = [lesson(widened(window, factors)) for folder in given.simulated
              for window in simulated(folder, given.map, GRID_MM, given.boards)]
    found, asked, most = everything_found(halves(given), boards, given)
    truth = [in_mm(window) for window in asked]
    told = {name: scored(boxes, truth) for name, boxes in found.items()}
    scores = {name: {"figures": {f"{kind} {least}": figure(of) for (kind, least), of in by.items()}} for name, by in told.items()}
    both, real, ours = (f"network, {what}" for what in (f"simulated and {most} real", f"{most} real", "simulated"))
    differences = {(one, other, least): difference(told[one]["knots", least], told[other]["knots", least])
                   for one, other in ((both, real), (ours, real), (ours, "forest, simulated")) for least in OVERLAPS}
    print(f"{len(boards)} simulated windows, boxes widened by {factors.round(2)} along and across; {len(asked)} photographs asked.\n")
    print_tables(scores, differences)
    worst(asked, found[ours], given.out / "worst.png")
    for name, boxes in found.items():
        scores[name]["found"] = {window.board: [[*one.box, *one.sure] for one in of] for window, of in zip(asked, boxes)}
    told = {"part": given.part, "widened": factors.tolist(), "simulated_windows": len(boards), "kinds": KNOTS, "pixel_mm": PIXEL_MM,
            "finders": scores, "differences": [{"one": one, "other": other, "iou": least, **value}
                                                  for (one, other, least), value in differences.items()]}
    written(given.out / "transfer.json", told)


if __name__ == "__main__":
    main()
