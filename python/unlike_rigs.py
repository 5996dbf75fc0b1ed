"""What a network learns from a first recipe: how it does where every number that the recipe leaves out lies at an end of
its natural variation.

    make unlike-rigs
    python python/unlike_rigs.py out/unlike --task knots

The same small network (train_baseline.py) learns from 300 samples each of a first recipe, which states what a user knows
and leaves out the rest; of the same with `unstated: fixed`; and of the shipped recipe for training. All are asked about
one set of 1,000 samples: those of the first recipe, but each number that it leaves out takes one of two ends by lot, 5 or
95 % of what it varies by nature. The score is the mean of the classes' recalls; intervals are of 95 %, by samples drawn
anew. Datasets that are there are not made again. docs/guide/how-much-to-vary.md has the figures.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

import baseline_network as network
from baseline_patches import TASKS, cut_patches, np, open_dataset, pq, torch

FIRST = {
    "packs": """\
name: first-packs
subject: blister
scan: {columns: 440, profiles: 470}
motion: {step_mm: 0.094}
pack: {width_mm: 38, length_mm: 40, columns: 2, rows: 2, pitch_x_mm: 17, pitch_y_mm: 16}
tablet: {length_mm: 9, width_mm: 9, thickness_mm: 4.2, band_mm: 2.3}
film: {preset: pvc-amber}
classes:
  sound: {share: 1}
  missing: {share: 1, defects: {missing: {uniform: [1, 3]}}}
  broken: {share: 1, defects: {broken: {uniform: [1, 3]}}}
output: {png: [range, reflectance, scatter, label], exr: [], truth_maps: false}
""",
    "knots": """\
name: first-boards
subject: wood
scan: {columns: 320, profiles: 300}
motion: {step_mm: 0.094}
board: {width_mm: 26, length_mm: 24, thickness_mm: 22, lead_in_mm: 1.5}
knots: {width_mm: {uniform: [5, 12]}}
classes:
  clear: {share: 1}
  sound_knot: {share: 1, knots: {sound_count: {uniform: [1, 2]}}}
  dead_knot: {share: 1, knots: {dead_count: {uniform: [1, 2]}}}
output: {png: [range, reflectance, scatter, label], exr: [], truth_maps: false}
""",
}
SHIPPED = {"packs": "blister-train", "knots": "wood-train"}
# What is learned, and how often each patch is seen.
LEARNED = {
    "packs": (TASKS["blister"], 60),
    "knots": (TASKS["wood"]._replace(classes={"clear": ["clear"], "knot": ["sound_knot", "dead_knot"]}), 12),
}
# Seeds of the datasets to learn from and of the set that is asked.
SEED, ENDS_SEED = 1, 2
# Shares of what a number varies below its two ends [%].
ENDS = (5, 95)


def gen(given, *words):
    """What `gen` prints; it says itself what is wrong."""
    run = subprocess.run([given.gen, *map(str, words)], stdout=subprocess.PIPE, text=True)
    if run.returncode:
        sys.exit(f"{given.gen} {' '.join(map(str, words))[:300]} failed")
    return run.stdout


def made(given, name, recipe, samples, seed, changes=()):
    """The dataset of a recipe, made or continued."""
    folder = given.folder / f"{given.task}-{name}"
    sets = [word for change in changes for word in ("--set", change)]
    print(f"{folder}: {samples} samples of {recipe}", file=sys.stderr, flush=True)
    gen(given, "--recipe", recipe, "--n", samples, "--seed", seed, "--out", folder, *sets)
    return folder


def numbers(canonical, path=""):
    """Paths of a recipe in canonical form, with what stands there."""
    for key, value in canonical.items():
        here = f"{path}{key}"
        is_section = isinstance(value, dict) and not path and key not in ("classes", "splits", "output")
        yield from numbers(value, f"{here}.") if is_section else [(here, value)]


def left_out(given, recipe):
    """Paths of numbers that vary where the recipe leaves them out, and do not with `unstated: fixed`."""
    drawn, fixed = [dict(numbers(json.loads(gen(given, "recipe", "show", recipe, "--json", "--set", f"unstated={how}"))))
                    for how in ("drawn", "fixed")]
    return sorted(path for path in drawn if path in fixed and "." in path and drawn[path] != fixed[path])


def at_ends(given, recipe, folder):
    """Changes of the recipe that draw each number that it leaves out from two ends of what the dataset in `folder` has."""
    tables = [pq.read_table(table) for table in sorted((folder / "data").rglob("*.parquet"))]
    changes = []
    for path in left_out(given, recipe):
        group, key = path.split(".")
        if group not in tables[0].column_names or key not in [field.name for field in tables[0].schema.field(group).type]:
            continue
        values = np.concatenate([table[group].combine_chunks().field(key).to_numpy(zero_copy_only=False) for table in tables])
        whole = np.all(values == np.round(values))
        low, high = np.percentile(values, ENDS, method="nearest" if whole else "linear")
        if low < high:
            changes.append(f"{path}={{choice: {{values: [{low:.8g}, {high:.8g}]}}}}")
    return changes


class Recalls:
    """Right answers and questions by sample and class."""

    def __init__(self, patches, answers, classes):
        right = answers.argmax(1).numpy() == patches.y.numpy()
        samples, place = np.unique(patches.sample, return_inverse=True)
        self.asked, self.right = np.zeros((2, len(samples), classes))
        np.add.at(self.asked, (place, patches.y.numpy()), 1)
        np.add.at(self.right, (place, patches.y.numpy()), right)

    def score(self, chosen=slice(None)):
        """The mean of the classes' recalls over some samples [1]."""
        return float(np.mean(self.right[chosen].sum(0) / np.maximum(self.asked[chosen].sum(0), 1)))

    def redrawn(self, count=2000, seed=0):
        """Scores with samples drawn anew."""
        rng = np.random.default_rng(seed)
        return np.array([self.score(rng.integers(0, len(self.asked), len(self.asked))) for _ in range(count)])

    def by_class(self):
        """The recall of each class [1]."""
        return (self.right.sum(0) / np.maximum(self.asked.sum(0), 1)).round(4).tolist()


