"""PyTorch: random crops of full-size scans by DataLoader workers, and a small segmenter that learns from them.

    python python/examples/train_pytorch.py DIR [--split train] [--workers 2] [--crop 64] [--crops 4] [--steps 30]

How it stays fast and small:

- Only the columns of the asked channels are read, from files that are mapped into memory; each worker opens its own.
- A scan of 2560 x 4000 pixels takes 0.4 s to decode, so each decoded scan gives several crops, and crops are made
  floats, not scans. A worker holds one row group (at most 32 MB) and one scan.
- Scans are shuffled row group by row group, so that neighbours in a batch come from bytes that are in memory already.

How it stays reproducible: where crops lie follows from seed, epoch and the sample's index, never from the worker or from
what was drawn before. Two runs with any number of workers give the same tensors.
"""

import argparse
import hashlib
from pathlib import Path

from sheetlight_schema import images, needed, open_dataset

with needed():
    import cv2
    import numpy as np
    import pyarrow.parquet as pq
    import torch
    from torch import nn
    from torch.utils.data import DataLoader, Dataset, Sampler


class Scans(Dataset):
    """Crops of the scans of one split. An item is asked for by epoch and number, and is

    - maps: float32 [crops, channels + 1, crop, crop], normalised, 0 where missing; the last one is 1 where measured,
    - labels: int64 [crops, crop, crop], 0 to classes - 1,
    - places: int64 [crops, 3], sample's index, first row, first column.
    """

    def __init__(self, root, head, split, channels=("range", "reflectance", "scatter"), crop=64, crops=4, seed=0):
        self.files = sorted((Path(root) / "data").rglob(f"{split}-*.parquet"))
        if not self.files:
            raise SystemExit(f"{root} has no samples of the split {split}; make more samples, or give --split")
        # Footers alone: where each row lies, as file, row group and row in it.
        self.rows = np.array([place for number, file in enumerate(self.files) for place in rows_of(number, file)])
        self.unit = "px" if head["images"]["range"] == "uncalibrated" else "mm"
        self.channels, self.crops, self.seed = channels, crops, seed
        self.crop = min(crop, head["images"]["rows"], head["images"]["cols"])
        # Values of labels -> 0 to classes - 1: a subject has few of all pixel classes.
        self.classes = [head["pixel_classes"][value] for value in head["label_values"]]
        self.class_of = np.zeros(256, np.int64)
        self.class_of[head["label_values"]] = np.arange(len(self.classes))
        self.mean, self.deviation = np.zeros(len(channels), np.float32), np.ones(len(channels), np.float32)
        self.group = None  # the row group that this process read last

    def __len__(self):
        return len(self.rows)

    def __getstate__(self):
        return {**self.__dict__, "group": None}  # workers that are spawned open their own

    def row(self, number):
        """The wanted columns of one row."""
        file, group, at = self.rows[number]
        if self.group is None or self.group[0] != (file, group):
            columns = ["index"] + [f"{name}.bytes" for name in (*self.channels, "label")]
            columns += [f"range_offset_{self.unit}", f"range_scale_{self.unit}"]
            table = pq.ParquetFile(self.files[file], memory_map=True).read_row_group(group, columns=columns)
            self.group = ((file, group), table)
        return self.group[1].slice(at, 1)

    def decode(self, row, name):
        """Pixels of an image, uint8 or uint16 [rows, cols]; the PNG is not copied."""
        png = row[name].chunk(0).field("bytes")[0].as_buffer()
        return cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_UNCHANGED)

    def physical(self, row, name, pixels):
        """Pixels in mm (or px) and DN, float32."""
        if name != "range":
            return pixels.astype(np.float32)
        offset, scale = (row[f"range_{what}_{self.unit}"][0].as_py() for what in ("offset", "scale"))
        return (offset + scale * pixels).astype(np.float32)

    def __getitem__(self, key):
        epoch, number = key
        row = self.row(number)
        index = row["index"][0].as_py()
        scan = [self.decode(row, name) for name in self.channels]
        label = self.decode(row, "label")
        rng = np.random.default_rng([self.seed, epoch, index])
        size = self.crop
        maps = np.zeros((self.crops, len(scan) + 1, size, size), np.float32)
        labels = np.zeros((self.crops, size, size), np.int64)
        places = np.zeros((self.crops, 3), np.int64)
        for k in range(self.crops):
            top, left = (rng.integers(0, length - size + 1) for length in label.shape)
            window = np.s_[top : top + size, left : left + size]
            seen = scan[0][window] > 0
            for c, name in enumerate(self.channels):
                values = self.physical(row, name, scan[c][window])
                maps[k, c] = np.where(seen, (values - self.mean[c]) / self.deviation[c], 0)
            maps[k, -1] = seen
            labels[k] = self.class_of[label[window]]
            places[k] = index, top, left
        # Turned about rows a scan would be none: laser and camera look from different sides. Columns may be mirrored.
        return torch.from_numpy(maps), torch.from_numpy(labels), torch.from_numpy(places)

    def measure(self, most=16):
        """Sets mean and deviation of each channel, from crops of some scans over the whole split."""
        chosen = np.unique(np.linspace(0, len(self) - 1, min(most, len(self))).astype(int))
        maps = torch.cat([self[0, number][0] for number in chosen]).movedim(1, 0).double()
        seen = maps[-1] > 0
        for c in range(len(self.channels)):
            values = maps[c][seen]
            self.mean[c], self.deviation[c] = values.mean(), max(values.std(), 1e-6)


