"""Two finders of knots on grey pictures of boards, for transfer.py: a small U-Net, and a plain forest of pixels.

Both say of each pixel of 0.4 mm whether it is clear or a knot of which kind. They learn from ellipses in boxes, since
people draw no more than boxes on photographs, and knots are round; pieces of what they call knot, by their bounding
boxes, are what they find.

The U-Net (Ronneberger, Fischer and Brox 2015) is the network that most begin with where there is little to learn from:
it has no anchors to be set for sizes of knots, learns from each pixel of twenty boards, not from each of their fifty
boxes, and trains within minutes on one core. What it sees is ln(tone) less its mean over some 20 mm, so that neither
exposure nor light that falls off matters.
"""

import copy
from collections import namedtuple

from board_tests import forest, torch, votes
from board_windows import KNOTS, cv2, gaussian, np, weighted
from knot_scores import LEAST_MM, Found

GRID_MM = (0.4, 0.4)
# Pixels that are asked nothing.
UNASKED = 255
# Rates of learning from the beginning, and of going on from what was learned elsewhere.
RATE, FINER = 4e-3, 1e-3
# Side of what is learned from at a time [px], and channels of the network by depth.
CROP = 96
WIDTHS = (12, 24, 48, 64)
# Share of knot from which on a pixel belongs to a piece, surest first: fainter pieces count where no surer one lies.
LEVELS = (0.5, 0.3, 0.15)
# Standard deviations of the forest's Gaussians [mm].
SCALES_MM = (0.5, 1.0, 2.0, 4.0, 8.0)

# A board as a finder sees it: ln(tone) less its mean around [rows, columns], and the class of each pixel (KNOTS from
# 1).
Lesson = namedtuple("Lesson", "x y")


def lesson(window):
    """A window of pixels GRID_MM as a lesson."""
    ln = np.where(window.known, np.log(np.maximum(window.tone, 1e-4)), 0).astype(np.float32)
    x = np.where(window.known, ln - weighted(ln, window.known, [20 / side for side in GRID_MM]), 0).astype(np.float32)
    y = np.where(window.known, 0, UNASKED).astype(np.uint8)
    for kind, left, top, w, h in window.boxes:
        asked = kind in KNOTS and h * GRID_MM[0] >= LEAST_MM[0] and w * GRID_MM[1] >= LEAST_MM[1]
        if asked or kind in (*KNOTS, "Knot_missing"):
            rows, columns = np.ogrid[:y.shape[0], :y.shape[1]]
            inside = ((rows + 0.5 - top - h / 2) / (h / 2)) ** 2 + ((columns + 0.5 - left - w / 2) / (w / 2)) ** 2 <= 1
            y[inside & window.known] = 1 + KNOTS.index(kind) if asked else UNASKED
    return Lesson(x, y)


def twice(planes, wider):
    layers = []
    for before in (planes, wider):
        layers += [torch.nn.Conv2d(before, wider, 3, padding=1, bias=False), torch.nn.BatchNorm2d(wider),
                   torch.nn.ReLU()]
    return torch.nn.Sequential(*layers)


class UNet(torch.nn.Module):
    """Down by means of pairs of convolutions, up again with what was seen on the way down beside it."""

    def __init__(self):
        super().__init__()
        self.down = torch.nn.ModuleList(twice(before, wider) for before, wider in zip((1, *WIDTHS), WIDTHS))
        self.up = torch.nn.ModuleList(twice(deep + wider, wider) for deep, wider in zip(WIDTHS[:0:-1], WIDTHS[-2::-1]))
        self.last = torch.nn.Conv2d(WIDTHS[0], 1 + len(KNOTS), 1)

    def forward(self, x):
        seen = []
        for depth, step in enumerate(self.down):
            x = step(torch.nn.functional.max_pool2d(x, 2) if depth else x)
            seen.append(x)
        for step, beside in zip(self.up, seen[-2::-1]):
            x = step(torch.cat([torch.nn.functional.interpolate(x, scale_factor=2), beside], 1))
        return self.last(x)


def drawn_crop(taught, random):
    """A crop of a lesson, about a knot in half of all cases, mirrored, turned and stretched a little, its contrast
    changed, noise, blur and light that falls off added: photographs differ in all of that."""
    x, y = taught
    rows, columns = np.nonzero((y > 0) & (y != UNASKED))
    if len(rows) and random.random() < 0.5:
        place = random.integers(len(rows))
        middle = np.array([columns[place], rows[place]]) + random.uniform(-0.35, 0.35, 2) * CROP
    else:
        middle = random.uniform(0, 1, 2) * x.shape[::-1]
    turn, stretch = np.radians(random.uniform(-8, 8)), np.exp(random.uniform(-0.25, 0.25, 2))
    turned = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    to = turned @ np.diag(stretch * random.choice([-1, 1], 2))
    # From places of the crop to those of the lesson.
    matrix = np.column_stack([to, middle - to @ np.full(2, CROP / 2)])
    flags = cv2.WARP_INVERSE_MAP
    x = cv2.warpAffine(x, matrix, (CROP, CROP), flags=flags | cv2.INTER_LINEAR)
    y = cv2.warpAffine(y, matrix, (CROP, CROP), flags=flags | cv2.INTER_NEAREST, borderValue=UNASKED)
    blur = random.uniform(0.1, 1)
    x = np.exp(random.normal(0, 0.25)) * gaussian(x, (blur, blur))
    x += random.uniform(0, 0.06) * random.standard_normal(x.shape)
    light = cv2.resize(random.normal(0, random.uniform(0, 0.25), (3, 3)), (CROP, CROP), interpolation=cv2.INTER_CUBIC)
    return (x + light).astype(np.float32), y


