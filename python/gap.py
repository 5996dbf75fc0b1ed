"""What the fast model of light costs: trains networks on boards or packs that `transport: kernel` rendered, and asks them about
fresh ones twice, rendered by the kernel and by the reference Monte Carlo, which no network ever saw. Prints Markdown.

    python python/gap.py --task wood --train out/gap/wood/train --kernel out/gap/wood/kernel --path out/gap/wood/path

`make gap` renders the datasets and runs this; docs/theory/baselines.md has the tables. Both fresh datasets come from one recipe, seed and
`--samples-per-shard`, so that sample i is the same object under the same bench and noise, and every answer has a partner.

Accuracy lost is the mean over trainings of the share of right answers by the kernel less that by the reference. Its interval has
the standard error between samples (answers about one board are not independent: the linearised ratio of sums by sample) and that
between trainings together, and Student's quantile. Where fewer than five samples are answered differently, each end is at least
Clopper and Pearson's bound (1934) for the share of samples that lose, or gain, an answer.

Two more datasets say how much of it is chance of the reference, which a finite number of photons leaves in its maps:

    --fewer DIR     the same samples by `transport: path` with fewer photons per profile: the noise of photons that --path has
                    follows from the difference, and what it alone costs is asked of kernel's maps to which so much was added
    --quiet DIR     some of them by the kernel with neither speckle nor noise of the sensor: what noise of photons is compared with

`--control DIR` are the same samples by another transport (`transport: thesis`): a loss there says that one can be found here.

Ends with status 1 where the whole interval lies above `--bar`.
"""

import argparse
import io
import math
import sys
from collections import namedtuple
from pathlib import Path

import baseline_network as network
from baseline_patches import (CHANNELS, TASKS, cut_patches, draw_pixels, measured, np, object_windows, open_dataset,
                              plan_pixels, rows, torch, truth_of)
from PIL import Image

# Windows of recipes/gap [px], of nearly the same size in millimetres as those of train_baseline.py, and what becomes of them.
WINDOWS = {"wood": ((24, 64), (24, 32)), "presence": ((40, 128), (40, 32))}
# Standard normal quantile of 97.5 %.
Z = 1.959964
# Samples answered differently, below which their number alone gives the interval.
FEW = 5

# Accuracy lost [1], its 95 % interval, how many samples lost and gained answers, of how many.
Loss = namedtuple("Loss", "mean low high lost gained samples")


