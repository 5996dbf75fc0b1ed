"""What tells simulated boards from photographs, and sound knots from dead ones by clear wood alone, for likeness.py.

`ring_test` asks a forest for the kind of a knot by the ring of clear wood 1.5 to 3 mm outside of its box. Some forty
knots are so few that a forest that knows nothing answers worse than by chance: what is left to learn from lies on the
other side of what was taken out. So it is compared with answers about shuffled kinds, and with as few simulated knots.
`told_apart` asks a small network whether a window, brightness and contrast equalised, is of the one set of boards or of
the other; what it needs for that is seen by windows in which one thing alone is left (`reduced`), and by their
`spectra`. Boards, not windows or knots, are dealt into what is learned from and what is asked.
"""

from collections import namedtuple

from board_windows import KNOTS, PIXEL_MM, covered, cv2, needed, np, resized

with needed():
    import torch

# The ring around a box, and what it is compared with [mm].
RING_MM = (1.5, 3.0)
BASE_MM = (3.0, 10.0)
SECTORS = 8
# Side of the network's windows [px], and how many of them are cut from each board.
SIDE = 64
EACH = 60
# Batches of 64 windows that the network learns from.
STEPS = 250

# A share of right answers, the mean of that of both kinds [1], its 95 % interval by boards, and of how many answers.
Balanced = namedtuple("Balanced", "share low high answers")
# Features of rings [n, features], whether each knot is dead, and its board.
Rings = namedtuple("Rings", "told dead board")
# Windows [n, side, side] of equalised ln(tone) and the number of each one's board.
Cut = namedtuple("Cut", "x board")


def by_board(figure, boards, seed=0, times=1000):
    """95 % interval of `figure(chosen boards)`, boards drawn with replacement (Efron 1979); draws without a figure are
    left out."""
    random = np.random.default_rng(seed)
    drawn = [figure(random.choice(boards, len(boards))) for _ in range(times)]
    drawn = [value for value in drawn if value is not None and np.isfinite(value)]
    return tuple(float(end) for end in np.percentile(drawn, [2.5, 97.5])) if drawn else (float("nan"), float("nan"))


def balanced(truth, said, board):
    """Balanced accuracy of answers `said` about `truth` (both 0 or 1) on boards `board`."""
    kinds = [(truth == kind, (truth == kind) & (said == kind)) for kind in (0, 1)]
    boards = np.unique(board)
    # [kinds, (asked, right), boards]
    counts = np.array([[np.bincount(np.searchsorted(boards, board[of]), minlength=len(boards)) for of in kind]
                       for kind in kinds])

    def share(chosen):
        asked, right = counts[:, :, np.searchsorted(boards, chosen)].sum(axis=2).T
        return float((right / asked).mean()) if asked.all() else None

    return Balanced(share(boards), *by_board(share, boards), len(truth))


def ring_features(window, box, mm=PIXEL_MM):
    """Mean and spread of ln(tone) of clear wood in eight sectors of the ring around a box over the median farther out,
    and both ends of all of it; None where less than half of the ring is measured and clear."""
    _, x, y, w, h = box
    reach = BASE_MM[1]
    y0, x0 = max(0, int(y - reach / mm[0])), max(0, int(x - reach / mm[1]))
    here = np.s_[y0:int(y + h + reach / mm[0]), x0:int(x + w + reach / mm[1])]
    clear = (window.known & ~covered(window.tone.shape, window.boxes))[here]
    rows, columns = (np.arange(n) + 0.5 for n in clear.shape)
    rows, columns = rows[:, None] + y0, columns[None, :] + x0
    # Distance to the box [mm].
    away = np.hypot(np.maximum(np.maximum(y - rows, rows - y - h), 0) * mm[0],
                    np.maximum(np.maximum(x - columns, columns - x - w), 0) * mm[1])
    ring, base = ((away >= low) & (away < high) & clear for low, high in (RING_MM, BASE_MM))
    ln, band = np.log(np.maximum(window.tone[here], 1e-4)), RING_MM[1]**2 - RING_MM[0]**2
    whole = (RING_MM[1] - RING_MM[0]) * 2 * (w * mm[1] + h * mm[0]) + np.pi * band
    if ring.sum() * mm[0] * mm[1] < whole / 2 or not base.any():
        return None
    ln = ln - np.median(ln[base])
    angle = np.arctan2((rows - y - h / 2) / h, (columns - x - w / 2) / w)
    sector = (np.floor((angle / (2 * np.pi) + 0.5) * SECTORS + 0.5) % SECTORS).astype(int)
    told = np.full((2, SECTORS), np.nan)
    for place in range(SECTORS):
        found = ln[ring & (sector == place)]
        if len(found) > 20:
            told[:, place] = found.mean(), found.std()
    told = np.where(np.isnan(told), np.nanmean(told, axis=1, keepdims=True), told)
    return np.concatenate([told.ravel(), np.percentile(ln[ring], [5, 50, 95])]).astype(np.float32)


