"""Find the Chromium that the browser tests drive; as a script, install it where that is possible.

``make test`` runs the script before the tests: it prints the path, or one sentence on what to do and exits with 1.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from functools import lru_cache
from pathlib import Path

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "microsoft-edge")
MAC = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
)
ADVICE = "install Chromium (Debian, Ubuntu: apt-get install chromium) or name its program in GRIDBLOOM_CHROMIUM"


class NoChromiumError(RuntimeError):
    """There is no Chromium that starts; the message is one sentence on what to do."""


def starts(program: Path) -> bool:
    """Return whether the program says its version: some distributions' ``chromium-browser`` only says "use snap"."""
    try:
        done = subprocess.run([str(program), "--version"], capture_output=True, timeout=30, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0 and b"snap install" not in done.stdout + done.stderr


@lru_cache(maxsize=1)
def chromium() -> Path:
    """Return the program to drive: GRIDBLOOM_CHROMIUM if it is set, else the first of the usual names that starts.

    Raises :class:`NoChromiumError` where there is none.
    """
    named = os.environ.get("GRIDBLOOM_CHROMIUM")
    if named:
        found = shutil.which(named)
        if found is None or not starts(Path(found)):
            raise NoChromiumError(f"GRIDBLOOM_CHROMIUM names {named!r}, which is no Chromium that starts.")
        return Path(found)
    for candidate in (*NAMES, *MAC):
        found = shutil.which(candidate)
        if found is not None and starts(Path(found)):
            return Path(found)
    raise NoChromiumError(f"The browser tests need Chromium: {ADVICE}.")


def install() -> None:
    """Install Chromium with apt-get, as root or with a sudo that asks no password; raise where that cannot be done."""
    if shutil.which("apt-get") is None:
        raise NoChromiumError(f"The browser tests need Chromium, and there is no apt-get here: {ADVICE}.")
    if os.geteuid() == 0:
        prefix: list[str] = []
    elif (
        shutil.which("sudo")
        and subprocess.run(["sudo", "-n", "true"], capture_output=True, check=False).returncode == 0
    ):
        prefix = ["sudo", "-n"]
    else:
        raise NoChromiumError(f"The browser tests need Chromium, and only root can install it: {ADVICE}.")
    for arguments in (["update"], ["install", "--yes", "--no-install-recommends", "chromium"]):
        command = [*prefix, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-qq", *arguments]
        # apt's own words go to standard error: standard output holds the path and nothing else.
        if subprocess.run(command, stdout=sys.stderr, check=False).returncode != 0:
            raise NoChromiumError(f"apt-get {arguments[0]} failed, so the browser tests have no Chromium: {ADVICE}.")


def main() -> int:
    """Print the path of Chromium; install it first where it is missing."""
    try:
        try:
            program = chromium()
        except NoChromiumError:
            if os.environ.get("GRIDBLOOM_CHROMIUM"):
                raise
            install()
            program = chromium()
    except NoChromiumError as error:
        print(error, file=sys.stderr)
        return 1
    print(program)
    return 0


if __name__ == "__main__":
    sys.exit(main())
