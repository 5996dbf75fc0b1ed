"""Recipes: names, overrides, faults."""

import pickle

import numpy as np
import pytest
import sheetlight
from conftest import SMALL, gen


def test_overrides_are_those_of_the_command_line(tmp_path):
    text = gen("recipe", "show", "wood-small", "--set", "camera.tilt_deg=30", "--set", "laser.waist_mm={uniform: [0.1, 0.2]}")
    drawn = {"uniform": [0.1, 0.2]}
    loaded = sheetlight.Recipe.load("wood-small", {"camera.tilt_deg": 30, "laser.waist_mm": drawn})
    assert loaded.text == text
    again = sheetlight.Recipe.load("wood-small", camera={"tilt_deg": 30}, laser={"waist_mm": drawn})
    assert again.hash == loaded.hash != sheetlight.Recipe.load("wood-small").hash
    assert 0.1 <= loaded.sample(0).parameters["laser.waist_mm"] <= 0.2
    assert sheetlight.Recipe.load("wood-small", name="mine").name == "mine"
    file = tmp_path / "mine.yaml"
    file.write_text(text)
    assert sheetlight.Recipe.load(file).hash == sheetlight.Recipe.load(str(file)).hash == loaded.hash


def test_all_faults_come_at_once_with_line_key_and_remedy(tmp_path):
    file = tmp_path / "faulty.yaml"
    file.write_text(gen("recipe", "show", "wood-small").replace("columns: 256", "colums: 256").replace("strength: 1", "strength: 7"))
    with pytest.raises(sheetlight.RecipeError) as caught:
        sheetlight.Recipe.load(file, {"camera.tilt_deg": 130})
    faults = {fault.key: fault for fault in caught.value.faults}
    assert {"camera.tilt_deg", "speckle.strength"} <= set(faults)
    lines = file.read_text().splitlines()
    line, column = faults["speckle.strength"].place
    assert lines[line - 1][column - 1 :].startswith("7") and faults["speckle.strength"].remedy
    assert faults["camera.tilt_deg"].place is None
    [misspelt] = [fault for fault in caught.value.faults if "colums" in fault.problem or "colums" in fault.key]
    assert lines[misspelt.place[0] - 1].strip().startswith("colums") and "columns" in misspelt.problem + misspelt.remedy
    # The message is what `gen` says, and the exception survives a worker process.
    words = str(caught.value)
    assert words == gen_words("--recipe", file, "--n", 1, "--set", "camera.tilt_deg=130")
    twin = pickle.loads(pickle.dumps(caught.value))
    assert str(twin) == words and twin.faults == caught.value.faults