def forest(x, y, seed, trees=80, depth=12, even=True):
    """A forest of decision trees (Breiman 2001), which has seen as many of one class as of each other where `even`."""
    if even:
        random, most = np.random.default_rng(seed), np.bincount(y).max()
        chosen = np.concatenate([random.choice(np.flatnonzero(y == kind), most) for kind in np.unique(y)])
        x, y = x[chosen], y[chosen]
    # Both are the library's own, and it draws from the one by as many threads as the other says.
    cv2.setRNGSeed(seed + 1)
    cv2.setNumThreads(1)
    made = cv2.ml.RTrees_create()
    made.setMaxDepth(depth)
    made.setMinSampleCount(2)
    made.setActiveVarCount(max(1, round(np.sqrt(x.shape[1]))))
    made.setTermCriteria((cv2.TERM_CRITERIA_MAX_ITER, trees, 0))
    made.train(np.ascontiguousarray(x, np.float32), cv2.ml.ROW_SAMPLE, y.astype(np.int32))
    return made


def votes(made, x, classes):
    """Shares of the trees for each class [n, classes]."""
    counts = made.getVotes(np.ascontiguousarray(x, np.float32), 0)
    shares = np.zeros((len(x), classes), np.float32)
    shares[:, counts[0]] = counts[1:] / counts[1].sum()
    return shares


def rings_of(windows):
    """Features of the rings of all knots, whether each knot is dead (1) or sound (0, cracked ones too), and its
    board."""
    told, kinds, boards = [], [], []
    for window in windows:
        for box in window.boxes:
            features = ring_features(window, box) if box.kind in KNOTS and min(box.w, box.h) >= 8 else None
            if features is not None:
                told.append(features)
                kinds.append(int(box.kind == "Dead_Knot"))
                boards.append(window.board)
    return Rings(np.array(told), np.array(kinds), np.array(boards))


def ring_test(rings, folds=5, seeds=3):
    """Balanced accuracy of a forest about the kind of knots by the rings around them; None where one kind is not
    there."""
    if len(np.unique(rings.dead)) < 2:
        return None
    names = np.unique(rings.board)
    share = np.zeros(len(rings.dead))
    for seed in range(seeds):
        dealt = np.random.default_rng(seed).permutation(len(names)) % folds
        fold = dealt[np.searchsorted(names, rings.board)]
        for number in range(folds):
            learn, ask = fold != number, fold == number
            if ask.any() and len(np.unique(rings.dead[learn])) == 2:
                share[ask] += votes(forest(rings.told[learn], rings.dead[learn], seed), rings.told[ask], 2)[:, 1]
    return balanced(rings.dead, (share > seeds / 2).astype(int), rings.board)


def shuffled(rings, seed):
    """The same rings with kinds dealt out anew, so that there is nothing to learn."""
    return rings._replace(dead=np.random.default_rng(seed).permutation(rings.dead))


def as_few(rings, few, seed):
    """As many sound and dead knots as `few` has, drawn from `rings`; None where there are not so many."""
    random, chosen = np.random.default_rng(seed), []
    for kind in (0, 1):
        places, count = np.flatnonzero(rings.dead == kind), (few.dead == kind).sum()
        if count > len(places):
            return None
        chosen.append(random.permutation(places)[:count])
    return Rings(*(column[np.concatenate(chosen)] for column in rings))


