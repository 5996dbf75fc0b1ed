"""What documentation says runs: docstrings, docs/guide/python.md, the notebook."""

import ast
import doctest
import importlib
import inspect
import json
import re
from pathlib import Path

import pytest
import sheetlight

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("module", ["", "._dataset", "._gen", "._program", "._recipe", "._sample"])
def test_docstrings_run(module):
    result = doctest.testmod(importlib.import_module(f"sheetlight{module}"))
    assert result.failed == 0 and (result.attempted > 0 or module != "._recipe")


def test_everything_that_is_promised_has_words_and_types():
    for name in sheetlight.__all__:
        thing = getattr(sheetlight, name)
        if inspect.isfunction(thing):
            functions = [thing]
        elif inspect.isclass(thing) and thing.__module__.startswith("sheetlight"):
            members = [member for key, member in vars(thing).items() if not key.startswith("_")]
            functions = [getattr(member, "fget", None) or getattr(member, "func", None) or getattr(member, "__func__", member) for member in members]
            functions = [function for function in functions if inspect.isfunction(function)]
            assert thing.__doc__
        else:
            continue
        for function in functions:
            assert function.__doc__, function
            annotated = function.__annotations__
            wanted = set(inspect.signature(function).parameters) - {"self", "cls"} | {"return"}
            assert wanted <= set(annotated), (function, wanted - set(annotated))


def test_the_stub_names_what_the_extension_has():
    stub = ast.parse((Path(sheetlight.__file__).parent / "_sheetlight.pyi").read_text())
    extension = importlib.import_module("sheetlight._sheetlight")
    public = lambda thing: {name for name in vars(thing) if not name.startswith("_")}
    declared = {node.name: node for node in stub.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    assert set(declared) | {"version"} == public(extension)
    for name, node in declared.items():
        if isinstance(node, ast.ClassDef):
            methods = {part.name for part in node.body if isinstance(part, ast.FunctionDef) and not part.name.startswith("_")}
            assert methods == public(getattr(extension, name)), name
    assert (Path(sheetlight.__file__).parent / "py.typed").exists()


def test_the_page_runs_from_top_to_bottom(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs" / "guide" / "python.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", page, re.S)
    assert len(blocks) == 7
    names = {}
    for block in blocks:
        exec(compile(block, "docs/guide/python.md", "exec"), names)
    said = capsys.readouterr().out
    assert "<Sample 3 of seed 0: " in said and "camera.tilt_deg |" in said and "torch.Size([16, 3, 64, 64])" in said
    assert "8 of 8" in said
    # Every attribute of the table is one, and every attribute is in it.
    table = page.split("| attribute | what |")[1].split("\n\n")[0]
    listed = {name.removesuffix("()") for row in table.splitlines()[2:] for name in re.findall(r"`([a-z_()]+)`", row.split("|")[1])}
    attributes = {name for name in vars(sheetlight.Sample) if not name.startswith("_")}
    told_elsewhere = {"shape", "row_mm", "col_mm", "pixel_classes", "range_px", "range_form", "range_unit"}
    assert listed == attributes - told_elsewhere and told_elsewhere <= attributes


def code_of(name):
    """Cells of a notebook with code, which is kept without what it gave."""
    notebook = json.loads((ROOT / "python" / "examples" / name).read_text())
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert len(cells) >= 5 and all(not cell["outputs"] for cell in cells)
    return ["".join(cell["source"]) for cell in cells]


def test_the_notebook_of_packs_runs(tmp_path, monkeypatch):
    """Empty pockets are told from others on packs that the network has not seen; chance is one in two."""
    monkeypatch.chdir(tmp_path)
    names = {}
    for cell in code_of("packs.ipynb"):
        exec(compile(cell, "packs.ipynb", "exec"), names)
    assert names["balanced"] > 0.7 and len(names["sides"]["test"][1]) >= 30


def test_the_notebook_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    cells, names = code_of("python.ipynb"), {}
    for cell in cells:
        if cell.strip().endswith("show(sample)") and importlib.util.find_spec("matplotlib") is None:
            # All of the cell but the drawing, for which matplotlib is not at hand.
            cell = cell.rpartition("show(sample)")[0]
        exec(compile(cell, "python.ipynb", "exec"), names)
    assert names["batch"]["maps"].shape == (8, 3, 64, 64)
    # Knots and rot are darker in Scatter than clear wood, as the cell says.
    shares = {name: sum(values) / len(values) for name, values in names["shares"].items()}
    assert all(shares[name] < shares["clear"] for name in shares if "knot" in name or name == "rot")