def learned(given, folder, task, epochs):
    """Networks of some seeds trained on the train split, with their scaling."""
    patches = cut_patches(folder, task, given.channels, "train", given.patches, 0)
    told = network.scaling(patches, given.channels, task.logarithm)
    return [(network.train(patches, told, len(task.classes), seed, epochs), told) for seed in range(given.seeds)]


def asked(models, patches, task):
    """What each network answers rightly."""
    return [Recalls(patches, network.answers(model, patches.x, told), len(task.classes)) for model, told in models]


def told_of(recalls):
    """Mean score of some networks, and the same with samples drawn anew."""
    redrawn = np.mean([one.redrawn() for one in recalls], axis=0)
    return float(np.mean([one.score() for one in recalls])), redrawn


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, metavar="DIR", help="where datasets and results go")
    parser.add_argument("--task", choices=FIRST, required=True, help="what to learn")
    parser.add_argument("--channels", default="reflectance,scatter", help="maps to look at (default: %(default)s)")
    parser.add_argument("--gen", default="target/release/gen", help="the program (default: %(default)s)")
    parser.add_argument("--samples", type=int, default=300, help="samples to learn from (default: %(default)s)")
    parser.add_argument("--own", type=int, default=200, help="samples of the own test split (default: %(default)s)")
    parser.add_argument("--ends", type=int, default=1000, help="samples at the ends (default: %(default)s)")
    parser.add_argument("--patches", type=int, default=48000, help="drawn pixels of each class (default: %(default)s)")
    parser.add_argument("--seeds", type=int, default=2, help="networks of each recipe (default: %(default)s)")
    given = parser.parse_args()
    given.channels = given.channels.split(",")
    return given


def main():
    given = arguments()
    given.folder.mkdir(parents=True, exist_ok=True)
    torch.set_num_threads(1)
    (task, epochs), recipe = LEARNED[given.task], given.folder / f"first-{given.task}.yaml"
    recipe.write_text(FIRST[given.task])
    both = given.samples + given.own
    parts = [f"splits={{train: {given.samples / both:.6f}, validation: 0, test: {given.own / both:.6f}}}"]
    drawn = made(given, "drawn", recipe, both, SEED, parts)
    fixed = made(given, "fixed", recipe, both, SEED, [*parts, "unstated=fixed"])
    shipped = made(given, "shipped", SHIPPED[given.task], given.samples, SEED, ["splits={train: 1, validation: 0, test: 0}"])
    changes = at_ends(given, recipe, drawn)
    ends = made(given, "ends", recipe, given.ends, ENDS_SEED, changes)
    print(f"{len(changes)} numbers take their ends by lot in {given.ends} samples of {open_dataset(ends)['recipe']['name']}")
    unlike = cut_patches(ends, task, given.channels, None, given.patches, 0)
    scores = {}
    for name, folder in (("drawn", drawn), ("fixed", fixed), ("shipped", shipped)):
        models = learned(given, folder, task, epochs)
        if name != "shipped":
            own = cut_patches(folder, task, given.channels, "test", given.patches, 0)
            scores[name, "own"] = told_of(asked(models, own, task))
        recalls = asked(models, unlike, task)
        scores[name, "ends"] = told_of(recalls)
        print(f"{name} at the ends, {', '.join(task.classes)}: {[one.by_class() for one in recalls]}", flush=True)
    print("\n| learned from | asked about | score | 95 % |\n|---|---|---|---|")
    for (name, of), (score, redrawn) in scores.items():
        low, high = np.percentile(redrawn, (2.5, 97.5))
        print(f"| {name} | {of} | {100 * score:.1f} | {100 * low:.1f} to {100 * high:.1f} |")
    for better, worse in ((("drawn", "own"), ("drawn", "ends")), (("shipped", "ends"), ("drawn", "ends")),
                          (("fixed", "own"), ("fixed", "ends"))):
        # Sets of other samples are redrawn by themselves; one set asked of two networks is redrawn for both alike.
        lost = scores[better][1] - scores[worse][1]
        low, high = np.percentile(lost, (2.5, 97.5))
        print(f"{' '.join(better)} less {' '.join(worse)}: {100 * (scores[better][0] - scores[worse][0]):.1f} "
              f"({100 * low:.1f} to {100 * high:.1f}) points")


if __name__ == "__main__":
    main()