def equalised(x):
    """Windows [n, rows, columns] of ln(tone), each less its mean and over its standard deviation."""
    x = x - x.mean(axis=(1, 2), keepdims=True)
    return (x / np.maximum(x.std(axis=(1, 2), keepdims=True), 1e-6)).astype(np.float32)


def cut_windows(windows, shrink, side=SIDE, seed=0, each=EACH):
    """Windows of `side` x `side` px, each the mean of `shrink` x `shrink` px, at drawn places where all is measured
    and nothing has a label."""
    random, x, board = np.random.default_rng(seed), [], []
    names = sorted({window.board for window in windows})
    shares = {name: sum(window.board == name for window in windows) for name in names}
    for window in windows:
        small = resized(np.maximum(window.tone, 1e-4).astype(np.float32), (shrink, shrink))
        free = resized((window.known & ~window.labelled).astype(np.float32), (shrink, shrink)) > 0.999
        if min(free.shape) < side:
            continue
        total = np.pad(np.cumsum(np.cumsum(free, axis=0), axis=1), [(1, 0), (1, 0)])
        inside = total[side:, side:] - total[:-side, side:] - total[side:, :-side] + total[:-side, :-side]
        places = np.argwhere(inside == side * side)
        for top, left in places[random.permutation(len(places))[:max(1, each // shares[window.board])]]:
            x.append(np.log(small[top:top + side, left:left + side]))
            board.append(names.index(window.board))
    return Cut(equalised(np.array(x, np.float32).reshape(-1, side, side)), np.array(board, int))


def faded(side):
    """Weight of a window's pixels that fades towards its edges, so that these make no waves [side, side]."""
    return np.hanning(side)[:, None] * np.hanning(side)[None, :]


def octaves(pixel):
    """Octaves of wavelengths (from, to) [mm] that windows of pixels `pixel` (along, across) [mm] hold."""
    return [(2 * min(pixel) * 2**k, 4 * min(pixel) * 2**k) for k in range(int(np.log2(SIDE)) - 1)]


def reduced(cuts, what, pixel, seed=0):
    """Windows of both sets with all but one thing taken out: "tones", whose places are dealt out anew; "spectra",
    whose waves have their size and drawn phases; "phases", whose waves have the mean size of both sets; or an octave of
    wavelengths (from, to) [mm] in any direction."""
    random, made = np.random.default_rng(seed), []
    waves = [np.fft.rfft2(cut.x) for cut in cuts]
    mean = np.mean([np.abs(wave).mean(axis=0) for wave in waves], axis=0)
    for cut, wave in zip(cuts, waves):
        shape = cut.x.shape
        if what == "tones":
            x = random.permuted(cut.x.reshape(len(cut.x), -1), axis=1).reshape(shape)
        elif what == "spectra":
            noise = np.fft.rfft2(random.standard_normal(shape))
            x = np.fft.irfft2(np.abs(wave) * noise / np.abs(noise), shape[1:])
        elif what == "phases":
            x = np.fft.irfft2(mean * wave / np.maximum(np.abs(wave), 1e-9), shape[1:])
        else:
            rows, columns = np.fft.fftfreq(shape[1])[:, None] / pixel[0], np.fft.rfftfreq(shape[2])[None, :] / pixel[1]
            per_mm = np.hypot(rows, columns)
            wave = np.fft.rfft2(cut.x * faded(shape[1]))
            x = np.fft.irfft2(wave * ((per_mm > 1 / what[1]) & (per_mm <= 1 / what[0])), shape[1:])
        made.append(Cut(equalised(x), cut.board))
    return made


def small_network():
    """Four convolutions, each halving rows and columns, the mean over what is left, and one sum."""
    layers, planes = [], 1
    for wider, kernel in ((16, 5), (32, 3), (64, 3), (64, 3)):
        layers += [torch.nn.Conv2d(planes, wider, kernel, stride=2, padding=kernel // 2, bias=False),
                   torch.nn.BatchNorm2d(wider), torch.nn.ReLU()]
        planes = wider
    return torch.nn.Sequential(*layers, torch.nn.AdaptiveAvgPool2d(1), torch.nn.Flatten(), torch.nn.Dropout(0.2),
                               torch.nn.Linear(planes, 1))


def taught(x, y, seed, steps):
    """The network after `steps` batches of windows, as many of the one kind as of the other, each mirrored or not."""
    torch.manual_seed(seed)
    model, x, kinds = small_network(), torch.from_numpy(x)[:, None], [np.flatnonzero(y == kind) for kind in (0, 1)]
    random, half = np.random.default_rng(seed), 32
    optimiser = torch.optim.AdamW(model.parameters(), lr=3e-3, weight_decay=1e-2)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, 3e-3, total_steps=steps, pct_start=0.2)
    target = torch.cat([torch.zeros(half), torch.ones(half)])
    model.train()
    for _ in range(steps):
        seen = x[np.concatenate([random.choice(kind, half) for kind in kinds])]
        for axis in (2, 3):
            mirror = torch.from_numpy(random.random(len(seen)) < 0.5)
            seen[mirror] = seen[mirror].flip(axis)
        loss = torch.nn.functional.binary_cross_entropy_with_logits(model(seen)[:, 0], target)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        schedule.step()
    return model.eval()


def told_apart(one, other, seed=0, steps=STEPS):
    """Balanced accuracy of the network on boards that it has not seen, half of both kinds' boards at a time, and its
    logits, those of `one` first; above 0 says `other`."""
    x = np.concatenate([one.x, other.x])
    y = np.repeat([0, 1], [len(one.x), len(other.x)])
    board = np.concatenate([one.board, other.board + (one.board.max(initial=0) + 1)])
    random, half = np.random.default_rng(seed), {}
    for kind in (0, 1):
        boards = np.unique(board[y == kind])
        half.update(zip(random.permutation(boards).tolist(), (np.arange(len(boards)) % 2).tolist()))
    part, logits = np.array([half[name] for name in board.tolist()]), np.zeros(len(x), np.float32)
    for asked in (0, 1):
        model = taught(x[part != asked], y[part != asked], seed, steps)
        with torch.no_grad():
            some = torch.from_numpy(x[part == asked])[:, None].split(256)
            logits[part == asked] = torch.cat([model(windows)[:, 0] for windows in some])
    return balanced(y, (logits > 0).astype(int), board), logits


def control(cut, deals, steps=STEPS):
    """Mean balanced accuracy over `deals` of the boards of one set into two that differ in nothing, and the mean's
    standard error."""
    boards, shares = np.unique(cut.board), []
    for deal in range(deals):
        mine = np.isin(cut.board, np.random.default_rng(deal).permutation(boards)[::2])
        one, other = (Cut(cut.x[of], cut.board[of]) for of in (mine, ~mine))
        shares.append(told_apart(one, other, deal, steps)[0].share)
    return float(np.mean(shares)), float(np.std(shares, ddof=1) / np.sqrt(deals))


def spectra(one, other, pixel):
    """ln of power of the other's windows over the one's by direction and wavelength, an octave each: (direction, from
    [mm], to [mm], ln of the ratio, and that over the spread of boards of both)."""
    rows, columns = np.fft.fftfreq(SIDE)[:, None] / pixel[0], np.fft.rfftfreq(SIDE)[None, :] / pixel[1]
    waves, found = np.hypot(rows, columns), []
    steep = np.abs(rows) > np.abs(columns)
    for name, where, side in (("along", steep, pixel[0]), ("across", ~steep, pixel[1])):
        for octave in range(1, 6):
            low, high = side * 2**octave, side * 2**(octave + 1)
            of = where & (waves > 1 / high) & (waves <= 1 / low)
            powers = []
            for cut in (one, other):
                power = np.log((np.abs(np.fft.rfft2(cut.x * faded(SIDE))) ** 2)[:, of].mean(axis=1))
                powers.append(np.array([power[cut.board == board].mean() for board in np.unique(cut.board)]))
            apart = powers[1].mean() - powers[0].mean()
            spread = np.sqrt(np.mean([part.var(ddof=1) for part in powers]))
            found.append((name, low, high, float(apart), float(apart / spread)))
    return found
