"""``gridbloom map`` on real logs, against an independent program.

The other program reads the columns of the FLASER lines, walks each beam with Bresenham's error term (IBM Systems
Journal 4, 1965), and adds −0.4 to each cell passed and +0.85 to the last, clamped to −2 … 3.5.
"""

from __future__ import annotations

import gzip
import itertools
import math
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml
from numpy.typing import NDArray

from server.cli import main
from tests.marks import also_long_rows

RESOLUTION, MAX_RANGE = 0.05, 30.0


def cells_passed(row: int, col: int, end_row: int, end_col: int) -> tuple[list[int], list[int]]:
    """The cells of a line but its last, stepped with an error term."""
    rows, cols = [], []
    d_row, d_col = abs(end_row - row), abs(end_col - col)
    row_step, col_step = (1 if end_row > row else -1), (1 if end_col > col else -1)
    if d_col >= d_row:
        error = 2 * d_row - d_col
        for _ in range(d_col):
            rows.append(row)
            cols.append(col)
            if error >= 0:
                row += row_step
                error -= 2 * d_col
            col += col_step
            error += 2 * d_row
        return rows, cols
    cols, rows = cells_passed(col, row, end_col, end_row)
    return rows, cols


def bresenham_map(path: Path, rows: int, cols: int, origin: list[float]) -> NDArray[np.float64]:
    log_odds = np.zeros((rows, cols))
    bearings = np.radians(np.arange(180) - 90.0)
    for line in gzip.decompress(path.read_bytes()).decode().splitlines():
        if not line.startswith("FLASER"):
            continue
        columns = [float(field) for field in line.split()[2:185]]
        ranges, (x, y, theta) = np.array(columns[:180]), columns[180:]
        first_col, first_row = math.floor((x - origin[0]) / RESOLUTION), math.floor((y - origin[1]) / RESOLUTION)
        end_cols = np.floor((x + ranges * np.cos(theta + bearings) - origin[0]) / RESOLUTION).astype(int)
        end_rows = np.floor((y + ranges * np.sin(theta + bearings) - origin[1]) / RESOLUTION).astype(int)
        for reading, row, col in zip(ranges, end_rows, end_cols, strict=True):
            if not 0.0 < reading <= MAX_RANGE:
                continue
            passed = cells_passed(first_row, first_col, int(row), int(col))
            log_odds[passed] = np.maximum(log_odds[passed] - 0.4, -2.0)
            log_odds[row, col] = min(log_odds[row, col] + 0.85, 3.5)
    return log_odds


def part_of(log: Path, folder: Path, every: int) -> Path:
    """Write a log with only every n-th of its scans to a folder."""
    number = itertools.count()
    lines = gzip.decompress(log.read_bytes()).splitlines(keepends=True)
    kept = [line for line in lines if not line.startswith(b"FLASER") or next(number) % every == 0]
    path = folder / log.name
    path.write_bytes(gzip.compress(b"".join(kept)))
    return path


@pytest.mark.parametrize(
    ("name", "every"),
    [
        ("intel-corrected", 4),
        *also_long_rows(("intel-corrected", 1), ("aces-corrected", 1), ("fhw-corrected", 1)),
    ],
)
def test_the_written_map_is_that_of_an_independent_program(data_file, tmp_path, monkeypatch, capsys, name, every):
    log = part_of(data_file(f"carmen/{name}.log.gz"), tmp_path, every)
    options = ["--max-range", str(MAX_RANGE), "--resolution", str(RESOLUTION), "--out", str(tmp_path / "out" / name)]
    options += ["--hit-and-passed", "both_count", "--quiet"]  # that program adds each beam's evidence
    monkeypatch.setattr(sys, "argv", ["gridbloom", "map", str(log), *options])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 0, capsys.readouterr().err

    magic, size, depth, pixels = (tmp_path / "out" / f"{name}.pgm").read_bytes().split(b"\n", 3)
    cols, rows = map(int, size.split())
    assert (magic, depth) == (b"P5", b"255")
    grey = np.frombuffer(pixels, dtype=np.uint8).reshape(rows, cols)[::-1]
    described = yaml.safe_load((tmp_path / "out" / f"{name}.yaml").read_text())
    assert (described["image"], described["resolution"]) == (f"{name}.pgm", RESOLUTION)

    log_odds = bresenham_map(log, rows, cols, described["origin"])
    p_occ = 1.0 / (1.0 + np.exp(-log_odds))
    expected = np.where(p_occ > 0.65, 0, np.where(p_occ < 0.25, 254, 205))
    # Most cells were never seen; only those that either program knows something of can disagree.
    known = (expected != 205) | (grey != 205)
    agreement = np.count_nonzero((grey == expected) & known) / np.count_nonzero(known)
    assert np.count_nonzero(known) > 100_000
    assert agreement >= 0.999, f"{agreement:.5%} of the {np.count_nonzero(known)} known cells agree"
