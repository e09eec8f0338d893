"""Find the Chromium that the browser tests use; as a program, install it if possible.

Any Chromium will do; of several it is an ordinary one, as a person has it.

``make test`` runs it before the tests: it prints the path, or one sentence on what to do. Then it exits with 1
in CI, and where GRIDBLOOM_CHROMIUM names what does not start; elsewhere the browser tests are left out.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from functools import lru_cache
from pathlib import Path

from tests.programs import MissingProgramError, apt_install, in_ci

NAMES = (
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
    "microsoft-edge",
    "chromium-headless-shell",  # as in Debian: the same engine without the windows around its pages
    "chrome-headless-shell",  # as in Chrome for Testing
    "headless_shell",
)
MAC = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
)
SHELL = "chromium-headless-shell"  #: its program and its package in Debian
PURPOSE = "The browser tests need Chromium"
ADVICE = "install Chromium (Debian, Ubuntu: apt-get install chromium) or name its program in GRIDBLOOM_CHROMIUM"


def starts(program: Path) -> bool:
    """Return whether the program says its version: some distributions' ``chromium-browser`` only says "use snap"."""
    try:
        done = subprocess.run([str(program), "--version"], capture_output=True, timeout=180, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0 and b"snap install" not in done.stdout + done.stderr


@lru_cache(maxsize=1)
def chromium() -> Path:
    """Return the program to drive: GRIDBLOOM_CHROMIUM if it is set, else the first of the usual names that starts.

    Raises :class:`MissingProgramError` where there is none.
    """
    named = os.environ.get("GRIDBLOOM_CHROMIUM")
    if named:
        found = shutil.which(named)
        if found is None or not starts(Path(found)):
            raise MissingProgramError(f"GRIDBLOOM_CHROMIUM names {named!r}, which is no Chromium that starts.")
        return Path(found)
    for candidate in (*NAMES, *MAC):
        found = shutil.which(candidate)
        if found is not None and starts(Path(found)):
            return Path(found)
    raise MissingProgramError(f"{PURPOSE}: {ADVICE}.")


def main() -> int:
    """Print the path of Chromium, which is installed first where it is missing and a package of Debian."""
    named = os.environ.get("GRIDBLOOM_CHROMIUM")
    try:
        try:
            program = chromium()
        except MissingProgramError:
            if named not in (None, "", "chromium", SHELL):
                raise
            apt_install((named or "chromium",), PURPOSE, ADVICE)
            program = chromium()
    except MissingProgramError as error:
        print(error, file=sys.stderr)
        return 1 if in_ci() or os.environ.get("GRIDBLOOM_CHROMIUM") else 0
    print(program)
    return 0


if __name__ == "__main__":
    sys.exit(main())
