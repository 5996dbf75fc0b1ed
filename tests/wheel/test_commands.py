"""Every command of `gen` is a function with the same arguments; recipes from texts and dicts; what results and samples show."""

import importlib.util
import inspect
import io
import json
import pickle
import re
import webbrowser
from pathlib import Path

import numpy as np
import pytest
import sheetlight
from conftest import SMALL, gen
from PIL import Image

ROOT = Path(__file__).parents[2]
# What functions by hand have in place of an option: other words, what they always give, and what is a function by itself.
BY_HAND = {
    "generate": {"json", "events", "estimate"},
    "validate": {"json"},
    "report": set(),
}
TEXT = "name: mine\nextends: wood-small\nscan: {columns: 96, profiles: 40}\nspeckle: {strength: 0}\n"


def maker():
    spec = importlib.util.spec_from_file_location("make_commands", ROOT / "python" / "make_commands.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_python_can_what_the_command_line_can():
    made = maker()
    commands = json.loads(gen("schema", "commands"))
    assert len(commands) > 30
    for command in commands:
        name = made.function_name(command)
        has = set(inspect.signature(getattr(sheetlight, name)).parameters)
        wanted = set(made.parameters(command)) - BY_HAND.get(name, set())
        missing = wanted - has
        assert not missing, (name, missing)
        assert name in sheetlight.__all__
        if name not in BY_HAND:
            assert has == wanted, name
    written = (ROOT / "python" / "sheetlight" / "_commands.py").read_text()
    assert written == made.module(commands), "make bless makes the functions again"
    # Only these have no function: they are for a shell, a manual, a browser.
    told = set(re.findall(r"^  ([a-z]+) ", gen("--help").split("Commands:")[1].split("Arguments:")[0], re.M))
    assert told - {word for command in commands for word in command["command"][:1]} == {"completions", "man", "tune", "help"}


def test_options_reach_the_command(tmp_path, monkeypatch):
    """Each option as the command line writes it, whatever its kind."""
    monkeypatch.chdir(tmp_path)
    said = []
    monkeypatch.setattr("sheetlight._gen.run", lambda arguments, **_: said.append(list(arguments)) or "{}")
    sheetlight.fit("plate.yaml", real=["a.exr", "b.exr"], region=(1, 2, 3, 4), offset=-0.5, one_object=True, csv="grid", bits=8)
    assert said == [
        ["fit", "--recipe", "plate.yaml", "--real=a.exr", "--real=b.exr", "--one-object", "--region=1,2,3,4", "--offset=-0.5", "--bits=8", "--csv=grid", "--json"]
    ]
    sheetlight.check("boards", model=Path("knots.onnx"), slice="board.width_mm", overrides=None, recipe=None)
    assert said[1] == ["check", "boards", "--model=knots.onnx", "--slice=board.width_mm", "--json"]
    with pytest.raises(ValueError, match="model: .*on this machine"):
        sheetlight.check("boards", model="s3://bucket/knots.onnx")
    with pytest.raises(TypeError, match="region"):
        sheetlight.compare("a", "b", region={"left": 1})


def test_commands_answer_as_the_program_does(boards, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rig = sheetlight.rig("wood-small", overrides={"camera.tilt_deg": 30}, index=2)
    assert rig == json.loads(gen("rig", "wood-small", "--set", "camera.tilt_deg=30", "--index", 2, "--json"))
    assert rig.numbers == rig["numbers"] and rig.to_dict() == rig and "numbers" in dir(rig)
    with pytest.raises(AttributeError, match="numbers"):
        rig.number
    assert rig.to_arrow().num_rows == 1 and "field_of_view_mm" in rig._repr_html_()
    (listed,) = sheetlight.list_datasets([boards])
    assert listed.samples == 20 and "wood" in [known.name for known in sheetlight.recipe_list()]
    png = sheetlight.export_png(boards, out="png", index=["0-2"], maps=["range", "label"])
    assert png["samples"] == 3 and len(list(Path("png").rglob("*.png"))) == 6
    both = sheetlight.compare(boards, boards, scans=2)
    assert both["sim"] == both["real"]
    assert sheetlight.preview("wood-small", overrides=SMALL, out="one.png") == Path("one.png")
    assert Image.open("one.png").width > 96
    answer = sheetlight.transport(medium="clear-wood", model="kernel")
    assert answer == sheetlight.transport(medium="clear-wood", model="kernel", out="answer.json") == json.loads(Path("answer.json").read_text())
    assert sheetlight.recipe_new(subject="wood").startswith("#") and sheetlight.schema("recipe") == gen("schema", "recipe")
    assert sheetlight.estimate("wood-small", 4, overrides=SMALL)["samples"] == 4
    with pytest.raises(sheetlight.GenError, match="did you mean"):
        sheetlight.rig("wood-smal")


def test_recipes_come_from_texts_and_dicts(tmp_path):
    text = sheetlight.Recipe.from_yaml(TEXT, {"camera.tilt_deg": 30}, scan={"profiles": 24})
    dict_ = sheetlight.Recipe.load(
        {"name": "mine", "extends": "wood-small", "scan": {"columns": 96, "profiles": 24}, "speckle": {"strength": 0}, "camera": {"tilt_deg": 30}}
    )
    assert text.shape == (24, 96) and text.canonical == dict_.canonical and text == dict_
    assert pickle.loads(pickle.dumps(text)) == text
    assert np.array_equal(text.sample(1).scatter, dict_.sample(1).scatter, equal_nan=True)
    assert sheetlight.rig(text)["numbers"] == sheetlight.rig(dict_)["numbers"]
    made = sheetlight.generate(text, 2, tmp_path / "boards")
    assert made.samples == 2 and sheetlight.open(tmp_path / "boards").head["recipe"]["hash"] == text.hash
    with pytest.raises(sheetlight.RecipeError, match="did you mean `camera`"):
        sheetlight.Recipe.from_yaml("extends: wood-small\ncamra: {}\n")
    with pytest.raises(TypeError, match="text"):
        sheetlight.Recipe.from_yaml(Path("wood.yaml"))


def test_samples_show_what_they_hold(boards, monkeypatch, capsys):
    dataset = sheetlight.open(boards)
    sample = dataset[0]
    image = np.asarray(Image.open(io.BytesIO(sample.picture(["label", "range_mm"]))))
    rows, cols = sample.shape
    assert image.shape == (rows, 2 * cols + 4, 3)
    for value in np.unique(sample.label):
        colours = np.unique(image[:, :cols][sample.label == value], axis=0)
        assert len(colours) == 1, value
    height = image[:, cols + 4 :, 0]
    assert np.array_equal(height == 0, np.isnan(sample.range_mm))
    on = np.isfinite(sample.range_mm) & (sample.label > 0)
    assert np.corrcoef(height[on].astype(float), sample.range_mm[on])[0, 1] > 0.9 and len(np.unique(height[on])) > 10
    with pytest.raises(ValueError, match="maps: colour; the sample has"):
        sample.picture(["colour"])
    opened = []
    monkeypatch.setattr(webbrowser, "open", lambda url: opened.append(url) or True)
    sample.show()
    assert len(opened) == 1 and Image.open(opened[0].removeprefix("file://")).height == rows
    pages = [sample._repr_html_(), dataset._repr_html_(), sheetlight.Recipe.load("wood-small", SMALL)._repr_html_()]
    assert all(page.count("<div") == page.count("</div>") and page.count("<table") == page.count("</table>") for page in pages)
    assert "data:image/png;base64," in pages[1] and "field_of_view_mm" in pages[2]


def test_matplotlib_and_tqdm_where_they_are(boards, tmp_path, capsys):
    pytest.importorskip("matplotlib")
    sample = sheetlight.open(boards)[0]
    figure = sample.plot(["range_mm", "label"])
    assert [axes.get_title() for axes in figure.axes if axes.get_title()] == ["range_mm", "label"]
    names = [label.get_text() for axes in figure.axes for label in axes.get_yticklabels()]
    assert {sample.pixel_classes[value] for value in np.unique(sample.label)} <= set(names)
    figure.savefig(tmp_path / "plot.png")
    assert Image.open(tmp_path / "plot.png").width > 400
    pytest.importorskip("tqdm")
    sheetlight.generate("wood-small", 3, tmp_path / "boards", overrides=SMALL, progress=True)
    assert "3/3" in capsys.readouterr().err
