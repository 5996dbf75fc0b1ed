"""What `tune_browser.rs` asks of the page of `gen tune` in Chromium; prints what it finds as one line of JSON.

    python tests/python/tune_browser.py GEN FOLDER WHAT
"""

import base64
import importlib.resources
import json
import os
import random
import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python"))
from tune_page import Chromium, Tune

DONE = "document.getElementById('state').textContent === 'the whole scan is there'"
CALM = f"!asking && waitingEdits.size === 0 && {DONE}"
MARGIN = 14
# How often keys are turned: two hundred and five hundred times where time does not matter.
EDITS = int(os.environ.get("TUNE_EDITS", "80"))
MOVES = int(os.environ.get("TUNE_MOVES", "250"))


def opened(chromium, tune, width=2200, height=1100, dark=False):
    tab = chromium.tab(tune.address, width, height, dark)
    tab.wait("typeof asking !== 'undefined' && state !== null && rows.size > 0")
    tab.wait(CALM)
    return tab


def settle(tab):
    """Waits for the whole scan of what the page shows now."""
    tab.wait("!asking && waitingEdits.size === 0 && !nextState")
    tab.wait("scan && !scan.stale && scan.turn === turn")


def show(tab, path):
    tab.run(f"(() => {{ const row = sections.find((s) => s.keys.some((k) => k.path === '{path}')); row.details.open = true; "
            f"buildSection(row); showKeys(); }})()")


def turn_slider(tab, path, share, kind="input[type=range]", event="input"):
    tab.run(f"(() => {{ const input = rows.get('{path}').element.querySelector('{kind}'); input.value = {share}; "
            f"input.dispatchEvent(new Event('{event}', {{ bubbles: true }})); }})()")


def preview(gen, folder, text, index=0):
    (folder / "now.yaml").write_text(text)
    subprocess.run([gen, "preview", "now.yaml", "--index", str(index), "--out", "now.png"], cwd=folder, check=True,
                   capture_output=True)
    return np.asarray(Image.open(folder / "now.png").convert("RGB"))


def canvas(tab, script):
    """Pixels of a canvas of the page."""
    width, height, pixels = tab.run(f"(() => {{ const c = {script}; const own = make('canvas', {{ width: c.width, height: c.height "
                                    "}); const x = own.getContext('2d', { willReadFrequently: true }); x.drawImage(c, 0, 0); "
                                    "const d = x.getImageData(0, 0, c.width, c.height).data; let s = ''; for (let i = 0; i < d.length; i += 1) s += "
                                    "String.fromCharCode(d[i]); return [c.width, c.height, btoa(s)]; })()")
    return np.frombuffer(base64.b64decode(pixels), np.uint8).reshape(height, width, 4)


def same_as_preview(tab, picture):
    """How many maps are on the page, pixel for pixel, as `gen preview` draws them."""
    tab.run("$('fit').click()")
    size = tab.run("[scan.width, scan.height, panels.length]")
    width, height, count = size
    same = 0
    for number in range(count):
        own = canvas(tab, f"panels[{number}].canvas")
        left, top = (own.shape[1] - width) // 2, (own.shape[0] - height) // 2
        # One to one pictures begin at whole pixels, rounded as JavaScript does.
        x, y = tab.run("[Math.round(-view.x * view.sx), Math.round(-view.y * view.sy)]")
        assert abs(x - left) <= 1 and abs(y - top) <= 1, (x, left, y, top)
        shown = own[y : y + height, x : x + width, :3]
        start = MARGIN + number * (width + MARGIN)
        column = picture[:, start : start + width]
        fits = [row for row in range(len(column) - height + 1) if np.array_equal(column[row : row + height], shown)]
        same += len(fits) == 1
    return same, count


