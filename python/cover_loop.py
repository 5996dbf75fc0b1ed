"""Closed loop of `gen cover`: scans with one key outside of a recipe's spread, and scans with none; which key is named.

    python python/cover_loop.py out/cover-loop --loops 20

The recipe draws each of ten keys from the middle half of what recipes/fit/plate.yaml says. In each loop one of them, in turn, lies
beyond an end of that by one to two of its widths, on a side and by as much as the loop's number says; all else is drawn by the recipe.
A key that is not among the first three named, but whose place one of them takes, is asked of `gen fit`: both are fitted together, and
count as one where it names them as a pair. As many loops have no key outside. Finished loops are kept and not made again.
"""

import argparse
import json
import math
import pathlib
import random
import subprocess
import sys

# What keys may be, where their places below may lie beyond that.
MAY_BE = {
    "exposure.dark_noise_dn": (0.5, 30),
    "exposure.row_noise_dn": (0.01, 0.8),
    "material.gloss": (0.01, 0.99),
    "material.roughness_x": (0.05, 0.99),
}
KEYS = {  # What plate.yaml draws: from, to, in equal ratios.
    "laser.waist_mm": (0.05, 0.2, True),
    "laser.linewidth_nm": (0.1, 2, True),
    "camera.blur_um": (0.5, 6, False),
    "exposure.time_us": (40, 250, True),
    "exposure.dark_level_dn": (4, 16, False),
    "exposure.dark_noise_dn": (0.7, 3, True),
    "exposure.row_noise_dn": (0.05, 0.4, True),
    "material.mu_a_per_mm": (0.01, 0.2, True),
    "material.gloss": (0.05, 0.6, False),
    "material.roughness_x": (0.1, 0.6, True),
}


def place(key: str, share: float) -> float:
    """The value at a share of what plate.yaml draws: 0 and 1 are its ends."""
    low, high, is_log = KEYS[key]
    return math.exp(math.log(low) + share * math.log(high / low)) if is_log else low + share * (high - low)


def hidden(number: int) -> tuple[str, float]:
    """Key and value of a loop; of what would lie below what a key may be, the other side."""
    rng = random.Random(number)
    key = list(KEYS)[number % len(KEYS)]
    beyond = 0.5 * rng.uniform(1, 2)
    value = place(key, rng.choice((0.25 - beyond, 0.75 + beyond)))
    if value <= MAY_BE.get(key, (0, 0))[0]:
        value = place(key, 0.75 + beyond)
    return key, allowed(key, value)


def allowed(key: str, value: float) -> float:
    """The value that a key may have next to one."""
    low, high = MAY_BE.get(key, (-math.inf, math.inf))
    return min(max(value, low), high)


def spread(key: str) -> list[str]:
    """What the recipe of a loop draws a key from."""
    law = "log_uniform" if KEYS[key][2] else "uniform"
    return ["--set", f"{key}={{{law}: [{place(key, 0.25):.6g}, {place(key, 0.75):.6g}]}}"]


def gen(arguments: argparse.Namespace, *words: str) -> str:
    return subprocess.run([arguments.gen, *words, "-q"], check=True, stdout=subprocess.PIPE, text=True).stdout


def loop(arguments: argparse.Namespace, number: int, is_hidden: bool) -> dict:
    """One real scan, and what is said of it."""
    folder: pathlib.Path = arguments.folder / f"{'hidden' if is_hidden else 'clean'}-{number:03}"
    result = folder / "result.json"
    if not result.is_file():
        folder.mkdir(parents=True, exist_ok=True)
        key, value = hidden(number)
        recipe = ["--recipe", arguments.recipe, *(word for known in KEYS for word in spread(known))]
        real = ["--set", f"{key}={value:.6g}"] if is_hidden else []
        if not (folder / "real" / "dataset.json").is_file():
            gen(arguments, *recipe, *real, "--n", "1", "--seed", str(1000 + number), "--out", str(folder / "real"))
        cover = ["cover", *recipe, "--real", str(folder / "real"), "--seed", str(number), "--json"]
        found = json.loads(gen(arguments, *cover, "--out", str(folder / "cover.html")))
        found["truth"] = {"key": key, "value": value} if is_hidden else None
        named = [known["key"] for known in found["widen"]][:3]
        found["pairs"] = []
        if is_hidden and key not in named:
            found["pairs"] = [other for other in named if other in KEYS and is_pair(arguments, folder, key, other, number)]
        result.write_text(json.dumps(found))
    return json.loads(result.read_text())


def is_pair(arguments: argparse.Namespace, folder: pathlib.Path, key: str, other: str, number: int) -> bool:
    """Whether `gen fit` cannot tell two keys apart where both may lie where the hidden one does."""
    wide = []
    for known in (key, other):
        law = "log_uniform" if KEYS[known][2] else "uniform"
        low = place(known, -0.75) if KEYS[known][2] else max(place(known, -0.75), 0.01)
        low, high = allowed(known, low), allowed(known, place(known, 1.75))
        wide += ["--set", f"{known}={{{law}: [{low:.6g}, {high:.6g}]}}"]
    narrow = [word for known in KEYS if known not in (key, other) for word in spread(known)]
    fit = ["fit", "--recipe", arguments.recipe, *narrow, *wide, "--real", str(folder / "real"), "--seed", str(number)]
    found = json.loads(gen(arguments, *fit, "--json", "--time", "1h", "--out", str(folder / "fitted.yaml")))
    return any(set(pair["keys"]) == {key, other} for pair in found["pairs"])


def main() -> None:
    """Runs the loops and prints what was named."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--recipe", default="recipes/fit/plate.yaml")
    parser.add_argument("--gen", default="target/release/gen")
    parser.add_argument("--loops", type=int, default=20)
    parser.add_argument("--first", type=int, default=0, help="number of the first loop, which its hidden value follows from")
    arguments = parser.parse_args()
    hits = alarms = 0
    for number in range(arguments.first, arguments.first + arguments.loops):
        found = loop(arguments, number, True)
        (scan,), truth = found["scans"], found["truth"]
        named = [key["key"] for key in found["widen"]]
        is_hit = scan["outside"] and (truth["key"] in named[:3] or bool(found["pairs"]))
        hits += is_hit
        state = "outside" if scan["outside"] else "inside"
        words = [f"{key['words']} ({key['left']:.2f})" for key in found["widen"][:3]]
        print(f"{'' if is_hit else 'MISSED '}{truth['key']} {truth['value']:.4g}: {state}, {'; '.join(words)}")
        sys.stdout.flush()
    for number in range(arguments.first, arguments.first + arguments.loops):
        (scan,) = loop(arguments, number, False)["scans"]
        alarms += scan["outside"]
    print(f"the hidden key is among the first three in {hits} of {arguments.loops}; without one {alarms} alarms of {arguments.loops}")


if __name__ == "__main__":
    main()