def gen_words(*arguments):
    import subprocess

    from conftest import GEN

    done = subprocess.run([GEN, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 1
    return done.stderr.removeprefix("gen: ").strip()


def test_what_is_no_recipe_is_told(tmp_path):
    with pytest.raises(sheetlight.RecipeNotFoundError, match="did you mean `wood-small`"):
        sheetlight.Recipe.load("wood-smal")
    with pytest.raises(FileNotFoundError):
        sheetlight.Recipe.load(tmp_path / "none.yaml")
    with pytest.raises(sheetlight.DatasetError, match="is a folder that holds no dataset.json"):
        sheetlight.Recipe.load(tmp_path)
    with pytest.raises(TypeError, match=r"camera.tilt_deg: a object is nothing that a recipe can hold"):
        sheetlight.Recipe.load("wood-small", {"camera.tilt_deg": object()})
    with pytest.raises(ValueError, match="camera.tilt_deg: nan"):
        sheetlight.Recipe.load("wood-small", {"camera.tilt_deg": float("nan")})
    with pytest.raises(ValueError, match="is no key"):
        sheetlight.Recipe.load("wood-small", {"camera tilt": 1})
    for wrong, words in [(["camera.tilt_deg=3"], "overrides: give a mapping .* not list"), ([], "overrides: give a mapping .* not list"), ({3: 4}, "overrides: 3 is no key")]:
        with pytest.raises(TypeError, match=words):
            sheetlight.Recipe.load("wood-small", wrong)
    with pytest.raises(TypeError, match="name: give a path, not int"):
        sheetlight.Recipe.load(3)
    with pytest.raises(ValueError, match="name: the path is empty"):
        sheetlight.Recipe.load("")
    with pytest.raises(TypeError, match="Recipe.load"):
        sheetlight.Recipe()


@pytest.mark.parametrize("index, fault", [(-1, IndexError), (10**8, IndexError), (2**70, IndexError), (0.5, TypeError), ("3", TypeError), (True, TypeError)])
def test_numbers_that_are_none_are_told(index, fault):
    recipe = sheetlight.Recipe.load("wood-small", SMALL)
    with pytest.raises(fault, match="index: "):
        recipe.sample(index)


def test_arguments_that_cannot_be_used_are_told():
    recipe = sheetlight.Recipe.load("wood-small", SMALL)
    for wrong in ({"seed": -1}, {"seed": 2**64}, {"threads": 0}, {"threads": -1}, {"threads": 10_000}, {"threads": 2**70}):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            recipe.sample(0, **wrong)
        with pytest.raises(ValueError, match=next(iter(wrong))):
            recipe.samples(2, **wrong)
    for wrong in ({"seed": "a"}, {"seed": 0.0}, {"threads": "2"}, {"threads": 2.0}):
        with pytest.raises(TypeError, match=f"{next(iter(wrong))}: .* is no whole number"):
            recipe.sample(0, **wrong)
        with pytest.raises(TypeError, match=f"{next(iter(wrong))}: .* is no whole number"):
            recipe.samples(2, **wrong)
    assert recipe.sample(np.int64(1), np.uint64(3)).id == recipe.sample(1, 3).id
    for wrong in (range(-1, 2), -1):
        with pytest.raises(IndexError, match="numbers: -1"):
            recipe.samples(wrong)
    with pytest.raises(TypeError, match="range"):
        recipe.samples([1, 2])


def test_recipes_are_equal_where_their_samples_are(boards, tmp_path):
    one, same = sheetlight.Recipe.load("wood-small", SMALL), sheetlight.Recipe.load("wood-small", dict(reversed(SMALL.items())))
    assert one == same and hash(one) == hash(same) and one == pickle.loads(pickle.dumps(one)) and len({one, same}) == 1
    other = sheetlight.Recipe.load("wood-small", {**SMALL, "camera.tilt_deg": 30})
    read = sheetlight.Recipe.load(boards)
    file = tmp_path / "boards.yaml"
    file.write_text(read.text)
    unseeded = sheetlight.Recipe.load(file)
    assert one != other and one != "wood-small" and unseeded.hash == read.hash and unseeded != read
    assert read == sheetlight.Recipe.load(boards)


def test_recipes_go_to_other_processes(tmp_path, monkeypatch):
    recipe = sheetlight.Recipe.load("wood-small", SMALL)
    twin = pickle.loads(pickle.dumps(recipe))
    assert twin.hash == recipe.hash and twin.sample(4).id == recipe.sample(4).id
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "mine.yaml"
    file.write_text(recipe.text)
    packed = pickle.dumps(sheetlight.Recipe.load("mine.yaml"))
    monkeypatch.chdir("/")
    assert pickle.loads(packed).hash == recipe.hash
    file.write_text(recipe.text + "\n# a comment\n")
    assert pickle.loads(packed).hash == recipe.hash
    file.write_text(gen("recipe", "show", "blister-small"))
    with pytest.raises(ValueError, match="has changed since it was loaded"):
        pickle.loads(packed)
    changed = sheetlight.Recipe.load(file)
    file.write_text(recipe.text)
    with pytest.raises(ValueError, match="has changed since it was loaded"):
        sheetlight.generate(changed, 1, tmp_path / "out")
    assert not (tmp_path / "out").exists()
