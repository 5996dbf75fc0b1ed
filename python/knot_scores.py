"""How well boxes of knots were found, for transfer.py: average precision, its intervals by boards, and paired
differences.

A box found is right where it overlaps a labelled one, which no surer box has taken, by an intersection over union (IoU)
of `least` at least. Average precision is the area under precision by recall, precision at each recall the best at it or
beyond (Everingham et al. 2010, all points). Boxes that lie on what is no question (a missing knot, a label too small to
be a knot) count neither way.
"""

from collections import namedtuple

from board_tests import by_board
from board_windows import KNOTS, np

# A labelled box is a question from so many millimetres on each side on: eight pixels of the photographs, as tone is
# asked.
LEAST_MM = (0.64, 0.4)
OVERLAPS = (0.3, 0.5)
KINDS = ("knots", *KNOTS)

# A box that was found (first column, first row, columns, rows [mm]), and how sure it is of each of KNOTS.
Found = namedtuple("Found", "box sure")
# Scores of what was found on a board, whether each is right, and how many there were to find.
Answers = namedtuple("Answers", "scores right truths")


def overlap(a, b):
    """Intersection over union of two boxes, and the share of the first that lies in the second [1]."""
    wide, high = (min(a[i] + a[i + 2], b[i] + b[i + 2]) - max(a[i], b[i]) for i in (0, 1))
    shared = max(wide, 0) * max(high, 0)
    first, second = (box[2] * box[3] for box in (a, b))
    return shared / (first + second - shared), shared / first


def answers(found, boxes, kind, least):
    """Which boxes of a board were right about knots of a kind (one of KINDS); `boxes` in mm."""
    asked = [box for box in boxes if box.kind in KNOTS and box.h >= LEAST_MM[0] and box.w >= LEAST_MM[1]]
    unasked = [box[1:] for box in boxes if box not in asked and (box.kind in KNOTS or box.kind == "Knot_missing")]
    asked = [box[1:] for box in asked if kind in ("knots", box.kind)]
    score = (lambda one: sum(one.sure)) if kind == "knots" else (lambda one: one.sure[KNOTS.index(kind)])
    scores, right, taken = [], [], set()
    for one in sorted(found, key=score, reverse=True):
        fits = [(overlap(one.box, box)[0], place) for place, box in enumerate(asked) if place not in taken]
        best, place = max(fits, default=(0.0, None))
        if best >= least:
            taken.add(place)
        elif any(share > 0.5 or fit >= least for fit, share in (overlap(one.box, box) for box in unasked)):
            continue
        scores.append(score(one))
        right.append(best >= least)
    return Answers(scores, right, len(asked))


def average_precision(boards):
    """Average precision of the answers of several boards together [1]; None where there was nothing to find."""
    truths = sum(board.truths for board in boards)
    if truths == 0:
        return None
    scores, right = (np.concatenate([np.asarray(part, float) for part in parts]) for parts in list(zip(*boards))[:2])
    right = right[np.argsort(-scores, kind="stable")]
    hits = np.cumsum(right)
    precision = hits / np.arange(1, len(right) + 1)
    best = np.maximum.accumulate(precision[::-1])[::-1]
    return float((best * right).sum() / truths)


def scored(found, pictures):
    """For each of KINDS and OVERLAPS the answers of all boards; `found` and `pictures` have an entry a board."""
    return {(kind, least): [answers(boxes, picture, kind, least) for boxes, picture in zip(found, pictures)]
            for kind in KINDS for least in OVERLAPS}


def figure(boards):
    """Average precision, its 95 % interval by boards, and how many knots."""
    value = average_precision(boards)
    low, high = by_board(lambda chosen: average_precision([boards[i] for i in chosen]), range(len(boards)))
    return {"value": value, "low": low, "high": high, "knots": sum(board.truths for board in boards)}


def difference(boards, others):
    """Average precision of one finder less that of another on the same boards, with its 95 % interval: both see the
    boards drawn."""
    def of(chosen):
        one, other = (average_precision([each[i] for i in chosen]) for each in (boards, others))
        return None if one is None else one - other

    low, high = by_board(of, range(len(boards)))
    return {"value": of(range(len(boards))), "low": low, "high": high}
