"""The picture of the page of `gen tune` in README: `python3 python/tune_picture.py target/release/gen docs/pictures/tune.png`.

A sample of `wood-small`. Needs pillow (`make venv`) and Chromium.
"""

import io
import sys
import tempfile

from PIL import Image

from tune_page import Chromium, Tune

SIZE = (1700, 960)
COLOURS = 256


def main():
    gen, out = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        with Tune(gen, "wood-small", folder, ["--index", "0"]) as tune, Chromium() as chromium:
            tab = chromium.tab(tune.address, *SIZE)
            tab.wait("document.getElementById('state').textContent === 'the whole scan is there'")
            tab.wait("document.querySelectorAll('#strip img').length === 8 && "
                     "[...document.querySelectorAll('#strip img')].every((image) => image.naturalWidth > 0)")
            picture = Image.open(io.BytesIO(tab.screenshot())).convert("RGB")
    picture.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.FLOYDSTEINBERG).save(out, optimize=True)
    print(f"{out}: {picture.width} x {picture.height}")


if __name__ == "__main__":
    main()
