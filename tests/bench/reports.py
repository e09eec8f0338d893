"""``python -m tests.bench reports``: the maps of recordings that stand for public reports, against the true walls."""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

from tests.reports.given import CASES, Score, printed, score


def reports() -> None:
    """Print the table of docs/figures.md: which share of each map is on a wall, and which share of the walls it has."""
    folder = Path(os.environ.get("GRIDBLOOM_TEST_DATA", "../shared/data")).resolve().parent / "reports"
    if not folder.is_dir():
        print("There is no folder 'reports' beside the one that GRIDBLOOM_TEST_DATA names.", file=sys.stderr)
        return
    rows: dict[Score, list[str]] = {}
    with tempfile.TemporaryDirectory() as scratch:
        for case in CASES:
            if case.frame is not None:
                out = Path(scratch) / "map"
                printed(folder, case, out)
                rows.setdefault(score(folder, case, out), []).append(case.name)
    print("| recordings | on true walls | walls found |\n|---|---|---|")
    for (on_walls, found), names in sorted(rows.items(), reverse=True):
        print(f"| {', '.join(names)} | {on_walls} % | {found} % |")
