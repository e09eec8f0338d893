"""Shared by all tests: the folder of real logs, the settings of Hypothesis, and tests that lack something."""

from __future__ import annotations

import gc
import os
from collections import Counter
from collections.abc import Callable, Generator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from mapper.sensors.scan import ScanLog
from mapper.simulation import sample_log
from tests import programs
from tests.programs import MissingProgramError, in_ci

# Speed is never asserted, so examples have no deadline; CI must not fail by the luck of the draw.
settings.register_profile("gridbloom", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("ci", settings.get_profile("gridbloom"), derandomize=True, print_blob=True)
for _name in ("no_proxy", "NO_PROXY"):  # a proxy of the environment has another loopback than the tests' services
    os.environ[_name] = ",".join(filter(None, (os.environ.get(_name), "127.0.0.1", "localhost", "::1")))
os.environ.setdefault("GRIDBLOOM_COMPILE_AHEAD", "false")  # services of tests: `make test` has compiled the kernels
settings.load_profile("ci" if in_ci() else "gridbloom")


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


_LEFT_OUT = "left out"  #: name of the property of a report that says what was missing


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Leave out a test that needs what is missing; in CI it fails. ``skipif`` and ``xfail`` marks are as elsewhere."""
    report = yield
    if call.excinfo is not None and call.excinfo.errisinstance(MissingProgramError):
        report.outcome = "skipped"
        report.longrepr = programs.__file__, 1, f"Skipped: {call.excinfo.value}"  # one place: pytest lists it once
    if report.skipped and not hasattr(report, "wasxfail") and item.get_closest_marker("skipif") is None:
        _, _, reason = report.longrepr if isinstance(report.longrepr, tuple) else ("", 0, str(report.longrepr))
        report.user_properties.append((_LEFT_OUT, reason.removeprefix("Skipped: ")))
        if in_ci():
            report.outcome = "failed"
            report.longrepr = f"Nothing that a test needs may be missing in CI: {reason.removeprefix('Skipped: ')}"
    return report


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> Generator[None, None, None]:
    """Say last, above pytest's own last line, what was left out for want of something, and how to get it."""
    yield
    reports: list[pytest.TestReport] = terminalreporter.getreports("skipped")
    missing = Counter(str(what) for one in reports for name, what in one.user_properties if name == _LEFT_OUT)
    if missing:
        terminalreporter.section("left out, because something is missing here")
        for what, count in missing.most_common():
            terminalreporter.line(f"{count} test{'s' if count > 1 else ''}: {what}")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark every test that reads the real logs, so that ``-m "not data"`` leaves them out."""
    for item in items:
        if {"data_dir", "data_file"} & set(getattr(item, "fixturenames", ())):
            item.add_marker(pytest.mark.data)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Collect the tests without the garbage collector, which would go through all of them again and again."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.freeze()  # they stay to the end
