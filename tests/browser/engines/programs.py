"""Find Firefox, and WebKit with its WebDriver and Xvfb; as a program, install them if possible.

``make test`` runs the program before the tests: it prints the paths, or for each engine one sentence on what to do.
Then it exits with 1 in CI, where the tests need both; elsewhere the tests of an engine that is missing are skipped.
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from tests.programs import MissingProgramError, apt_install, in_ci

FIREFOXES = ("firefox-esr", "firefox", "/Applications/Firefox.app/Contents/MacOS/firefox")
#: Where WebKitGTK for GTK 3 has its processes, and MiniBrowser with them.
FOLDERS = ("usr/lib/*/webkit2gtk-4.*", "usr/lib*/webkit2gtk-4.*", "usr/libexec/webkit2gtk-4.*")


@dataclass(frozen=True, slots=True)
class Programs:
    """The programs of an engine: its Debian packages, and the sentence on what needs them and how one gets them."""

    find: Callable[[], dict[str, Path | None]]  #: by name; None for what is missing
    packages: tuple[str, ...]
    purpose: str
    advice: str

    def found(self) -> dict[str, Path]:
        """Return the path of each program; raise :class:`MissingProgramError` where one is missing."""
        programs = self.find()
        missing = [name for name, path in programs.items() if path is None]
        if missing:
            raise MissingProgramError(f"{self.purpose} ({', '.join(missing)} missing): {self.advice}.")
        return {name: path for name, path in programs.items() if path is not None}

    def install(self) -> None:
        """Install the packages; raise :class:`MissingProgramError` where that is not possible."""
        for package in self.packages:
            apt_install((package,), self.purpose, self.advice)


def _on_path(name: str) -> Path | None:
    found = shutil.which(name)
    return None if found is None else Path(found)


def _is_snap(program: Path) -> bool:
    """Whether it is Ubuntu's Firefox, which cannot read a profile of the tests in the temporary folder."""
    with program.open("rb") as file:
        return b"snap" in file.read(4096) or "snap" in program.resolve().parts


def _find_firefox() -> dict[str, Path | None]:
    found = (path for path in map(_on_path, FIREFOXES) if path is not None and not _is_snap(path))
    return {"Firefox": next(found, None)}


def _find_webkit() -> dict[str, Path | None]:
    browsers = (path for folder in FOLDERS for path in sorted(Path("/").glob(f"{folder}/MiniBrowser")))
    driver, xvfb = _on_path("WebKitWebDriver"), _on_path("Xvfb")
    return {"WebKitWebDriver": driver, "MiniBrowser": next(browsers, None), "Xvfb": xvfb}


FIREFOX = Programs(
    _find_firefox,
    ("firefox-esr",),
    "The tests in Firefox need it",
    "install it (Debian: apt-get install firefox-esr) or put it on the PATH",
)
WEBKIT = Programs(
    _find_webkit,
    ("webkit2gtk-driver", "xvfb"),
    "The tests in WebKit need its programs",
    "install them (Debian, Ubuntu: apt-get install webkit2gtk-driver xvfb)",
)


def main() -> int:
    """Print the programs of each engine; install them first where they are missing."""
    missing = False
    for engine in (FIREFOX, WEBKIT):
        try:
            try:
                found = engine.found()
            except MissingProgramError:
                engine.install()
                found = engine.found()
        except MissingProgramError as error:
            print(error, file=sys.stderr)
            missing = True
        else:
            print(*found.values())
    return 1 if missing and in_ci() else 0


if __name__ == "__main__":
    sys.exit(main())