def works(gen, folder):
    told = {}
    recipe = folder / "tiny.yaml"
    original = recipe.read_text()
    comments = [line.strip() for line in original.splitlines() if line.strip().startswith("#")]
    with Tune(gen, "tiny.yaml", folder) as tune, Chromium() as chromium:
        tab = opened(chromium, tune)
        told["sections"] = tab.run("[...document.querySelectorAll('#sections details')].map((d) => d.dataset.path)")
        told["at first"] = same_as_preview(tab, preview(gen, folder, original))

        show(tab, "laser.power_mw")
        turn_slider(tab, "laser.power_mw", 0.8)
        settle(tab)
        text = tab.run("$('text').value")
        told["moved"] = text != original and same_as_preview(tab, preview(gen, folder, text))

        number = "input[type=number]"
        fault = "rows.get('laser.power_mw').fault"
        turn_slider(tab, "laser.power_mw", 999999, number, "change")
        tab.wait(f"!{fault}.hidden")
        told["fault"] = tab.run(f"{fault}.textContent")
        told["fault in the list"] = tab.run("$('faults').children.length")
        turn_slider(tab, "laser.power_mw", 45, number, "change")
        tab.wait(f"{fault}.hidden && faults.length === 0")
        settle(tab)

        text = tab.run("$('text').value")
        told["comments kept"] = all(comment in text for comment in comments)
        told["lines changed"] = sum(a != b for a, b in zip(original.splitlines(), text.splitlines(), strict=True))
        tab.run("(() => { const t = $('text'); t.value = t.value.replace(/power_mw: [0-9.]+/, 'power_mw: 61'); "
                "t.dispatchEvent(new Event('input')); })()")
        tab.wait("rows.get('laser.power_mw').element.querySelector('input[type=number]').value === '61'")
        settle(tab)
        show(tab, "camera.filter_centre_nm")
        told["idle"] = tab.run("(() => { const row = rows.get('camera.filter_centre_nm'); return [row.reason.textContent, "
                               "row.numbers.querySelector('input').disabled]; })()")

        told["rig"] = tab.run("document.querySelectorAll('#rig-numbers tr').length")
        tab.wait("document.querySelectorAll('#strip img').length === 8 && "
                 "[...document.querySelectorAll('#strip img')].every((i) => i.naturalWidth > 0)")
        tab.run("$('strip').children[3].firstChild.click()")
        tab.wait("index === 3")
        settle(tab)
        tab.run("$('maps').focus()")
        for key in ("ArrowRight", "ArrowDown", "Enter"):
            tab.key(key)
        tab.wait("exposure !== null && exposure.profile === pick[0]")
        told["values"] = tab.run("$('values').textContent")
        tab.run("$('true-pixels').click()")
        tab.wait("region && region.turn === turn && view.sx === 1")
        told["region"] = tab.run("[region.columns, region.profiles]")

        other = opened(chromium, tune)
        before = tab.run("[text, turn, index]")
        show(other, "laser.power_mw")
        turn_slider(other, "laser.power_mw", 0.3)
        settle(other)
        told["two tabs"] = tab.run("[text, turn, index]") == before and other.run("text") != before[0]

        tab.run("$('save-name').value = 'kept.yaml'; $('save-as').click()")
        tab.wait("$('saved').textContent.includes('kept.yaml')")
        told["saved"] = (folder / "kept.yaml").read_text() == tab.run("text")
        told["faults"] = tab.faults() + other.faults()
        told["interrupt"], _ = tune.interrupt()
    told["file untouched"] = recipe.read_text() == original
    return told


