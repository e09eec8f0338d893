"""What all tests share: the real logs where they lie, and how Hypothesis runs."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from mapper.scan import ScanLog
from mapper.world import sample_log

# Speed is never asserted, so examples have no deadline; CI must not fail by the luck of the draw.
settings.register_profile("gridbloom", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("ci", settings.get_profile("gridbloom"), derandomize=True, print_blob=True)
settings.load_profile("ci" if os.environ.get("CI") else "gridbloom")


@pytest.fixture(scope="session")
def real_logs() -> Path | None:
    """The folder of real logs that GRIDBLOOM_TEST_DATA names, None without it, for tests that can do without."""
    named = os.environ.get("GRIDBLOOM_TEST_DATA")
    if not named:
        return None
    folder = Path(named)
    if not folder.is_dir():
        pytest.fail(f"GRIDBLOOM_TEST_DATA names {named!r}, which is no folder")
    return folder


@pytest.fixture(scope="session")
def data_dir(real_logs: Path | None) -> Path:
    """The folder of real logs; where there is none the test is skipped."""
    if real_logs is None:
        pytest.skip("GRIDBLOOM_TEST_DATA does not name the folder of real logs")
    return real_logs


@pytest.fixture(scope="session")
def data_file(data_dir: Path) -> Callable[[str], Path]:
    """A function from a path in the folder of real logs to the file; it skips where the file is missing."""

    def find(relative: str) -> Path:
        path = data_dir / relative
        if not path.exists():
            pytest.skip(f"the folder of real logs has no {relative}")
        return path

    return find


@pytest.fixture(scope="session")
def office_log() -> ScanLog:
    """A simulated office run of 150 scans with its true poses: a log for tests that only need some log."""
    return sample_log(150)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark every test that reads the real logs, so that ``-m "not data"`` leaves them out."""
    for item in items:
        if {"data_dir", "data_file"} & set(getattr(item, "fixturenames", ())):
            item.add_marker(pytest.mark.data)
