"""The digest by which the build of the pages is skipped depends on the sources; installed packages are not read."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[1] / "static" / "build_pages.py"


@pytest.fixture(scope="module")
def digest_of_sources() -> Callable[[Path], str]:
    spec = importlib.util.spec_from_file_location("build_pages", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    digest: Callable[[Path], str] = module.digest_of_sources
    return digest


def test_the_digest_changes_with_the_sources_only(tmp_path: Path, digest_of_sources: Callable[[Path], str]) -> None:
    source = tmp_path / "src" / "pages" / "lab.tsx"
    source.parent.mkdir(parents=True)
    source.write_text("1")
    first = digest_of_sources(tmp_path)
    for folder in ("node_modules", "dist", "src/__pycache__", ".fonts"):
        (tmp_path / folder / "deep").mkdir(parents=True)
        (tmp_path / folder / "deep" / "file").write_text("x")
    (source.parent / ".#lab.tsx").symlink_to("an editor's lock, which names no file")
    assert digest_of_sources(tmp_path) == first
    source.write_text("2")
    changed = digest_of_sources(tmp_path)
    (source.parent / "new.ts").touch()
    assert len({first, changed, digest_of_sources(tmp_path)}) == 3
    (source.parent / "new.ts").unlink()
    source.rename(source.with_name("other.tsx"))
    assert digest_of_sources(tmp_path) not in (first, changed)


def test_folders_that_do_not_count_are_not_listed(
    tmp_path: Path, digest_of_sources: Callable[[Path], str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """node_modules has some 6,000 files, and `make serve`, `make check` and `make test` compute the digest."""
    for folder in ("src", "node_modules/preact"):
        (tmp_path / folder).mkdir(parents=True)
    listed: list[str] = []
    scandir = os.scandir

    def recording(path: str) -> object:
        listed.append(os.path.relpath(path, tmp_path))
        return scandir(path)

    monkeypatch.setattr(os, "scandir", recording)
    digest_of_sources(tmp_path)
    assert sorted(listed) == [".", "src"]


@pytest.mark.parametrize("home", ["/dev/null/none", "{tmp_path}"])
def test_npm_runs_where_the_home_cannot_be_written(home: str, tmp_path: Path) -> None:
    home = home.format(tmp_path=tmp_path)
    kept = {name: value for name, value in os.environ.items() if name.lower() != "npm_config_cache"}
    done = subprocess.run(
        [sys.executable, SCRIPT, "--silent", "config", "get", "cache"],
        env=kept | {"HOME": home}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert (done.stdout.strip() == f"{home}/.npm") == (home == str(tmp_path))
