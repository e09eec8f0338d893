"""In CI a test fails if something it needs is missing; elsewhere it is skipped with the reason."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TESTS = """
import pytest
from tests.programs import MissingProgramError

def test_needs_the_logs(data_file):
    data_file("carmen/none.log")

def test_skips():
    pytest.skip("no such program")

@pytest.fixture(scope="module")
def program():
    raise MissingProgramError("The tests of frying need a pan: buy one.")

def test_fries(program):
    pass

def test_fries_more(program):
    pass

def test_fries_itself():
    raise MissingProgramError("The tests of frying need a pan: buy one.")

@pytest.mark.skipif(True, reason="another system")
def test_of_another_system():
    pass

@pytest.mark.xfail(strict=True)
def test_known_to_fail():
    assert False
"""


def outcome(folder: Path, **environment: str) -> tuple[int, str]:
    """The exit status and the output of a run of the tests above."""
    path = folder / "test_some.py"
    path.write_text(TESTS)
    kept = {name: value for name, value in os.environ.items() if name not in ("CI", "GRIDBLOOM_TEST_DATA")}
    command = [sys.executable, "-m", "pytest", "-p", "tests.conftest", "-p", "no:cacheprovider", "-c", "pyproject.toml"]
    done = subprocess.run(
        [*command, str(path)], cwd=ROOT, env=kept | environment, capture_output=True, text=True, check=False
    )
    return done.returncode, done.stdout


@pytest.mark.parametrize("ci", ["", "false"])
def test_outside_ci_it_is_skipped_with_the_reason(tmp_path: Path, ci: str) -> None:
    status, said = outcome(tmp_path, CI=ci)
    assert status == 0, said
    assert "6 skipped, 1 xfailed" in said
    assert "GRIDBLOOM_TEST_DATA does not name the folder of real logs" in said


def test_the_last_lines_say_what_was_left_out(tmp_path: Path) -> None:
    _, said = outcome(tmp_path)
    *_, heading, first, second, third, last = said.splitlines()
    assert "left out" in heading
    assert first == "3 tests: The tests of frying need a pan: buy one."
    assert {second, third} == {
        "1 test: GRIDBLOOM_TEST_DATA does not name the folder of real logs",
        "1 test: no such program",
    }
    assert "skipped" in last, "pytest's own line"


def test_in_ci_it_fails_with_the_reason(tmp_path: Path) -> None:
    (tmp_path / "carmen").mkdir()
    for data in ({}, {"GRIDBLOOM_TEST_DATA": str(tmp_path)}):
        status, said = outcome(tmp_path, CI="true", **data)
        assert status == 1, said
        failures, errors = (2, 3) if not data else (3, 2)  # of the files, a fixture and a test
        assert f"{failures} failed, 1 skipped, 1 xfailed, {errors} errors" in said, "only the skipif mark holds"
        assert "no such program" in said
        assert "Nothing that a test needs may be missing in CI: The tests of frying need a pan" in said
        missing = "has no carmen/none.log" if data else "GRIDBLOOM_TEST_DATA does not name the folder of real logs"
        assert missing in said


def test_in_ci_make_test_ends_where_postgresql_cannot_be_had(tmp_path: Path) -> None:
    """With a PATH on which there is nothing, and folders of distributions in which there is nothing either."""
    program = "from tests.server.library import postgresql as p; p.FOLDERS = (); import sys; sys.exit(p.main())"
    for ci, status in (("true", 1), ("", 0)):
        done = subprocess.run(
            [sys.executable, "-c", program],
            cwd=ROOT, env={"PATH": str(tmp_path), "CI": ci}, capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert (done.returncode, done.stdout) == (status, "")
        assert len(done.stderr.splitlines()) == 1
        assert "apt-get install postgresql" in done.stderr