def train_network(sources, seed, steps, begin=None, rate=RATE, batch=8):
    """A U-Net after `steps` batches of crops, shared evenly among `sources`, lists of lessons. It goes on from the
    network `begin`, if there is one."""
    torch.manual_seed(seed)
    random, model = np.random.default_rng(seed), copy.deepcopy(begin) if begin else UNet()
    optimiser = torch.optim.AdamW(model.parameters(), lr=rate, weight_decay=1e-2)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, rate, total_steps=steps, pct_start=0.2)
    model.train()
    for _ in range(steps):
        chosen = [sources[place % len(sources)] for place in range(batch)]
        x, y = zip(*(drawn_crop(source[random.integers(len(source))], random) for source in chosen))
        x, y = torch.from_numpy(np.stack(x))[:, None], torch.from_numpy(np.stack(y).astype(np.int64))
        loss = torch.nn.functional.cross_entropy(model(4 * x), y, ignore_index=UNASKED)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        schedule.step()
    return model.eval()


def network_shares(model, x):
    """Share of each class by pixel [classes, rows, columns], the mean of the picture and its mirror images."""
    more = [-side % 2 ** (len(WIDTHS) - 1) for side in x.shape]
    padded, total = torch.from_numpy(np.pad(4 * x, [(0, side) for side in more]))[None, None], 0
    for axes in ((), (2,), (3,), (2, 3)):
        with torch.no_grad():
            total = total + model(padded.flip(axes)).softmax(1).flip(axes)[0] / 4
    return total.numpy()[:, :x.shape[0], :x.shape[1]]


def pixel_features(x):
    """Seventeen Gaussian features of each pixel [rows, columns, 17]: five means less the next larger one, the slope and
    the curvature along and across at three scales."""
    planes = [gaussian(x, [scale / side for side in GRID_MM]) for scale in (*SCALES_MM, 2 * SCALES_MM[-1])]
    told = [fine - coarse for fine, coarse in zip(planes, planes[1:])]
    for plane in planes[:3]:
        slopes = np.gradient(plane)
        told += [np.abs(slope) for slope in slopes]
        told += [np.gradient(slope, axis=axis) for axis, slope in enumerate(slopes)]
    return np.stack(told, axis=-1).astype(np.float32)


def train_forest(sources, seed, pixels=30000):
    """80 trees that have seen so many pixels, shared evenly among the sources, a third of them in knots."""
    random, x, y = np.random.default_rng(seed), [], []
    for source in sources:
        for knots, share in ((False, 2), (True, 1)):
            most = pixels * share // (3 * len(sources) * len(source))
            for taught in source:
                places = np.flatnonzero((taught.y != UNASKED) & ((taught.y > 0) == knots))
                chosen = random.permutation(places)[:most]
                x.append(pixel_features(taught.x).reshape(-1, 17)[chosen])
                y.append(taught.y.ravel()[chosen])
    return forest(np.concatenate(x), np.concatenate(y).astype(int), seed, depth=14, even=False)


def forest_shares(made, x):
    """Share of each class by pixel [classes, rows, columns], smoothed as knots are."""
    shares = votes(made, pixel_features(x).reshape(-1, 17), 1 + len(KNOTS))
    return np.stack([gaussian(plane.reshape(x.shape), [0.6 / side for side in GRID_MM]) for plane in shares.T])


def pieces(shares):
    """What is found in shares of classes: boxes [mm] of pieces of knot, with how sure each is of each kind."""
    knot, taken, found = 1 - shares[0], np.zeros(shares.shape[1:], bool), []
    for level in LEVELS:
        count, marks = cv2.connectedComponents((knot > level).astype(np.uint8))
        for mark in range(1, count):
            piece = marks == mark
            if (piece & taken).any():
                continue
            rows, columns = (np.flatnonzero(piece.any(axis=side)) for side in (1, 0))
            top, high, left, wide = rows[0], len(rows), columns[0], len(columns)
            if high * GRID_MM[0] < LEAST_MM[0] or wide * GRID_MM[1] < LEAST_MM[1]:
                continue
            taken |= piece
            box = left * GRID_MM[1], top * GRID_MM[0], wide * GRID_MM[1], high * GRID_MM[0]
            found.append(Found(box, tuple(float(shares[1 + kind][piece].mean()) for kind in range(len(KNOTS)))))
    return found
