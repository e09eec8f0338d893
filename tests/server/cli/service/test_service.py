"""``serve``, and what the command imports for ``--help``."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

from server.settings import Settings, unknown_setting

ROOT = Path(__file__).parents[4]


def test_version_is_that_of_the_package(run):
    stated = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    assert run("--version") == (0, f"gridbloom {stated}\n", "")


def test_serve_refuses_invalid_settings(run, tmp_path):
    for options, words in ((["--port", "70000"], "port"), (["--logs-dir", tmp_path / "gone"], "is not a folder")):
        status, out, err = run("serve", *options)
        assert (status, out) == (2, "")
        assert words in err
        assert "Traceback" not in err


def test_serve_names_a_setting_that_is_misspelt(run, monkeypatch):
    monkeypatch.setenv("GRIDBLOOM_MAX_SESSION", "4")
    status, out, err = run("serve", "--port", 0)
    assert (status, out) == (2, "")
    assert "GRIDBLOOM_MAX_SESSION is no setting; GRIDBLOOM_MAX_SESSIONS is one." in " ".join(err.split())


def test_variables_that_tests_and_benchmarks_read_are_not_misspelt():
    files = [ROOT / "Makefile", ROOT / "static" / "vite.config.ts", *(ROOT / "tests").rglob("*.py")]
    texts = [file.read_text() for file in files if file != Path(__file__)]
    names = {name for text in texts for name in re.findall(r"\bGRIDBLOOM_[A-Z0-9_]*[A-Z0-9]\b", text)}
    assert len(names) > 20
    assert unknown_setting(names) is None


def test_serve_passes_its_options_to_the_service(run, tmp_path, monkeypatch):
    given: list[Settings] = []
    monkeypatch.setattr("server.cli.service.serve.run", given.append)
    monkeypatch.setenv("GRIDBLOOM_HOST", "::1")
    assert run("serve", "--port", 0, "--data-dir", tmp_path / "data", "--logs-dir", tmp_path).status == 0
    (settings,) = given
    assert (settings.host, settings.port, settings.data_dir, settings.logs_dir) == (
        "::1",
        0,
        tmp_path / "data",
        tmp_path,
    )


def test_help_imports_neither_numba_nor_the_web_server():
    program = (
        "import sys; sys.argv = ['gridbloom', '--help']\n"
        "from server.cli import main\n"
        "try: main()\n"
        "except SystemExit as ended: print(ended.code)\n"
        "print([name for name in ('numba', 'fastapi', 'viser', 'PIL', 'scipy', 'pydantic') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.endswith("0\n[]\n")
    assert "bench" in done.stdout


def test_the_help_of_serve_states_where_uploads_are_kept(run):
    out = run("serve", "--help").out
    assert "~/.local/share" in " ".join(out.split())