def student(freedom):
    """Quantile of 97.5 % of Student's t by Cornish and Fisher's expansion; within 0.001 from four degrees of freedom on."""
    z = Z
    return (z + (z**3 + z) / (4 * freedom) + (5 * z**5 + 16 * z**3 + 3 * z) / (96 * freedom**2)
            + (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / (384 * freedom**3)
            + (79 * z**9 + 776 * z**7 + 1482 * z**5 - 1920 * z**3 - 945 * z) / (92160 * freedom**4))


def most_share(k, n):
    """Upper end of Clopper and Pearson's two-sided 95 % interval for a share, after k of n."""
    if k >= n:
        return 1.0

    def at_most_k(p):
        return sum(math.comb(n, i) * p**i * (1 - p)**(n - i) for i in range(k + 1))

    low, high = k / n, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if at_most_k(middle) > 0.025 else (low, middle)
    return high


def sign_test(lost, gained):
    """Two-sided chance of so uneven a split of the samples that differ, were either way as likely: McNemar's exact test, where
    each sample has one answer."""
    n = lost + gained
    return min(1.0, 2 * sum(math.comb(n, i) for i in range(min(lost, gained) + 1)) / 2**n) if n else 1.0


def accuracy_lost(before, after, sample):
    """Loss from answers `before` to answers `after`, right or wrong [trainings, items], items of the samples `sample`."""
    lost = before.astype(np.float64) - after
    _, place = np.unique(sample, return_inverse=True)
    samples = place.max() + 1
    if samples < 5:
        sys.exit(f"{samples} samples give no interval: render at least 5")
    sizes = np.bincount(place)
    sums = np.bincount(place, lost.mean(axis=0))
    mean = sums.sum() / sizes.sum()
    sampling = math.sqrt(samples / (samples - 1) * ((sums - mean * sizes)**2).sum()) / sizes.sum()
    trainings = len(lost)
    between = lost.mean(axis=1).std(ddof=1) / math.sqrt(trainings) if trainings > 1 else 0.0
    half = student(samples - 1) * math.hypot(sampling, between)
    low, high = mean - half, mean + half
    # What differs at all counts here, be it that gains in one training undo losses in another.
    differing = np.bincount(place, np.abs(lost).max(axis=0)) > 0
    losing, gaining = (sums > 1e-9).sum(), (sums < -1e-9).sum()
    if differing.sum() < FEW:
        low, high = min(low, -most_share(int(gaining), samples)), max(high, most_share(int(losing), samples))
    return Loss(float(mean), max(float(low), -1.0), min(float(high), 1.0), int(losing), int(gaining), int(samples))


def points(loss):
    """A loss and its interval in percentage points."""
    return f"{100 * loss.mean:+.2f} | {100 * loss.low:+.2f} to {100 * loss.high:+.2f}"


def transport(head):
    return head["recipe"]["canonical"]["transport"]


def same_objects(folder, head, other, other_head):
    """Ends the program where sample i of two datasets is not the same object, or lies in another shard."""
    mine, its = head["recipe"]["canonical"], other_head["recipe"]["canonical"]
    free = {"transport", "exposure", "speckle", "output", "classes"}
    unlike = [key for key in sorted({*mine, *its} - free) if mine.get(key) != its.get(key)]
    unlike += ["seed"] if head["seed"] != other_head["seed"] else []
    unlike += ["samples_per_shard"] if head["samples_per_shard"] != other_head["samples_per_shard"] else []
    if unlike:
        sys.exit(f"{folder} and {other} differ in {', '.join(unlike)}: render both with one recipe, --seed and "
                 "--samples-per-shard, and change the key transport alone")


def patches_of(folder, task, patches, reference=None):
    """All patches of a fresh dataset; with a `reference`, those of the same places as there."""
    cut = cut_patches(folder, task, list(CHANNELS), None, patches, 0)
    if reference is not None and not (torch.equal(cut.y, reference.y) and np.array_equal(cut.sample, reference.sample)):
        sys.exit(f"{folder} has other samples than the dataset that it is compared with: give both the same --n")
    return cut


def tables_of(folder):
    """Tables of a dataset in the order of cut_patches."""
    return [table for table in sorted((folder / "data").rglob("*.parquet")) if not table.name.startswith(".")]


def kinds_of(folder, task, patches):
    """What each patch of patches_of is, a word each: the state of a pocket, or whether the window shows an edge of the board."""
    head = open_dataset(folder)
    truth, names, told = truth_of(head, task), head["pixel_classes"], []
    pixels = task.kind == "classify_pixels"
    wanted = plan_pixels(tables_of(folder), task, truth, names, patches) if pixels else None
    for row in rows(tables_of(folder), ["index", "label" if pixels else "objects"], 8):
        if pixels:
            labels = np.asarray(Image.open(io.BytesIO(row["label"]["bytes"])))
            background = labels == names.index("background")
            firsts, _ = draw_pixels(labels, task, truth, wanted[row["index"]], 0, row["index"])
            edge = [background[r:r + task.window[0], c:c + task.window[1]].any() for r, c in firsts]
            told += ["an edge of the board in the window" if at else "board alone" for at in edge]
        else:
            for thing in row["objects"]:
                if object_windows([thing], task, truth)[0]:
                    told.append(names[thing["state"]])
    return np.array(told)


def maps_of(folder):
    """The maps of each sample by its index: measured values, their dark level, labels."""
    head = open_dataset(folder)
    columns = ["index", "range_offset_mm", "range_scale_mm", "exposure", "physics", "label", *CHANNELS]
    for row in rows(tables_of(folder), columns, 4):
        dark = {"range": 0.0, "reflectance": row["exposure"]["dark_level_dn"], "scatter": row["physics"]["scatter_dark_dn"]}
        labels = np.asarray(Image.open(io.BytesIO(row["label"]["bytes"])))
        yield row["index"], {name: measured(row, name) for name in CHANNELS}, dark, labels, head["pixel_classes"]


def noise_between(folder, other):
    """Root mean square over samples of the half width of the central 68.3 % of differences of pixels on the object, a number each
    map: the standard deviation, were it a normal law. Places where the line was lost in one of both do not widen it."""
    others = {index: maps for index, maps, *_ in maps_of(other)}
    widths = {name: [] for name in CHANNELS}
    for index, maps, _, labels, names in maps_of(folder):
        if index in others:
            for name in CHANNELS:
                apart = (maps[name] - others[index][name])[labels != names.index("background")]
                low, high = np.nanquantile(apart, [0.1587, 0.8413])
                widths[name].append((high - low) / 2)
    if not widths["range"]:
        sys.exit(f"{folder} and {other} have no sample in common: render both from sample 0 on")
    return {name: math.sqrt(np.mean(np.square(found))) for name, found in widths.items()}, len(widths["range"])


def light_by_class(kernel, path, task):
    """How much more light the reference sees than the kernel, in Reflectance and Scatter above dark and by class of the task: mean
    and standard error over samples [1], and the number of samples."""
    truth = truth_of(open_dataset(kernel), task)
    its = {index: maps for index, maps, *_ in maps_of(path)}
    ratios = {}
    for index, maps, dark, labels, _ in maps_of(kernel):
        for number, name in enumerate(task.classes):
            for channel in ("reflectance", "scatter"):
                mine, other = maps[channel], its[index][channel]
                here = (truth[labels] == number) & ~np.isnan(mine) & ~np.isnan(other)
                if here.sum() >= 20:
                    before, after = (plane[here].mean(dtype=np.float64) - dark[channel] for plane in (mine, other))
                    if before > 1:
                        ratios.setdefault((name, channel), []).append(after / before - 1)
    return {key: (np.mean(found), np.std(found, ddof=1) / math.sqrt(len(found)), len(found))
            for key, found in ratios.items() if len(found) > 1}


def exchanged(kernel, path, channels):
    """Kernel's windows, of which some maps are the reference's."""
    x = kernel.x.clone()
    for channel in channels:
        x[:, channel] = path.x[:, channel]
    return x


def with_photon_noise(kernel, path, fewer, ratio):
    """Kernel's windows with as much noise as photons left in the reference's: the difference of two numbers of photons has
    1 + `ratio` times the variance of the larger number, which is `ratio` times the smaller."""
    noise = (fewer.x.float() - path.x.float()) / math.sqrt(1 + ratio)
    return (kernel.x.float() + torch.nan_to_num(noise)).to(kernel.x.dtype)


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--task", choices=WINDOWS, required=True, help="what to learn")
    parser.add_argument("--train", type=Path, required=True, metavar="DIR", help="dataset by the kernel to learn from")
    parser.add_argument("--kernel", type=Path, required=True, metavar="DIR", help="fresh samples of another seed by the kernel")
    parser.add_argument("--path", type=Path, required=True, metavar="DIR", help="the same by `transport: path`")
    parser.add_argument("--fewer", type=Path, metavar="DIR", help="the same with fewer photons per profile")
    parser.add_argument("--quiet", type=Path, metavar="DIR", help="the same by the kernel without speckle and noise of the sensor")
    parser.add_argument("--control", type=Path, metavar="DIR", help="the same by another transport, which should lose")
    parser.add_argument("--trainings", type=int, default=5, help="networks to train (default: %(default)s)")
    parser.add_argument("--patches", type=int, default=8000, help="drawn pixels of each class to learn from (default: %(default)s)")
    parser.add_argument("--asked", type=int, default=1500, help="drawn pixels of each class to ask about (default: %(default)s)")
    parser.add_argument("--epochs", type=int, default=12, help="times that each patch is seen (default: %(default)s)")
    parser.add_argument("--bar", type=float, default=2.0, help="points of accuracy that may be lost (default: %(default)s)")
    parser.add_argument("--threads", type=int, default=1, help="threads to train with (default: %(default)s)")
    given = parser.parse_args()
    if min(given.trainings, given.patches, given.asked, given.epochs, given.threads) < 1:
        parser.error("--trainings, --patches, --asked, --epochs and --threads are at least 1")
    return given


def check_heads(given):
    """The heads of the datasets by their option; ends the program where one does not belong to the others."""
    folders = {name: getattr(given, name) for name in ("train", "kernel", "path", "fewer", "quiet", "control")}
    heads = {name: open_dataset(folder) for name, folder in folders.items() if folder is not None}
    for name, model in {"train": "kernel", "kernel": "kernel", "path": "path", "fewer": "path", "quiet": "kernel"}.items():
        if name in heads and transport(heads[name])["model"] != model:
            sys.exit(f"{folders[name]} was rendered by `transport: {transport(heads[name])['model']}`, and --{name} takes "
                     f"`transport: {model}`: name another folder, or render it with --set transport={model}")
    for name in ("path", "fewer", "quiet", "control"):
        if name in heads:
            same_objects(given.kernel, heads["kernel"], folders[name], heads[name])
    if heads["train"]["seed"] == heads["kernel"]["seed"]:
        sys.exit(f"{given.train} and {given.kernel} have the seed {heads['kernel']['seed']} in common, and with it samples: render "
                 "one with another --seed")
    if "fewer" in heads:
        many, few = (transport(heads[name])["photons_per_profile"] for name in ("path", "fewer"))
        if few >= many:
            sys.exit(f"{given.fewer} has {few} photons per profile, and {given.path} {many}: --fewer takes fewer")
    return heads


def main():
    given = arguments()
    heads = check_heads(given)
    torch.set_num_threads(given.threads)
    torch.use_deterministic_algorithms(True)
    window, size = WINDOWS[given.task]
    task = TASKS[given.task]._replace(window=window, size=size)
    learn = cut_patches(given.train, task, list(CHANNELS), None, given.patches, 0)
    kernel = patches_of(given.kernel, task, given.asked)
    path = patches_of(given.path, task, given.asked, kernel)
    asked = {"the reference": path.x}
    for channel, name in enumerate(CHANNELS):
        asked[f"the reference in {name.capitalize()} alone"] = exchanged(kernel, path, [channel])
    if given.fewer:
        ratio = transport(heads["path"])["photons_per_profile"] / transport(heads["fewer"])["photons_per_profile"]
        fewer = patches_of(given.fewer, task, given.asked, kernel)
        asked["the kernel with noise of photons"] = with_photon_noise(kernel, path, fewer, ratio)
        asked[f"the reference with 1/{ratio:.3g} of the photons"] = fewer.x
    if given.control:
        asked[f"`transport: {transport(heads['control'])['model']}`"] = patches_of(given.control, task, given.asked, kernel).x
    told = network.scaling(learn, CHANNELS, task.logarithm)
    truth, before, after = kernel.y.numpy(), [], {name: [] for name in asked}
    for seed in range(given.trainings):
        model = network.train(learn, told, len(task.classes), seed, given.epochs)
        before.append(network.answers(model, kernel.x, told).argmax(1).numpy())
        for name, x in asked.items():
            after[name].append(network.answers(model, x, told).argmax(1).numpy())
    before, after = np.array(before), {name: np.array(found) for name, found in after.items()}
    right = before == truth
    items = "pockets" if task.kind == "classify_objects" else "patches"
    samples = len(set(kernel.sample))
    print(f"\n{given.task}: {len(learn.y)} {items} of {heads['train']['samples']} samples to learn from, "
          f"{given.trainings} trainings; {len(truth)} {items} of {samples} fresh samples, "
          f"{transport(heads['path'])['photons_per_profile']} photons a profile by the reference\n")
    print(f"Accuracy by the kernel: {right.mean():.4f} (trainings: {', '.join(f'{one:.4f}' for one in right.mean(axis=1))})\n")
    print("| rendered by | accuracy | lost [points] | 95 % | samples that lose, gain | sign test |\n|---|---|---|---|---|---|")
    for name, found in after.items():
        loss = accuracy_lost(right, found == truth, kernel.sample)
        if name == "the reference":
            gap = loss
        print(f"| {name} | {(found == truth).mean():.4f} | {points(loss)} | {loss.lost}, {loss.gained} | "
              f"{sign_test(loss.lost, loss.gained):.2g} |")
    reference = after["the reference"]
    if given.fewer:
        both = accuracy_lost(after["the kernel with noise of photons"] == truth, reference == truth, kernel.sample)
        print("\nLost from the kernel with noise of photons to the reference, by the model of light alone: "
              f"{points(both).replace(' |', ' points, 95 %:')}")
    print(f"\n| class | {items} | recall by the kernel | by the reference | lost [points] | 95 % |\n|---|---|---|---|---|---|")
    kinds = kinds_of(given.kernel, task, given.asked)
    groups = {name: truth == number for number, name in enumerate(task.classes)}
    groups |= {name.replace("_", " "): kinds == name for name in sorted(set(kinds))}
    for name, here in groups.items():
        shown = len(set(kernel.sample[here]))
        first, second = (found[:, here] == truth[here] for found in (before, reference))
        apart = f"{100 * (first.mean() - second.mean()):+.2f} | -"
        lost = points(accuracy_lost(first, second, kernel.sample[here])) if shown >= 5 else apart
        print(f"| {name} | {here.sum()} | {first.mean():.3f} | {second.mean():.3f} | {lost} |")
    print(f"\nAnswers by the kernel to answers by the reference, all trainings ({', '.join(task.classes)}):\n")
    for number, name in enumerate(task.classes):
        turned = [[((before == a) & (reference == b) & (truth == number)).sum() for b in range(len(task.classes))]
                  for a in range(len(task.classes))]
        print(f"- {name}: {'; '.join(' '.join(map(str, row)) for row in turned)}")
    print("\nLight by the reference over that by the kernel, less 1, mean and standard error over samples:\n")
    print("| class | Reflectance | Scatter |\n|---|---|---|")
    light = light_by_class(given.kernel, given.path, task)
    for name in task.classes:
        shown = [light.get((name, channel)) for channel in ("reflectance", "scatter")]
        print(f"| {name} | " + " | ".join(f"{one[0]:+.3f} +- {one[1]:.3f} of {one[2]}" if one else "-" for one in shown) + " |")
    if given.fewer and given.quiet:
        sensor, sensed = noise_between(given.kernel, given.quiet)
        photons, _ = noise_between(given.fewer, given.path)
        photons = {name: width / math.sqrt(1 + ratio) for name, width in photons.items()}
        print(f"\nNoise of a pixel ({sensed} samples for the sensor's):\n")
        print("| map | sensor and speckle | photons of the reference | ratio |\n|---|---|---|---|")
        for name, unit in zip(CHANNELS, ("mm", "DN", "DN")):
            print(f"| {name.capitalize()} [{unit}] | {sensor[name]:.3g} | {photons[name]:.3g} | "
                  f"{photons[name] / sensor[name]:.2f} |")
    bar = given.bar / 100
    verdict = "within it" if gap.high <= bar else "beyond it" if gap.low > bar else "not decided by so few samples"
    print(f"\nBar of {given.bar:g} points: {verdict} ({100 * gap.mean:+.2f}, 95 %: {100 * gap.low:+.2f} to {100 * gap.high:+.2f})")
    if gap.low > bar:
        sys.exit(f"{given.task}: more than {given.bar:g} points of accuracy are lost from the kernel to the reference; the "
                 "tables say in which class and map")


if __name__ == "__main__":
    main()
