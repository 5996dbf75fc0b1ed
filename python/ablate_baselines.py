"""What each channel is worth: trains the network of train_baseline.py on every choice of channels and on shuffled labels,
and lets `gen check` judge each on fresh data. Prints Markdown; docs/baselines.md has its tables.

    python python/ablate_baselines.py --task wood --train out/train/wood --fresh out/fresh/wood

All trainings of a task have the same patches, epochs and seeds. Accuracy is the mean of the seeds; its standard error is
the sampling error that `gen check` finds (patches of one sample are not independent) and the spread between seeds together.
"""

import argparse
import itertools
import json
import math
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import baseline_network as network
from baseline_patches import CHANNELS, TASKS, cut_patches, np, open_dataset, torch


def judged(gen, model, fresh):
    """Accuracy of a model, its standard error and its mean recall, by `gen check`."""
    command = [gen, "check", fresh, "--model", model, "--split", "all", "--json", "--threads", "1"]
    run = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    if run.returncode:
        sys.exit(f"gen check of {model} failed:\n{run.stderr}")
    told = json.loads(run.stdout)
    share, sure = told["accuracy"]["accuracy"], told["accuracy"]["effective"]
    recalls = [known["recall"] for known in told["classes"]]
    return share, math.sqrt(share * (1 - share) / sure), statistics.fmean(recalls)


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
    if min(given.seeds, given.patches, given.epochs) < 1 or given.shuffles < 2:
        parser.error("--seeds, --patches and --epochs are at least 1, --shuffles 2")
    torch.set_num_threads(1)
    torch.use_deterministic_algorithms(True)
    task = TASKS[given.task]
    everything = cut_patches(given.train, task, CHANNELS, "train", given.patches, 0)
    told = network.scaling(everything, CHANNELS)
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
            shares = [share for share, _, _ in runs]
            between = statistics.stdev(shares) / math.sqrt(len(shares)) if len(shares) > 1 else 0
            error = math.hypot(statistics.fmean(error for _, error, _ in runs), between)
            marks = " | ".join("x" if channel in chosen else " " for channel in range(len(CHANNELS)))
            recall = statistics.fmean(recall for _, _, recall in runs)
            print(f"| {marks} | {statistics.fmean(shares):.4f} | {error:.4f} | {recall:.4f} |", flush=True)
        recalls = [trained(choices[-1], 1000 + seed, True)[2] for seed in range(given.shuffles)]
    if len(recalls) > 1:
        mean, error = np.mean(recalls), np.std(recalls, ddof=1) / math.sqrt(len(recalls))
        chance = 1 / len(task.classes)
        print(f"\nshuffled labels, {len(recalls)} trainings: mean recall {mean:.4f} +- {error:.4f}, chance {chance:.4f}, "
              f"{(mean - chance) / error:+.1f} standard errors")


if __name__ == "__main__":
    main()
