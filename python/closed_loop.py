"""Closed loop of `gen fit`: scans whose keys are known, fitted as if they were real; how often intervals hold the truth.

    python python/closed_loop.py out/closed-loop --first 44 --loops 20

Each loop takes one sample of the recipe (its keys drawn from the prior by a seed of its own), fits the recipe to it with another seed, and
asks for every key whether the 90 % interval holds the value that was drawn. With the right intervals the number of hits in n
loops is binomial with p = 0.9: of 20, 16 to 20 in 95.7 % of all cases. Finished loops are kept in the folder and not made again.
Hidden values follow from a loop's number: `--first` begins at another one, so that values can be ones that nothing was chosen on.
"""

import argparse
import json
import pathlib
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


def loop(arguments: argparse.Namespace, number: int) -> dict:
    """One hidden recipe and its fit."""
    folder: pathlib.Path = arguments.folder / f"{number:03}"
    result = folder / "result.json"
    if not result.is_file():
        folder.mkdir(parents=True, exist_ok=True)
        make = [arguments.gen, "--recipe", arguments.recipe, "--n", "1", "--seed", str(1000 + number), "-q"]
        subprocess.run([*make, "--out", folder / "real"], check=True)
        fit = [arguments.gen, "fit", "--recipe", arguments.recipe, "--real", folder / "real", "--json", "-q"]
        fit += ["--seed", str(number), "--simulations", str(arguments.simulations), "--time", "2h"]
        found = json.loads(subprocess.run([*fit, "--out", folder / "fitted.yaml"], check=True, stdout=subprocess.PIPE).stdout)
        found["truth"] = truth(folder / "real")
        result.write_text(json.dumps(found))
    return json.loads(result.read_text())


def main() -> None:
    """Runs the loops and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--recipe", default="recipes/fit/plate.yaml")
    parser.add_argument("--gen", default="target/release/gen")
    parser.add_argument("--loops", type=int, default=20)
    parser.add_argument("--first", type=int, default=0, help="number of the first loop, which its hidden values follow from")
    parser.add_argument("--simulations", type=int, default=3000)
    arguments = parser.parse_args()
    found = []
    for done in range(arguments.loops):
        found.append(loop(arguments, arguments.first + done))
        print(f"loop {done + 1} of {arguments.loops}", file=sys.stderr)
    states = ["determined", "weak", "undetermined"]
    print(f"{'key':32}" + "".join(f"{state:>16}" for state in states) + f"{'median width':>16}")
    total = {state: [0, 0] for state in states}
    for key in found[0]["keys"]:
        line = f"{key:32}"
        for state in states:
            fits = [(run["keys"][key], run["truth"][key]) for run in found if run["keys"][key]["state"] == state]
            hits = sum(fit["posterior"]["p05"] <= true <= fit["posterior"]["p95"] for fit, true in fits)
            total[state] = [total[state][0] + hits, total[state][1] + len(fits)]
            line += f"{f'{hits} of {len(fits)}':>16}"
        widths = sorted(run["keys"][key]["width"] for run in found)
        print(line + f"{widths[len(widths) // 2]:>16.2f}")
    print(f"{'all':32}" + "".join(f"{f'{hits} of {n}':>16}" for hits, n in total.values()))
    missed = sum(s["out_of_reach"] for run in found for s in run["scans"][0]["statistics"].values())
    told = sum(s["real"] is not None for run in found for s in run["scans"][0]["statistics"].values())
    print(f"statistics out of reach: {missed} of {told}")


if __name__ == "__main__":
    main()