def rows_of(number, file):
    footer = pq.read_metadata(file)
    return [(number, group, at) for group in range(footer.num_row_groups) for at in range(footer.row_group(group).num_rows)]


class Shuffled(Sampler):
    """Epoch and number of each scan: row groups in random order, and the rows of each in random order."""

    def __init__(self, scans, seed=0):
        self.scans, self.seed, self.epoch = scans, seed, 0

    def __len__(self):
        return len(self.scans)

    def __iter__(self):
        rng = np.random.default_rng([self.seed, self.epoch])
        _, group = np.unique(self.scans.rows[:, :2], axis=0, return_inverse=True)
        order = np.lexsort((rng.random(len(group)), rng.permutation(group.max() + 1)[group.ravel()]))
        epoch, self.epoch = self.epoch, self.epoch + 1
        yield from ((epoch, int(number)) for number in order)


def joined(items):
    """Crops of several scans as one batch [B, C, H, W]."""
    return tuple(torch.cat(parts) for parts in zip(*items))


def one_thread(_):
    """Workers are the parallelism; threads of each would only compete."""
    cv2.setNumThreads(0)
    torch.set_num_threads(1)


def segmenter(channels, classes):
    return nn.Sequential(
        nn.Conv2d(channels, 16, 5, padding=2), nn.ReLU(),
        nn.Conv2d(16, 16, 5, padding=2), nn.ReLU(),
        nn.Conv2d(16, classes, 1),
    )  # fmt: skip


def main():
    known = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    known.add_argument("dir", type=Path)
    known.add_argument("--split", default="train")
    known.add_argument("--crop", type=int, default=64, help="rows and columns of a crop [px]")
    known.add_argument("--crops", type=int, default=4, help="crops of each decoded scan")
    known.add_argument("--scans", type=int, default=4, help="scans in a batch")
    known.add_argument("--steps", type=int, default=30)
    known.add_argument("--workers", type=int, default=2)
    known.add_argument("--seed", type=int, default=0)
    given = known.parse_args()
    if min(given.crop, given.crops, given.scans, given.steps) < 1 or given.workers < 0:
        known.error("--crop, --crops, --scans and --steps are at least 1, --workers at least 0")

    head = open_dataset(given.dir)
    images(head, "range", "reflectance", "scatter", "label")
    scans = Scans(given.dir, head, given.split, crop=given.crop, crops=given.crops, seed=given.seed)
    scans.measure()
    print("channels:", ", ".join(f"{n} {m:.4f} +- {d:.4f}" for n, m, d in zip(scans.channels, scans.mean, scans.deviation)))
    loader = DataLoader(
        scans, batch_size=given.scans, sampler=Shuffled(scans, given.seed), collate_fn=joined, num_workers=given.workers,
        worker_init_fn=one_thread, persistent_workers=given.workers > 0,
        generator=torch.Generator().manual_seed(given.seed),
    )  # fmt: skip

    torch.manual_seed(given.seed)
    model = segmenter(len(scans.channels) + 1, len(scans.classes))
    optimiser = torch.optim.Adam(model.parameters(), 0.01)
    digest, step = hashlib.sha256(), 0
    while step < given.steps:
        for maps, labels, places in loader:
            if step == 0:
                print(f"batch: {list(maps.shape)} {maps.dtype}, labels {list(labels.shape)} {labels.dtype}")
                show(scans, maps, labels, places)
            digest.update(maps.numpy().tobytes() + labels.numpy().tobytes() + places.numpy().tobytes())
            loss = nn.functional.cross_entropy(model(maps), labels)
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
            if step in (0, given.steps - 1):
                gradient = model[0].weight.grad.norm().item()
                right = (model(maps).argmax(1) == labels).float().mean().item()
                print(f"step {step}: loss {loss.item():.4f}, gradient {gradient:.4f}, pixels right {right:.4f}")
            step += 1
            if step == given.steps:
                break
    print("sha256 of all batches:", digest.hexdigest())


def show(scans, maps, labels, places):
    """What is in the crops, in units again."""
    for k, (index, top, left) in enumerate(places.tolist()):
        seen = maps[k, -1] > 0
        sums = [(maps[k, c].double()[seen] * d + m).sum().item() for c, (m, d) in enumerate(zip(scans.mean.tolist(), scans.deviation.tolist()))]
        words = ", ".join(f"{name} {value:.3f}" for name, value in zip(scans.channels, sums))
        print(f"crop of sample {index} at row {top}, column {left}: seen {seen.sum()}, sums {words}, labels {labels[k].sum()}")


if __name__ == "__main__":
    main()
