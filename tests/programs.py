"""The programs that the tests need besides Python: whether they are required, and how they are installed.

A test that needs one lets :class:`MissingProgramError` pass: the test is then left out with the error's sentence, which
the run's last lines repeat, and in CI it fails (``tests/conftest.py``).
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path


def in_ci() -> bool:
    """Return whether these are the tests of CI, where what the tests need must be there."""
    return os.environ.get("CI", "").lower() not in ("", "0", "false")


class MissingProgramError(RuntimeError):
    """A program is missing; the message is one sentence on what to do."""


def apt_install(packages: tuple[str, ...], purpose: str, advice: str) -> None:
    """Install the first of some Debian packages that apt-get can, as root or with a sudo that asks for no password.

    ``purpose`` begins the error's sentence, as in "The browser tests need Chromium", and ``advice`` ends it.
    Raises :class:`MissingProgramError` where none of them can be installed.
    """
    if shutil.which("apt-get") is None:
        raise MissingProgramError(f"{purpose}, and there is no apt-get here: {advice}.")
    if os.geteuid() == 0:
        prefix: list[str] = []
    elif (
        shutil.which("sudo")
        and subprocess.run(["sudo", "-n", "true"], capture_output=True, check=False).returncode == 0
    ):
        prefix = ["sudo", "-n"]
    else:
        raise MissingProgramError(f"{purpose}, and only root can install it: {advice}.")

    def apt_get(*arguments: str) -> bool:
        command = [*prefix, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-qq", *arguments]
        # apt's own words go to standard error: standard output holds the path and nothing else.
        return subprocess.run(command, stdout=sys.stderr, check=False).returncode == 0

    if not apt_get("update"):
        raise MissingProgramError(f"{purpose}, and apt-get update failed: {advice}.")
    if not any(apt_get("install", "--yes", "--no-install-recommends", package) for package in packages):
        raise MissingProgramError(f"{purpose}, and apt-get install failed: {advice}.")


def find_or_install(find: Callable[[], Path | str], packages: tuple[str, ...], purpose: str, advice: str) -> int:
    """Print the path that ``find`` returns, installing the program first where it is missing; return the exit status.

    Where that cannot be done, standard error gets one sentence on what to do. In CI the status is then 1; elsewhere it
    is 0, for the tests that need the program are left out.
    """
    try:
        try:
            path = find()
        except MissingProgramError:
            apt_install(packages, purpose, advice)
            path = find()
    except MissingProgramError as error:
        print(error, file=sys.stderr)
        return 1 if in_ci() else 0
    print(path)
    return 0
