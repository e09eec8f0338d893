"""``gridbloom edit``: a file of edits on a map file."""

import json
from pathlib import Path

import numpy as np
from PIL import Image

from mapper.editing import EditedMap, parse_operation
from mapper.editing.files import edits_text
from mapper.grid import GridGeometry
from mapper.io.maps import load_map
from tests.server.cli.maps.test_costmap import small_map
from tests.server.cli.running import Run


def test_edits_are_carried_out_and_errors_name_the_edit(run: Run, tmp_path: Path) -> None:
    map_yaml = small_map(tmp_path)
    loaded = load_map(map_yaml)
    edited = EditedMap(loaded.grid.geometry, loaded.values)
    edited.apply(parse_operation({"op": "crop", "corners": [[-1.0, 2.0], [1.0, 3.5]]}))
    edited.apply(parse_operation({"op": "despeckle", "cells": 3}))
    text = edits_text(edited, map_yaml.name)
    (tmp_path / "edits.json").write_text(text)
    done = run("edit", map_yaml, "--edits", tmp_path / "edits.json", "--out", tmp_path / "new", "--json")
    assert done.status == 0, done.err
    facts = json.loads(done.out)
    assert (facts["width"], facts["height"], facts["edits"]) == (20, 15, 2)
    with Image.open(tmp_path / "new.pgm") as image:
        assert GridGeometry.to_image(np.asarray(image)).tolist() == [[254] * 20] * 15
    (tmp_path / "edits.json").write_text(text.replace('"cells": 3', '"cells": 0'))
    refused = run("edit", map_yaml, "--edits", tmp_path / "edits.json", "--out", tmp_path / "other")
    assert refused.status == 2
    assert "Edit 2: The size of a speck must be a number" in refused.err
    assert not (tmp_path / "other.pgm").exists()
    missing = run("edit", map_yaml, "--edits", tmp_path / "none.json", "--out", tmp_path / "other")
    assert (missing.status, "Traceback" in missing.err) == (2, False)