def many(gen, folder):
    """Edits at random of whatever knobs there are."""
    chance = random.Random(54)
    with Tune(gen, "tiny.yaml", folder) as tune, Chromium() as chromium:
        tab = opened(chromium, tune)
        tab.run("sections.forEach((section) => { section.details.open = true; buildSection(section); }); showKeys()")
        knobs = tab.run("[...rows.keys()].filter((path) => rows.get(path).element.querySelector("
                        "'input[type=range]:enabled, select:enabled') && !path.startsWith('scan.') && "
                        "!path.startsWith('transport.') && !path.startsWith('log.') && !path.startsWith('motion.kind'))")
        turned, faulty = set(), 0
        for _ in range(EDITS):
            path = chance.choice(knobs)
            tab.run(f"(() => {{ const all = [...rows.get('{path}').element.querySelectorAll('input[type=range]:enabled, "
                    f"select:enabled, input[type=checkbox]:enabled')]; if (!all.length) return; "
                    f"const one = all[Math.floor({chance.random()} * all.length)]; "
                    f"if (one.type === 'range') {{ one.value = {chance.random()}; one.dispatchEvent(new Event('input')); }} "
                    f"else if (one.type === 'checkbox') one.click(); "
                    f"else {{ one.selectedIndex = Math.floor({chance.random()} * one.options.length); "
                    f"one.dispatchEvent(new Event('change')); }} }})()")
            tab.wait("!asking && waitingEdits.size === 0")
            turned.add(path)
            if tab.run("faults.length"):
                faulty += 1
                tab.run("$('undo').click()")
                tab.wait("!asking && !nextState")
        settle(tab)
        return {"edits": EDITS, "knobs": len(turned), "faulty": faulty, "faults": tab.faults(), "turn": tab.run("turn")}


def hindrances(tab):
    """What axe-core finds that keeps people from using the page, seriously or critically, with every section open."""
    script = importlib.resources.files("axe_playwright_python").joinpath("axe.min.js").read_text()
    tab.run("document.querySelectorAll('#sections details').forEach((d) => { d.open = true; })")
    tab.run(f"(() => {{ {script}\nwindow.hindrances = null; axe.run().then((r) => {{ window.checked = r.passes.length; window.hindrances = r.violations; }}); }})()")
    tab.wait("window.hindrances !== null")
    assert tab.run("window.checked") > 15, "axe-core has looked at next to nothing"
    return tab.run("window.hindrances.filter((v) => ['serious', 'critical'].includes(v.impact)).map((v) => "
                   "v.id + ': ' + v.nodes.slice(0, 3).map((n) => n.html).join(' '))")


def looks(gen, folder):
    """A phone, and a dark room."""
    told = {}
    with Tune(gen, "tiny.yaml", folder) as tune, Chromium() as chromium:
        for name, width, dark in (("phone", 390, False), ("dark", 1400, True), ("light", 1400, False)):
            tab = opened(chromium, tune, width, 844, dark)
            told[name] = {
                "wide": tab.run("document.documentElement.scrollWidth"),
                "paper": tab.run("getComputedStyle(document.body).backgroundColor"),
                "maps": tab.run("panels.filter(({ canvas }) => canvas.getBoundingClientRect().width > 150).length"),
                "unnamed": tab.run(
                    "[...document.querySelectorAll('button, input, select, textarea')].filter((e) => !(e.labels && "
                    "e.labels.length) && !e.getAttribute('aria-label') && !e.textContent.trim()).map((e) => e.outerHTML)"),
                "faults": tab.faults(),
                "hindrances": hindrances(tab),
            }
    return told


def memory(gen, folder):
    """Memory of the process over many moves, five times."""
    with Tune(gen, "tiny.yaml", folder) as tune:
        text = tune.ask("start")["text"]
        held = []
        for turn in range(MOVES):
            edit = {"key": "laser.power_mw", "value": str(20 + turn / 10)}
            text = tune.ask("state", text=text, seed=0, index=0, edit=edit)["text"]
            tune.ask("region", text=text, seed=0, index=0, page="a", turn=turn, look=turn, profile=24, column=32,
                     profiles=48, columns=64)
            if (turn + 1) % (MOVES // 5) == 0:
                held.append(tune.memory_mb())
    return {"mb": held}


def main():
    gen, folder, what = sys.argv[1], Path(sys.argv[2]), sys.argv[3]
    print(json.dumps({"works": works, "many": many, "looks": looks, "memory": memory}[what](gen, folder)))


if __name__ == "__main__":
    main()
