"""The programs of ``examples/`` run and write pictures; the notebooks run and show some."""

from __future__ import annotations

import ast
import contextlib
import io
import json
import os
import runpy
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from PIL import Image

from mapper.io.maps import load_map
from tests.marks import also_long_rows

ROOT = Path(__file__).parents[2]
SCRIPTS = sorted((ROOT / "examples").glob("*.py"))
NOTEBOOKS = sorted((ROOT / "examples").glob("*.ipynb"))

#: What each script writes and prints.
WRITTEN = {
    "compare_models": ({"compare_models.png"}, "mean difference"),
    "custom_model": ({"custom_model.png"}, "<OccupancyGrid"),
    "export_a_log": ({"run.csv", "map.pgm", "map.yaml", "map.png", "run.mcap"}, "CSV, 40 scans of 360 beams"),
    "map_a_log": ({"map.png"}, "cell updates"),
    "merge_maps": ({"first.pgm", "first.yaml", "second.pgm", "second.yaml", "merged.png"}, "cells are known"),
    "use_a_service": ({"run.mcap", "map.png"}, "cells are occupied; the map is at http://127.0.0.1:"),
    "why_is_this_cell_occupied": ({"why.png"}, "argued for occupied"),
}


def shows_a_map(picture: Image.Image) -> bool:
    """Whether a picture has free and occupied cells, and is not of one colour."""
    pixels = np.asarray(picture.convert("L"))
    return bool((pixels > 200).any() and (pixels < 60).any())


def output_of(script: Path, folder: Path) -> str:
    """Run a script in a process of its own; return what it prints."""
    done = subprocess.run(
        [sys.executable, str(script), "--out", str(folder / "out")],
        cwd=folder, env=os.environ | {"PYTHONPATH": str(ROOT)}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def output_in_this_process(script: Path, folder: Path) -> str:
    """Run a script in this process, which has imported numba and loaded kernels before."""
    said = io.StringIO()
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(said):
        patch.chdir(folder)
        patch.setattr(sys, "argv", [str(script), "--out", str(folder / "out")])
        runpy.run_path(str(script), run_name="__main__")
    return said.getvalue()


@pytest.mark.parametrize(
    ("script", "run_script"),
    [
        *((script, output_of if script.stem == "map_a_log" else output_in_this_process) for script in SCRIPTS),
        *also_long_rows(*((script, output_of) for script in SCRIPTS if script.stem != "map_a_log")),
    ],
    ids=lambda value: getattr(value, "stem", "") or value.__name__,
)
def test_a_script_writes_its_files(script: Path, run_script: Callable[[Path, Path], str], tmp_path: Path) -> None:
    printed = run_script(script, tmp_path)
    files, said = WRITTEN[script.stem]
    assert {path.name for path in (tmp_path / "out").iterdir()} == files
    assert said in printed
    for picture in (tmp_path / "out").glob("*.png"):
        assert shows_a_map(Image.open(picture))
    if script.stem == "export_a_log":
        assert (load_map(tmp_path / "out" / "map.yaml").values == 100).any()
        with (tmp_path / "out" / "run.mcap").open("rb") as file:
            topics = [channel.topic for _, channel, _ in make_reader(file).iter_messages()]
        assert topics.count("/scan") == 40
        assert {"/map", "/tf", "/pose"} <= set(topics)


def run(source: str, names: dict[str, Any]) -> object:
    """Execute a cell; return the value of its last expression, as a notebook shows it, None without one."""
    tree = ast.parse(source)
    last = tree.body[-1]
    if not isinstance(last, ast.Expr):
        exec(compile(tree, "cell", "exec"), names)
        return None
    exec(compile(ast.Module(tree.body[:-1], []), "cell", "exec"), names)
    return eval(compile(ast.Expression(last.value), "cell", "eval"), names)


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_and_shows_pictures(notebook: Path, capsys: pytest.CaptureFixture[str]) -> None:
    content = json.loads(notebook.read_text())
    names: dict[str, Any] = {}
    pictures = []
    for cell in content["cells"]:
        if cell["cell_type"] == "code":
            assert cell["outputs"] == [], "notebooks are kept without outputs"
            shown = run("".join(cell["source"]), names)
            if hasattr(shown, "_repr_png_"):
                pictures.append(Image.open(io.BytesIO(shown._repr_png_())))
    assert len(pictures) >= 3
    assert any(map(shows_a_map, pictures))
    assert capsys.readouterr().out


def test_there_is_no_other_example() -> None:
    assert {path.stem for path in SCRIPTS} == WRITTEN.keys()
    assert len(NOTEBOOKS) == 2
