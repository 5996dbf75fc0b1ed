"""Closed loop of `gen fit`: scans whose keys are known, fitted as if they were real; how often intervals hold the truth.

    python python/closed_loop.py out/closed-loop --first 44 --loops 20
    python python/closed_loop.py out/measure-loop --recipe recipes/fit/wood.yaml --classes plate,along,across,steep

Each loop takes one sample of the recipe (its keys drawn from the prior by a seed of its own), fits the recipe to it with another seed, and
asks for every key whether the 90 % interval holds the value that was drawn. With the right intervals the number of hits in n
loops is binomial with p = 0.9: of 20, 16 to 20 in 95.7 % of all cases. Finished loops are kept in the folder and not made again.
Hidden values follow from a loop's number: `--first` begins at another one, so that values can be ones that nothing was chosen on.

With `--classes` a loop has a scan of each of them, of a place of its own, and all have the hidden values in common. A key counts as
told where its interval is at most a third as long as that of the prior.
"""

import argparse
import json
import pathlib
import statistics
import subprocess
import sys

import pyarrow.parquet as pq


def truth(dataset: pathlib.Path) -> dict[str, float]:
    """The numbers that were drawn for the one sample of a dataset, by key."""
    (table,) = dataset.glob("data/**/*.parquet")
    row = pq.read_table(table).to_pylist()[0]
    found: dict[str, float] = {}

    def walk(value: object, path: str) -> None:
        if isinstance(value, dict):
            for name, below in value.items():
                walk(below, f"{path}.{name}" if path else name)
        elif isinstance(value, (int, float)):
            found[path.removeprefix("draws.")] = float(value)

    walk(row, "")
    return found


# Sections of which keys are fitted by default (crates/fit/src/prior.rs).
FITTED = ("motion", "laser", "camera", "exposure", "speckle", "media", "moisture", "material", "film", "foil", "tablet")
# Length of an interval over the prior's up to which a key is told.
TOLD = 1 / 3


def drawn_keys(arguments: argparse.Namespace) -> list[str]:
    """The keys of bench and matter that the recipe draws from a distribution."""
    show = [arguments.gen, "recipe", "show", arguments.recipe, "--json"]
    recipe = json.loads(subprocess.run(show, check=True, stdout=subprocess.PIPE).stdout)
    sections = [(section, recipe.get(section) or {}) for section in FITTED]
    return [f"{section}.{key}" for section, keys in sections for key, value in keys.items() if isinstance(value, dict)]


def scans(arguments: argparse.Namespace, number: int, folder: pathlib.Path) -> tuple[list[pathlib.Path], dict[str, float]]:
    """The scans of a loop, and what they have in common."""
    make = [arguments.gen, "--recipe", arguments.recipe, "--n", "1", "-q"]
    if not arguments.classes:
        subprocess.run([*make, "--seed", str(1000 + number), "--out", folder / "real"], check=True)
        return [folder / "real"], truth(folder / "real")
    made, hidden = [], {}
    # The last one draws what is hidden; a plate comes first, which has its own matter.
    for place, name in reversed(list(enumerate(arguments.classes))):
        made.insert(0, folder / f"{place}-{name}")
        keys = [f"--set={key}={hidden[key]!r}" for key in drawn_keys(arguments) if hidden]
        seed = str(1000 + number + 1_000_000 * place)
        subprocess.run([*make, *keys, "--set", f"classes.{name}.share=1e5", "--seed", seed, "--out", made[0]], check=True)
        hidden = hidden or truth(made[0])
    return made, hidden


def loop(arguments: argparse.Namespace, number: int) -> dict:
    """One hidden recipe and its fit."""
    folder: pathlib.Path = arguments.folder / f"{number:03}"
    result = folder / "result.json"
    if not result.is_file():
        folder.mkdir(parents=True, exist_ok=True)
        real, hidden = scans(arguments, number, folder)
        fit = [arguments.gen, "fit", "--recipe", arguments.recipe, "--real", *real, "--json", "-q"]
        fit += ["--seed", str(number), "--simulations", str(arguments.simulations), "--time", "2h"]
        if arguments.classes:
            fit += ["--classes", ",".join(arguments.classes), "--matter", folder / "matter.yaml"]
        found = json.loads(subprocess.run([*fit, "--out", folder / "fitted.yaml"], check=True, stdout=subprocess.PIPE).stdout)
        found["truth"] = hidden
        result.write_text(json.dumps(found))
    return json.loads(result.read_text())


def main() -> None:
    """Runs the loops and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--recipe", default="recipes/fit/plate.yaml")
    parser.add_argument("--classes", type=lambda names: names.split(","), default=[], help="the class of each scan of a loop")
    parser.add_argument("--gen", default="target/release/gen")
    parser.add_argument("--loops", type=int, default=20)
    parser.add_argument("--first", type=int, default=0, help="number of the first loop, which its hidden values follow from")
    parser.add_argument("--simulations", type=int, default=3000)
    arguments = parser.parse_args()
    found = []
    for done in range(arguments.loops):
        found.append(loop(arguments, arguments.first + done))
        print(f"loop {done + 1} of {arguments.loops}", file=sys.stderr)
    kinds = {
        **{state: lambda fit, state=state: fit["state"] == state for state in ("determined", "weak", "undetermined")},
        "told": lambda fit: fit["length"] <= TOLD,
    }
    print(f"{'key':32}" + "".join(f"{kind:>16}" for kind in kinds) + f"{'median width':>16}{'length':>10}")
    total = {kind: [0, 0] for kind in kinds}
    for key in found[0]["keys"]:
        line = f"{key:32}"
        for kind, is_of in kinds.items():
            fits = [(run["keys"][key], run["truth"][key]) for run in found if is_of(run["keys"][key])]
            hits = sum(fit["posterior"]["p05"] <= true <= fit["posterior"]["p95"] for fit, true in fits)
            total[kind] = [total[kind][0] + hits, total[kind][1] + len(fits)]
            line += f"{f'{hits} of {len(fits)}':>16}"
        width, length = (statistics.median(run["keys"][key][number] for run in found) for number in ("width", "length"))
        print(line + f"{width:>16.2f}{length:>10.2f}")
    print(f"{'all':32}" + "".join(f"{f'{hits} of {n}':>16}" for hits, n in total.values()))
    asked = [s for run in found for scan in run["scans"] for s in scan["statistics"].values() if s["real"] is not None]
    print(f"statistics out of reach: {sum(s['out_of_reach'] for s in asked)} of {len(asked)}")


if __name__ == "__main__":
    main()
