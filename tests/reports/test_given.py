"""The inputs beside the folder of real logs, each as :mod:`tests.reports.given` says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.reports.given import CASES, Given, printed, score

ON_WALLS, FOUND = 97, 93  #: per cent that a map must have


@pytest.fixture(scope="session")
def reports(data_dir: Path) -> Path:
    """The folder of the inputs; where there is none the test is skipped."""
    folder = data_dir.resolve().parent / "reports"
    if not folder.is_dir():
        pytest.skip("there is no folder 'reports' beside the folder of real logs")
    return folder


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_each_comes_out_as_its_format_says(reports: Path, tmp_path: Path, case: Given) -> None:
    told = printed(reports, case, tmp_path / "out")
    assert re.search(case.said, told), told
    assert not re.search(case.unsaid, told), told
    if case.frame is not None:
        found = score(reports, case, tmp_path / "out")
        assert found.on_walls >= ON_WALLS
        assert found.found >= FOUND


def test_no_input_is_left_out(reports: Path) -> None:
    """Files in folders of their own count as those; some are there beside others."""
    known = {case.path for case in CASES}
    beside = {"logs/tum_ok.txt", "maps/room.yaml", "maps/absdir", "nav2/nav2_trackon.yaml"}
    there = {
        str(path.relative_to(reports))
        for kind in ("logs", "maps", "nav2", "clouds")
        for path in (reports / kind).iterdir()
        if path.suffix not in {".pgm", ".png"}
    }
    assert there - beside == {path for path in known if not path.startswith("maps/absdir/")}
