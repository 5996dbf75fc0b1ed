"""What each channel is worth: trains the network of train_baseline.py on every choice of channels and on shuffled labels,
and lets `gen check` judge each on fresh data. Prints Markdown; docs/theory/baselines.md has its tables.

    python python/ablate_baselines.py --task wood --train out/train/wood --fresh out/fresh/wood

All trainings of a task have the same patches, epochs and seeds. Accuracy is the mean of the seeds; its standard error is
the sampling error that `gen check` finds (patches of one sample are not independent) and the spread between seeds together.

Ends with status 1 where the mean recall of the trainings on shuffled labels lies more than three standard errors from
chance: then they learned what they were not taught. `--shuffles 0` leaves them out.
"""

import argparse
import itertools
import json
import math
import statistics
import subprocess
import sys
import tempfile
from collections import namedtuple
from pathlib import Path

import baseline_network as network
from baseline_patches import CHANNELS, TASKS, cut_patches, np, open_dataset, torch

# What `gen check` says of a model: accuracy and its standard error, mean recall and the number of independent patches.
Judged = namedtuple("Judged", "share error recall effective")


def judged(gen, model, fresh):
    """How a model does on fresh data, by `gen check`."""
    command = [gen, "check", fresh, "--model", model, "--split", "all", "--json", "--threads", "1"]
    run = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    if run.returncode:
        sys.exit(f"gen check of {model} failed:\n{run.stderr}")
    told = json.loads(run.stdout)
    sure = told["accuracy"]
    # Half of the 95 % interval, which is not nothing where all answers are right.
    error = (sure["high"] - sure["low"]) / (2 * 1.96)
    recall = statistics.fmean(known["recall"] for known in told["classes"])
    return Judged(sure["accuracy"], error, recall, sure["effective"])


def beyond_chance(runs, chance):
    """Mean recall of some trainings, their spread, and how many standard errors the mean lies from chance. All are judged
    by the same data, so that the sampling error does not shrink with their number, as the spread between them does."""
    recalls = [run.recall for run in runs]
    mean, spread = statistics.fmean(recalls), statistics.stdev(recalls)
    sampling = math.sqrt(chance * (1 - chance) / statistics.fmean(run.effective for run in runs))
    return mean, spread, (mean - chance) / math.hypot(sampling, spread / math.sqrt(len(runs)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--task", choices=TASKS, required=True)
    parser.add_argument("--train", type=Path, required=True, metavar="DIR", help="dataset to learn from")
    parser.add_argument("--fresh", type=Path, required=True, metavar="DIR", help="dataset of another seed to judge by")
    parser.add_argument("--gen", type=Path, default=Path("target/release/gen"), help="the program (default: %(default)s)")
    parser.add_argument("--seeds", type=int, default=2, help="trainings of each choice (default: %(default)s)")
    parser.add_argument("--shuffles", type=int, default=8, help="trainings on shuffled labels (default: %(default)s)")
    parser.add_argument("--patches", type=int, default=3000, help="drawn pixels of each class (default: %(default)s)")
    parser.add_argument("--epochs", type=int, default=8, help="times that each patch is seen (default: %(default)s)")
    given = parser.parse_args()
    if min(given.seeds, given.patches, given.epochs) < 1 or given.shuffles < 0 or given.shuffles == 1:
        parser.error("--seeds, --patches and --epochs are at least 1, --shuffles 0 or at least 2 (one has no spread)")
    torch.set_num_threads(1)
    torch.use_deterministic_algorithms(True)
    task = TASKS[given.task]
    everything = cut_patches(given.train, task, CHANNELS, "train", given.patches, 0)
    told = network.scaling(everything, CHANNELS, task.logarithm)
    bits = open_dataset(given.train)["images"]["bits"]
    choices = [list(c) for n in (1, 2, 3) for c in itertools.combinations(range(len(CHANNELS)), n)]
    with tempfile.TemporaryDirectory() as place:
        model = Path(place) / "model.onnx"

        def trained(chosen, seed, shuffle):
            patches = everything._replace(x=everything.x[:, chosen])
            scale = [told[channel] for channel in chosen]
            made = network.train(patches, scale, len(task.classes), seed, given.epochs, shuffle)
            network.write_onnx(made, len(chosen), task, model)
            network.write_sidecar(task, scale, model.with_suffix(".yaml"), "ablation", bits)
            return judged(given.gen, model, given.fresh)

        print(f"\n{given.task}: {len(everything.y)} patches, {given.epochs} epochs, {given.seeds} seeds\n")
        print("| range | reflectance | scatter | accuracy | standard error | mean recall |\n|---|---|---|---|---|---|", flush=True)
        for chosen in choices:
            runs = [trained(chosen, seed, False) for seed in range(given.seeds)]
            shares = [run.share for run in runs]
            between = statistics.stdev(shares) / math.sqrt(len(shares)) if len(shares) > 1 else 0
            error = math.hypot(statistics.fmean(run.error for run in runs), between)
            marks = " | ".join("x" if channel in chosen else " " for channel in range(len(CHANNELS)))
            recall = statistics.fmean(run.recall for run in runs)
            print(f"| {marks} | {statistics.fmean(shares):.4f} | {error:.4f} | {recall:.4f} |", flush=True)
        shuffled = [trained(choices[-1], 1000 + seed, True) for seed in range(given.shuffles)]
    if shuffled:
        chance = 1 / len(task.classes)
        mean, spread, beyond = beyond_chance(shuffled, chance)
        print(f"\nshuffled labels, {len(shuffled)} trainings: mean recall {mean:.4f}, spread between trainings {spread:.4f}, "
              f"chance {chance:.4f}, {beyond:+.1f} standard errors")
        if abs(beyond) > 3:
            sys.exit(f"networks that were taught shuffled labels lie {beyond:+.1f} standard errors from chance: they learned "
                     "what they were not taught")


if __name__ == "__main__":
    main()
