"""The search for Chromium: named, started, and the message if there is none."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.browser.find_chromium import SHELL

ROOT = Path(__file__).parents[2]


def program(folder: Path, name: str, body: str) -> Path:
    path = folder / name
    path.write_text(f"#!/bin/sh\n{body}\n")
    path.chmod(0o755)
    return path


def find(folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run the program with a PATH that holds only ``folder``: nothing of this machine can be found or installed."""
    return subprocess.run(
        [sys.executable, "-m", "tests.browser.find_chromium"],
        cwd=ROOT,
        env={"PATH": str(folder), "HOME": str(folder)} | environment,
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_first_name_that_starts_is_printed(tmp_path):
    program(tmp_path, "chromium", "exit 1")
    program(tmp_path, "chromium-browser", "echo 'requires the chromium snap: snap install chromium'")
    good = program(tmp_path, "google-chrome", "echo Chrome 1")
    done = find(tmp_path)
    assert (done.returncode, done.stdout) == (0, f"{good}\n")


def test_the_environment_decides_and_must_be_right(tmp_path):
    program(tmp_path, "chromium", "echo Chromium 1")
    mine = program(tmp_path, "mine", "echo Mine 1")
    assert find(tmp_path, GRIDBLOOM_CHROMIUM=str(mine)).stdout == f"{mine}\n"
    wrong = find(tmp_path, GRIDBLOOM_CHROMIUM=str(tmp_path / "none"))
    assert wrong.returncode == 1
    assert wrong.stdout == ""
    assert "GRIDBLOOM_CHROMIUM" in wrong.stderr


def test_an_ordinary_one_is_preferred_also_in_ci(tmp_path):
    shell = program(tmp_path, SHELL, "echo Chromium 1")
    assert find(tmp_path).stdout == f"{shell}\n"
    ordinary = program(tmp_path, "chromium", "echo Chromium 1")
    for environment in ({}, {"CI": "true"}):
        assert find(tmp_path, **environment).stdout == f"{ordinary}\n"
    assert find(tmp_path, GRIDBLOOM_CHROMIUM=SHELL).stdout == f"{shell}\n"


@pytest.mark.skipif(sys.platform == "darwin", reason="looks into /Applications as well")
def test_without_a_chromium_one_sentence_gives_advice(tmp_path):
    for ci, status in (("true", 1), ("", 0)):  # elsewhere the browser tests are left out
        done = find(tmp_path, CI=ci)
        assert (done.returncode, done.stdout) == (status, "")
        assert len(done.stderr.splitlines()) == 1
        assert "install Chromium" in done.stderr


@pytest.mark.skipif(sys.platform == "darwin" or os.geteuid() != 0, reason="only root installs without sudo")
@pytest.mark.parametrize("named", ["", SHELL])
def test_it_installs_chromium_if_possible_and_prints_the_path(tmp_path, named):
    program(tmp_path, "env", 'shift; exec "$@"')
    package = named or "chromium"
    made = tmp_path / package
    making = f'printf "#!/bin/sh\\necho 1\\n" > {made} && /bin/chmod 755 {made}'
    script = f'echo installing; if [ "$2" = install ]; then for last; do :; done; [ $last = {package} ] && {making}; fi'
    program(tmp_path, "apt-get", script)
    done = find(tmp_path, GRIDBLOOM_CHROMIUM=named)
    assert (done.returncode, done.stdout) == (0, f"{made}\n"), done.stderr
    program(tmp_path, "apt-get", "exit 100")
    made.unlink()
    failed = find(tmp_path, GRIDBLOOM_CHROMIUM=named, CI="true")
    assert failed.returncode == 1
    assert "apt-get update failed" in failed.stderr
