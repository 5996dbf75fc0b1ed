"""How long `gen tune` takes to answer: moves of a knob over a region of 256 x 256 pixels.

    python3 python/bench_tune.py target/release/gen wood wood-small blister-small --threads 2 --moves 50

A move is an edit of the recipe's text and the region of its sample, one after the other, as the page asks for them. Keys
are moved in turn between two numbers. The last column is what the program's threads work for a move, which other work
on the machine hardly changes: shared among quiet cores it is about the time. With --browser a slider of the page is
moved in Chromium, and a move ends when its pixels are drawn. Take it on a quiet machine.
"""

import argparse
import statistics
import tempfile
import time

from tune_page import Chromium, Tune

MOVES = (("laser.power_mw", 40.0, 60.0), ("exposure.time_us", 30.0, 45.0))


def percentile(times, share):
    return sorted(times)[min(len(times) - 1, round(share * (len(times) - 1)))]


def by_questions(tune, moves):
    text = tune.ask("start")["text"]
    size = tune.ask("state", text=text, seed=0, index=0)
    middle = {"profile": size["profiles"] // 2, "column": size["columns"] // 2, "profiles": 256, "columns": 256}
    # The object grows once.
    tune.ask("region", text=text, seed=0, index=0, page="bench", turn=0, look=0, **middle)
    times, work = [], tune.processor_s()
    for turn in range(1, moves + 1):
        key, low, high = MOVES[turn % len(MOVES)]
        begun = time.perf_counter()
        edit = {"key": key, "value": f"{low + (high - low) * turn / moves:.4g}"}
        text = tune.ask("state", text=text, seed=0, index=0, edit=edit)["text"]
        tune.ask("region", text=text, seed=0, index=0, page="bench", turn=turn, look=turn, **middle)
        times.append(1e3 * (time.perf_counter() - begun))
    return times, 1e3 * (tune.processor_s() - work) / moves


def by_slider(tune, moves):
    with Chromium() as chromium:
        tab = chromium.tab(tune.address, 1600, 1000)
        tab.wait("typeof state !== 'undefined' && state !== null && region !== null && rows.size > 0")
        tab.wait("document.getElementById('state').textContent === 'the whole scan is there'")
        tab.run("edit('laser.power_mw', '50')")
        tab.wait("!asking && region && region.turn === turn")
        times, work = [], tune.processor_s()
        for move in range(moves):
            tab.run("window.begun = performance.now(); window.before = turn; (() => { const slider = rows.get('laser.power_mw')"
                    f".element.querySelector('input[type=range]'); slider.value = {0.55 + 0.3 * move / moves}; "
                    "slider.dispatchEvent(new Event('input', { bubbles: true })); })()")
            times.append(tab.run("new Promise((done) => { const look = () => turn > before && region.turn === turn ? "
                                 "requestAnimationFrame(() => done(performance.now() - begun)) : setTimeout(look, 1); look(); })"))
        return times, 1e3 * (tune.processor_s() - work) / moves


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("gen")
    parser.add_argument("recipes", nargs="+")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--moves", type=int, default=50)
    parser.add_argument("--browser", action="store_true")
    arguments = parser.parse_args()
    print(f"{'recipe':24} {'median':>9} {'95 %':>9} {'most':>9} {'processor':>10}  ms a move")
    for recipe in arguments.recipes:
        with tempfile.TemporaryDirectory() as folder:
            with Tune(arguments.gen, recipe, folder, ["--threads", str(arguments.threads)]) as tune:
                times, work = (by_slider if arguments.browser else by_questions)(tune, arguments.moves)
        numbers = statistics.median(times), percentile(times, 0.95), max(times), work
        print(f"{recipe:24}" + "".join(f"{number:10.0f}" for number in numbers), flush=True)


if __name__ == "__main__":
    main()
