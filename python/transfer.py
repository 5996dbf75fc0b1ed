"""What simulated boards are worth on photographs: finders of knots trained on simulated grey pictures alone, on few
real boards, and on both, all asked about the same photographs.

    make transfer REAL=photographs
    python python/transfer.py --real photographs --simulated out/boards --out out/transfer

`--real` is a folder of photographs with a truth.json (python/board_windows.py says what stands in it), `--simulated`
are datasets with PNG images of a map and of labels, whose boxes are widened as python/board_inputs.py says.
python/knot_finders.py says what the finders are and why, python/knot_scores.py what average precision is.

On both, a network learns from simulated boards first and then, in smaller steps, from the real ones; a forest learns
from both at once.

By default half of the pictures that are not sealed are asked by finders that have learned from up to all of the other
half, and the other way round: for developing. `--part sealed` asks the sealed ones by finders that have learned from
those that are not: once, at the end.

Prints Markdown; writes transfer.json and, for the network that learned from simulated boards alone, worst.png:
photographs with the surest wrong boxes and missed knots (labels green, boxes found red). The same seed gives the same
figures on one machine.
"""

import sys
import time
from itertools import islice

from board_inputs import begun, boards_of, loosened, parser_of
from board_windows import KNOTS, PIXEL_MM, Box, Image, cv2, np, photographs, widened, written
from knot_finders import (FINER, GRID_MM, forest_shares, lesson, network_shares, pieces, train_forest, train_network)
from knot_scores import KINDS, OVERLAPS, answers, difference, figure, scored

# What people's boxes of knots are larger by than what is seen in them is measured on so many boards of all datasets.
FOR_LOOSENESS = 60


def in_mm(window):
    """Boxes of a window of pixels GRID_MM [mm]."""
    along, across = GRID_MM
    return [Box(kind, x * across, y * along, w * across, h * along) for kind, x, y, w, h in window.boxes]


def halves(given):
    """Pairs of boards to learn from and to ask about, windows each."""
    open_ones = list(photographs(given.real, "open", GRID_MM))
    order = np.random.default_rng(given.seed).permutation(len(open_ones))
    if given.part == "sealed":
        return [([open_ones[i] for i in order], list(photographs(given.real, "sealed", GRID_MM)))]
    parts = [[open_ones[i] for i in order[start::2]] for start in (0, 1)]
    return [(parts[0], parts[1]), (parts[1], parts[0])]


def networks(boards, lessons, counts, given):
    """What networks learn from, and for each of the pairs asked the network that has."""
    first = train_network([boards], given.seed, given.steps)
    yield "simulated", [first] * len(lessons)
    for k in counts:
        yield f"{k} real", [train_network([taught[:k]], given.seed, given.steps) for taught in lessons]
        yield f"simulated and {k} real", [train_network([taught[:k]], given.seed, (given.steps + 1) // 2, first, FINER)
                                          for taught in lessons]


def forests(boards, lessons, counts, given):
    """What forests learn from, and for each of the pairs asked the forest that has."""
    yield "simulated", [train_forest([boards], given.seed)] * len(lessons)
    for k in counts:
        yield f"{k} real", [train_forest([taught[:k]], given.seed) for taught in lessons]
        yield f"simulated and {k} real", [train_forest([boards, taught[:k]], given.seed) for taught in lessons]


def everything_found(pairs, boards, given):
    """What each finder finds on all boards asked, by its name and what it learned from; and numbers of real boards."""
    most = min(len(learn) for learn, _ in pairs)
    counts = [k for k in given.real_boards if k <= most]
    if not counts:
        sys.exit(f"--real-boards {given.real_boards}: there are {most} to learn from")
    lessons, asks = ([[lesson(window) for window in pair[side]] for pair in pairs] for side in (0, 1))
    found = {}
    for kind, learned, shares in (("network", networks, network_shares), ("forest", forests, forest_shares)):
        began = time.monotonic()
        for source, made in learned(boards, lessons, counts, given):
            found[f"{kind}, {source}"] = [pieces(shares(one, asked.x)) for one, ask in zip(made, asks) for asked in ask]
            print(f"{kind}, {source}: {time.monotonic() - began:.0f} s", file=sys.stderr, flush=True)
    return found, counts


def compared(counts):
    """Pairs of finders whose difference is asked for."""
    real = [(kind, k) for kind in ("network", "forest") for k in counts]
    return [("network, simulated", "forest, simulated"),
            *((f"{kind}, simulated", f"{kind}, {k} real") for kind, k in real),
            *((f"{kind}, simulated and {k} real", f"{kind}, {k} real") for kind, k in real)]


def print_table(title, rows):
    """Rows of a name and, for each of KINDS and OVERLAPS, a value and its interval."""
    print(f"| {title} | IoU | " + " | ".join(KINDS) + " |\n|" + "---|" * (2 + len(KINDS)))
    for name, of in rows.items():
        for least in OVERLAPS:
            cells = [of[f"{kind} {least}"] for kind in KINDS]
            cells = ["none to find" if one["value"] is None else "{value:.2f} ({low:.2f} to {high:.2f})".format(**one)
                     for one in cells]
            print(f"| {name} | {least} | " + " | ".join(cells) + " |")
    print()


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
        labels, boxes = [box[1:] for box in in_mm(window)], [one.box for one in found[place]]
        for colour, marks in (((0, 255, 0), labels), ((255, 0, 0), boxes)):
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


def main():
    parser = parser_of(__doc__, ("open", "sealed"))
    numbers = {"type": int, "help": "%(default)s by default"}
    parser.add_argument("--real-boards", nargs="+", default=[5, 10, 20], metavar="K", **numbers)
    parser.add_argument("--steps", default=400, metavar="BATCHES", **numbers)
    parser.add_argument("--seed", default=0, metavar="N", **numbers)
    given = begun(parser, steps=1, real_boards=1, seed=0)
    factors = loosened(photographs(given.real, "open"), islice(boards_of(given), FOR_LOOSENESS)).widened
    boards = [lesson(widened(window, factors, GRID_MM)) for window in boards_of(given, GRID_MM)]
    pairs = halves(given)
    found, counts = everything_found(pairs, boards, given)
    asked = [window for _, ask in pairs for window in ask]
    truth = [in_mm(window) for window in asked]
    right = {name: scored(boxes, truth) for name, boxes in found.items()}
    figures = {name: {f"{kind} {least}": figure(of) for (kind, least), of in by.items()} for name, by in right.items()}
    differences = {f"{one} less {other}": {f"{kind} {least}": difference(of, right[other][kind, least])
                                           for (kind, least), of in right[one].items()}
                   for one, other in compared(counts)}
    print(f"{len(boards)} simulated windows, boxes widened by {factors.round(2)} along and across; {len(asked)} "
          "photographs asked. Average precision, 95 % by board.\n")
    print_table("learned from", figures)
    print_table("difference", differences)
    worst(asked, found["network, simulated"], given.out / "worst.png")
    places = {name: {window.board: [[*one.box, *one.sure] for one in of] for window, of in zip(asked, boxes)}
              for name, boxes in found.items()}
    written(given.out / "transfer.json", {
        "part": given.part, "widened": factors.tolist(), "simulated_windows": len(boards), "kinds": KNOTS,
        "pixel_mm": PIXEL_MM, "differences": differences,
        "finders": {name: {"figures": of, "found": places[name]} for name, of in figures.items()}})


if __name__ == "__main__":
    main()
