"""Trains a small network on patches of a dataset that `gen` made, and writes it as ONNX with the sidecar of `gen check`.

    python python/train_baseline.py out/wood --task wood --out knots.onnx
    python python/train_baseline.py out/packs --task presence --out tablets.onnx --channels scatter
    gen check out/other --model knots.onnx --split all

Tasks: `wood` (clear, knot or rot at the middle of a window), `grading` (ten classes of a board's surface), `blister` (pocket with tablet, empty, with a broken tablet)
and `presence` (pocket with a tablet or without). Windows are cut, shrunk and normalised exactly as `gen check` does
(docs/guide/check.md). The same seed and number of threads give the same bytes on one machine.

Needs numpy, pyarrow, pillow, torch and onnx: `make venv` installs them. docs/theory/baselines.md has the figures.
"""

import argparse
import time
from pathlib import Path

from baseline_patches import CHANNELS, TASKS, cut_patches, open_dataset, torch
from baseline_network import answers, scaling, train, write_onnx, write_sidecar


def arguments():
    summary, rest = __doc__.split("\n", 1)
    parser = argparse.ArgumentParser(description=summary, epilog=rest, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, metavar="DIR", help="a dataset with train and validation splits")
    parser.add_argument("--task", choices=TASKS, required=True, help="what to learn")
    parser.add_argument("--out", type=Path, required=True, metavar="MODEL.onnx", help="the sidecar becomes MODEL.yaml")
    parser.add_argument("--channels", default=",".join(CHANNELS), help="maps to look at (default: %(default)s)")
    parser.add_argument("--patches", type=int, default=8000, help="drawn pixels of each class (default: %(default)s)")
    parser.add_argument("--epochs", type=int, default=12, help="times that each patch is seen (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of weights, order and drawn pixels (default: %(default)s)")
    parser.add_argument("--threads", type=int, default=1, help="threads to train with (default: %(default)s)")
    parser.add_argument("--shuffle-labels", action="store_true", help="control: deal the labels of training out anew")
    given = parser.parse_args()
    given.channels = given.channels.split(",")
    wrong = [name for name in given.channels if name not in CHANNELS]
    if wrong or len(set(given.channels)) < len(given.channels):
        parser.error(f"--channels takes some of {', '.join(CHANNELS)}, each once")
    if min(given.patches, given.epochs, given.threads) < 1:
        parser.error("--patches, --epochs and --threads are at least 1")
    if given.out.suffix != ".onnx" or not given.out.parent.is_dir():
        parser.error(f"--out {given.out}: give a name that ends in .onnx, in a folder that exists")
    sidecar = given.out.with_suffix(".yaml")
    if sidecar.exists() and "\ntask:" not in "\n" + sidecar.read_text(errors="replace"):
        parser.error(f"{sidecar} is there and is no sidecar (a recipe?), which --out would overwrite: give another name")
    return given


def main():
    given = arguments()
    torch.set_num_threads(given.threads)
    torch.use_deterministic_algorithms(True)
    task = TASKS[given.task]
    learn = cut_patches(given.folder, task, given.channels, "train", given.patches, given.seed)
    test = cut_patches(given.folder, task, given.channels, "validation", max(1, given.patches // 8), given.seed)
    told = scaling(learn, given.channels, task.logarithm)
    print(f"{len(learn.y)} patches to learn from, {len(test.y)} to validate with", flush=True)
    began = time.monotonic()

    def say(epoch, loss, model):
        right = (answers(model, test.x, told).argmax(1) == test.y).sum().item()
        print(f"epoch {epoch + 1}/{given.epochs}: loss {loss:.4f}, validation {right}/{len(test.y)} = "
              f"{right / len(test.y):.4f}, {time.monotonic() - began:.0f} s", flush=True)

    model = train(learn, told, len(task.classes), given.seed, given.epochs, given.shuffle_labels, say)
    write_onnx(model, len(given.channels), task, given.out)
    head = open_dataset(given.folder)
    note = f"Task {given.task}, trained on {head['recipe']['name']} by python/train_baseline.py; labels shuffled: {given.shuffle_labels}."
    write_sidecar(task, told, given.out.with_suffix(".yaml"), note, head["images"]["bits"], head)
    print(f"{given.out}: {given.out.stat().st_size} bytes, {sum(p.numel() for p in model.parameters())} parameters")


if __name__ == "__main__":
    main()
