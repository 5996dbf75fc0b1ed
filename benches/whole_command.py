"""Whole commands of two builds of `gen`, in turn on this machine: time, processor time and memory, and the medians of their ratios.

    python3 benches/whole_command.py BEFORE AFTER [--pairs 10] [--threads 2] [--only wood,wood-train] [--recipes-before OLD/recipes]

BEFORE and AFTER are paths of programs, for instance of a worktree of an older commit and of this one. Each case writes everything that its
recipe writes by default into a scratch folder, which is removed. Ratios are after over before; below 1 is better.
"""

import argparse
import os
import shutil
import statistics
import tempfile
import time
from pathlib import Path

CASES = {"wood": 2, "blister": 2, "wood-train": 60, "wood-small": 60, "blister-train": 60}
"""Recipe, and how many samples of it."""


def run(program, recipe, samples, threads):
    """Seconds, seconds of processor time, and most memory [MB] of one command."""
    place = tempfile.mkdtemp(prefix="whole-command-")
    try:
        # Words that builds of all ages take, and no terminal, so that they are quiet.
        words = [program, "--recipe", recipe, "--n", str(samples), "--threads", str(threads), "--out", f"{place}/set"]
        silent = [(os.POSIX_SPAWN_OPEN, stream, os.devnull, os.O_WRONLY, 0) for stream in (1, 2)]
        begun = time.perf_counter()
        child = os.posix_spawn(program, words, os.environ, file_actions=silent)
        _, status, used = os.wait4(child, 0)
        seconds = time.perf_counter() - begun
    finally:
        shutil.rmtree(place)
    if status:
        raise SystemExit(f"{' '.join(words)} ended with status {os.waitstatus_to_exitcode(status)}")
    return seconds, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def main():
    known = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    known.add_argument("before", type=Path)
    known.add_argument("after", type=Path)
    known.add_argument("--pairs", type=int, default=10)
    known.add_argument("--threads", type=int, default=2)
    known.add_argument("--only", default=",".join(CASES), help="recipes, with commas between")
    known.add_argument("--recipes-before", type=Path, help="folder of the recipes of BEFORE; without it those that AFTER has")
    given = known.parse_args()
    programs = [str(path.resolve()) for path in (given.before, given.after)]
    for recipe in given.only.split(","):
        own = str(given.recipes_before / f"{recipe}.yaml") if given.recipes_before else recipe
        asked = list(zip(programs, (own, recipe)))
        pairs = [[run(program, words, CASES[recipe], given.threads) for program, words in asked] for _ in range(given.pairs)]
        words = []
        for what, name in enumerate(["s", "s of processor time", "MB"]):
            before, after = (statistics.median(pair[build][what] for pair in pairs) for build in (0, 1))
            ratio = statistics.median(pair[1][what] / pair[0][what] for pair in pairs)
            words.append(f"{before:.2f} -> {after:.2f} {name} ({ratio:.3f})")
        print(f"{recipe}, {CASES[recipe]} samples: {'; '.join(words)}", flush=True)


if __name__ == "__main__":
    main()
