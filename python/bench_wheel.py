"""What the Python package costs: samples rendered in this process against `gen`, and what workers of a DataLoader gain.

    .venv-wheel/bin/python -P python/bench_wheel.py [--pairs 9] [--crops 96] [--only rendering]

- **Rendering** is compared with `gen --estimate`, which renders the first four samples with one thread and writes nothing; with a recipe that
  keeps no images there is nothing to encode either. Both in turn, and the median of the pairs' ratios. 1.05 is the bar.
- **Workers**: crops of wood-train by a DataLoader with one and with two workers, each worker with one thread, from the first batch to the
  last. 1.8 is the bar, on two cores that nobody else uses. Processor time of a crop is told too: where it stays the same,
  workers do not get in each other's way.
"""

import argparse
import os
import statistics
import time

import sheetlight
from sheetlight import _gen


def main():
    known = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    known.add_argument("--pairs", type=int, default=9, help="runs of each kind")
    known.add_argument("--crops", type=int, default=96, help="crops that workers render in each run")
    known.add_argument("--only", choices=["rendering", "workers"])
    given = known.parse_args()
    if given.only != "workers":
        rendering(given.pairs)
    if given.only != "rendering":
        workers(given.crops, given.pairs)


def rendering(pairs):
    name, changes = "wood-small", {"output.png": [], "output.exr": [], "output.truth_maps": False}
    sets = _gen.set_arguments(changes)
    ratios = []
    for _ in range(pairs):
        estimate = _gen.run_json(["--recipe", name, *sets, "--n", "4", "--threads", "1", "--out", "out/none", "--estimate"])
        # `gen` too renders one sample before it takes the time; patterns of speckle of the others are new to both.
        recipe = sheetlight.Recipe.load(name, changes)
        recipe.sample(0, threads=1)
        begun = time.perf_counter()
        for sample in recipe.samples(4, threads=1):
            sample.scatter
        seconds = (time.perf_counter() - begun) / 4
        ratios.append(seconds / estimate["seconds_per_sample"])
        print(f"{name}: {seconds:.3f} s a sample here, {estimate['seconds_per_sample']:.3f} s by gen --estimate")
    print(f"rendering: ratio {statistics.median(ratios):.3f} ({min(ratios):.3f} to {max(ratios):.3f})")


class Timed:
    """Crops with the processor time that each took [s]."""

    def __init__(self, scans):
        self.scans = scans

    def __len__(self):
        return len(self.scans)

    def __getitem__(self, number):
        begun = time.process_time()
        item = self.scans[number]
        return {**item, "cpu_s": time.process_time() - begun}


def workers(crops, pairs):
    from torch.utils.data import DataLoader

    import sheetlight.torch

    recipe = sheetlight.Recipe.load("wood-train")
    scans = Timed(sheetlight.torch.Scans(recipe, crops + 8, crop=64))
    gains = []
    for _ in range(pairs):
        rates = {}
        for count in (1, 2):
            batches = iter(DataLoader(scans, batch_size=4, num_workers=count))
            # Workers have started, and have what samples have in common.
            for _ in range(2):
                next(batches)
            begun, found, used = time.perf_counter(), 0, 0.0
            for batch in batches:
                found += len(batch["index"])
                used += float(batch["cpu_s"].sum())
            rates[count] = found / (time.perf_counter() - begun)
            print(f"wood-train: {count} worker{'s'[: count - 1]}: {rates[count]:.2f} crops a second, {used / found:.3f} s of processor each")
        gains.append(rates[2] / rates[1])
    spread = f"{min(gains):.2f} to {max(gains):.2f}"
    print(f"workers: two deliver {statistics.median(gains):.2f} times as fast as one ({spread}), {os.cpu_count()} cores")


if __name__ == "__main__":
    main()
