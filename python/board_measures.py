"""Texture and tone of boards as figures, for likeness.py and transfer.py; all are ratios, so that exposure does not
matter.

*Clear* is what is measured and lies in no box, boxes half as large again. `measured` gives of a window:

- rings [1]: standard deviation of ln(tone), smoothed along the board (Gaussian, sigma 1.5 mm), between sigma 0.15 and
  1.5 mm across;
- saw [1]: the same with along and across exchanged; rings_over_saw: their ratio;
- band_1_4, band_4_15, band_15_60 [1]: tone of rows (median of what is clear) over its median, standard deviation of the
  difference of Gaussians of sigma 0.5 and 2, 2 and 7.5, 7.5 and 30 mm: what varies along the board over some 1 to 4, 4
  to 15, 15 to 60 mm;
- of each box of 8 px and more that the border does not cut: `tone`, the median of its middle (0.6 of width and height)
  over the median of what is clear around it, out to three times its size, and `dark`, the middle's 5th percentile over
  the same.

The definitions, and figures of 133 photographs by them, are those that docs/real.md compares with.
"""

from board_windows import PIXEL_MM, covered, cv2, gaussian, np, weighted

BANDS = ((1, 4), (4, 15), (15, 60))
# What is no more contrast than rings have, so that no edge of a knot can be read.
FAINT = 0.85


def smooth_line(line, sigma):
    """Gaussian mean of a line, cut at four sigma [px], ends mirrored."""
    reach = int(4 * sigma + 0.5)
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    return np.convolve(np.pad(line, reach, mode="symmetric"), kernel / kernel.sum(), "valid")


def uncut(box, shape):
    """Whether a box has 8 px and more and the border does not cut it."""
    _, x, y, w, h = box
    return min(w, h) >= 8 and x >= 3 and y >= 3 and x + w <= shape[1] - 3 and y + h <= shape[0] - 3


def middle_of(tone, box):
    """Tone in 0.6 of a box's width and height."""
    _, x, y, w, h = box
    return tone[int(y + 0.2 * h):int(y + 0.8 * h), int(x + 0.2 * w):int(x + 0.8 * w)]


def surroundings(tone, clear, box):
    """Median tone of what is clear around a box, out to three times its size; None where hardly anything is."""
    _, x, y, w, h = box
    here = np.s_[max(0, int(y - h)):int(y + 2 * h), max(0, int(x - w)):int(x + 2 * w)]
    return float(np.median(tone[here][clear[here]])) if clear[here].sum() > 50 else None


def texture(log, clear, smooth, mm):
    """Standard deviation of ln(tone), smoothed along the axis `smooth`, in the band across it [1]."""
    low, high = ([(1.5 if axis == smooth else side) / mm[axis] for axis in (0, 1)] for side in (0.15, 1.5))
    return float((weighted(log, clear, low) - weighted(log, clear, high))[clear].std(dtype=np.float64))


def measured(window, mm=PIXEL_MM):
    """The figures of a window by name, and of each box that has them (class, tone, dark); none where boxes leave
    nothing clear."""
    tone = window.tone
    clear = window.known & ~covered(tone.shape, window.boxes, grow=0.25)
    if not clear.any():
        return {}, []
    log = np.log(np.where(clear, np.maximum(tone, 1e-4), 1))
    rings, saw = texture(log, clear, 0, mm), texture(log, clear, 1, mm)
    seen = np.flatnonzero(clear.any(axis=1))
    line = np.interp(np.arange(len(tone)), seen, [np.median(tone[row][clear[row]]) for row in seen])
    line = line / np.median(line[seen])
    figures = {"rings": rings, "saw": saw, "rings_over_saw": rings / saw}
    for a, b in BANDS:
        figures[f"band_{a}_{b}"] = float((smooth_line(line, a / mm[0] / 2) - smooth_line(line, b / mm[0] / 2)).std())
    tones = []
    for box in window.boxes:
        base = surroundings(tone, clear, box) if uncut(box, tone.shape) else None
        if base:
            middle = middle_of(tone, box)
            tones.append((box.kind, float(np.median(middle)) / base, float(np.percentile(middle, 5)) / base))
    return figures, tones


def seen_extent(window, box, mm):
    """How large a dark thing in a box looks (along, across) [px]: the piece of ln(tone), smoothed by 0.3 mm, that is
    darker than the geometric mean of its surroundings and of the median of its middle. None where it is cut, faint, or
    runs out of twice the box, into something else."""
    if not uncut(box, window.tone.shape):
        return None
    _, x, y, w, h = box
    clear = window.known & ~covered(window.tone.shape, window.boxes, grow=0.25)
    base = surroundings(window.tone, clear, box)
    dark = np.median(middle_of(window.tone, box))
    if not base or dark > FAINT * base:
        return None
    y0, x0 = max(0, int(y - h / 2)), max(0, int(x - w / 2))
    ln = np.log(np.maximum(window.tone[y0:int(y + 1.5 * h), x0:int(x + 1.5 * w)], 1e-4))
    dark_side = gaussian(ln, [0.3 / side for side in mm]) < (np.log(max(dark, 1e-4)) + np.log(base)) / 2
    pieces, marks = cv2.connectedComponents(dark_side.astype(np.uint8))
    inner = marks[int(y - y0 + 0.2 * h):int(y - y0 + 0.8 * h), int(x - x0 + 0.2 * w):int(x - x0 + 0.8 * w)]
    counts = np.bincount(inner.ravel(), minlength=pieces)[1:]
    if not counts.size or counts.max() == 0:
        return None
    piece = marks == 1 + counts.argmax()
    if piece[0].any() or piece[-1].any() or piece[:, 0].any() or piece[:, -1].any():
        return None
    return [int(np.ptp(np.flatnonzero(piece.any(axis=side)))) + 1 for side in (1, 0)]


def looseness(windows, kinds, mm=PIXEL_MM):
    """Sides of boxes over what is seen in them, a row (along, across) each [1]."""
    found = []
    for window in windows:
        for box in window.boxes:
            extent = seen_extent(window, box, mm) if box.kind in kinds else None
            if extent:
                found.append((box.h / extent[0], box.w / extent[1]))
    return np.array(found).reshape(-1, 2)
