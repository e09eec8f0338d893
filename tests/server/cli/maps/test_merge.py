"""``merge``: map files of one place combined."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.server.cli.running import state_counts


def write_map(path: Path, values: list[list[int]], x: float = 0.0) -> Path:
    """Write a map as a person would: its values in per cent, 255 unknown, the top row first."""
    path.with_suffix(".pgm").write_bytes(
        f"P5\n{len(values[0])} {len(values)}\n255\n".encode() + np.array(values, np.uint8).tobytes()
    )
    path.write_text(
        f"image: {path.stem}.pgm\nmode: raw\nresolution: 0.5\norigin: [{x}, 0.0, 0.0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.25\n"
    )
    return path


def values_of(path: Path) -> NDArray[np.uint8]:
    _, size, _, pixels = path.read_bytes().split(b"\n", 3)
    cols, rows = map(int, size.split())
    return np.frombuffer(pixels, np.uint8).reshape(rows, cols)


def test_the_odds_of_two_maps_are_multiplied(run, tmp_path):
    a = write_map(tmp_path / "a.yaml", [[80, 20, 255], [50, 90, 10]])
    b = write_map(tmp_path / "b.yaml", [[80, 255, 30], [20, 80, 255]], x=0.5)
    status, out, err = run("merge", a, b, "--out", tmp_path / "both", "--mode", "raw", "--json")
    facts = json.loads(out)
    assert (status, err, out.count("\n")) == (0, "", 1)
    assert (facts["rows"], facts["cols"], facts["origin"]) == (2, 4, [0.0, 0.0, 0.0])
    # b lies one column to the right. 0.2 and 0.8: odds of 1/4 · 4; 0.9 and 0.2: 9 · 1/4; 0.1 and 0.8: 1/9 · 4.
    np.testing.assert_array_equal(values_of(tmp_path / "both.pgm"), [[80, 50, 255, 30], [50, 69, 31, 255]])


def test_merging_the_maps_of_two_halves_gives_the_map_of_the_whole(run, log, tmp_path):
    options = ["--resolution", 0.1, "--no-clamp", "--hit", 0.3, "--miss", -0.1, "--mode", "raw"]
    whole = state_counts(run, log, *options, "--out", tmp_path / "whole")
    state_counts(run, log, *options, "--scans", 2, "--out", tmp_path / "first")
    last = tmp_path / "last.log"
    last.write_text("".join(gzip.decompress(log.read_bytes()).decode().splitlines(keepends=True)[4:]))
    state_counts(run, last, *options, "--out", tmp_path / "last")
    facts = json.loads(
        run(
            "merge", tmp_path / "first.yaml", tmp_path / "last.yaml", "--out", tmp_path / "m", "--mode", "raw", "--json"
        ).out
    )
    assert facts["occupied"] > 100
    assert abs(facts["occupied"] - whole["occupied"]) <= 0.02 * whole["occupied"]  # files keep hundredths
    assert facts["files"] == [str(tmp_path / "m.pgm"), str(tmp_path / "m.yaml")]


def test_maps_that_do_not_fit_are_refused_by_their_name(run, tmp_path):
    a = write_map(tmp_path / "a.yaml", [[80]])
    b = write_map(tmp_path / "b.yaml", [[80]], x=0.2)
    for maps, words in (([a, b], "0.4 columns apart"), ([a, tmp_path / "c.yaml"], "There is no file 'c.yaml'")):
        status, out, err = run("merge", *maps, "--out", tmp_path / "m")
        assert (status, out, err.count("\n")) == (2, "", 1)
        assert err.startswith(f"gridbloom: {maps[1]}: ")
        assert words in err
    assert run("merge", a, "--out", tmp_path / "m", "--mode", "colour").status == 2
