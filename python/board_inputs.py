"""What likeness.py and transfer.py are both asked for, and how boxes of simulated boards become as loose as people's.

People's boxes are loose, and a simulated box holds exactly what is seen. Looseness is a side of the box over what is
seen by the picture alone: the dark piece at half contrast (board_measures.seen_extent). Simulated boxes are widened by
the ratio of the medians of both, along and across, so that the same thing has the same box; those of thin things by
THIN_MARGIN_MM (python/board_windows.py).
"""

import argparse
import sys
from collections import namedtuple
from pathlib import Path

from board_measures import looseness
from board_tests import torch
from board_windows import KNOTS, PIXEL_MM, np, simulated

# Sides of boxes over what is seen (along, across), how many knots that is of, and by what simulated boxes are widened.
Loose = namedtuple("Loose", "photographs knots simulated simulated_knots widened")


def parser_of(text, parts):
    """A parser of what both programs are asked for; `text` describes the program."""
    parser = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--real", type=Path, required=True, metavar="DIR", help="photographs with truth.json")
    parser.add_argument("--simulated", type=Path, required=True, nargs="+", metavar="DIR", help="datasets of boards")
    parser.add_argument("--map", default="grey", help="map of them (default: %(default)s)")
    parser.add_argument("--part", choices=parts, default="open", help="photographs to ask about (default: %(default)s)")
    parser.add_argument("--boards", type=int, metavar="N", help="boards of each dataset (default: all)")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder for what is written")
    return parser


def begun(parser, **least):
    """What was asked, --boards and each number of `least` at least so large; with one thread, and a folder to write
    into."""
    given = parser.parse_args()
    for name, low in {"boards": 1, **least}.items():
        value = getattr(given, name)
        if any(one < low for one in (value if isinstance(value, list) else [value]) if one is not None):
            parser.error(f"--{name.replace('_', '-')} is at least {low}")
    torch.set_num_threads(1)
    torch.use_deterministic_algorithms(True)
    given.out.mkdir(parents=True, exist_ok=True)
    return given


def boards_of(given, to=PIXEL_MM, channel=None):
    """Windows of pixels `to` [mm] of the boards that were given, of the map asked for if no other is named."""
    for folder in given.simulated:
        yield from simulated(folder, channel or given.map, to, given.boards)


def loosened(real, ours):
    """By how much boxes of windows `ours` are to be widened to be as loose as people's on `real`."""
    seen = [looseness(windows, KNOTS) for windows in (real, ours)]
    if min(map(len, seen)) == 0:
        sys.exit("no knot is seen whole on one side, so that looseness is not known: give more boards with knots")
    theirs, mine = (np.median(sides, axis=0) for sides in seen)
    return Loose(theirs, len(seen[0]), mine, len(seen[1]), np.maximum(theirs / mine, 1))
