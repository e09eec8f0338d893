"""The audit of dependencies: advisories that apply, such as do not, and none to be had."""

from __future__ import annotations

import json
import subprocess
import zipfile
from pathlib import Path
from typing import Any

import pytest

from tests import audit
from tests.audit import FOUND, NONE, UNKNOWN, against_files, against_registries, applies, locked, package_of

LOCK = {"packages": {"": {"version": "9.9.9"}, "node_modules/a/node_modules/@x/pad": {"version": "2.0.0-beta.2"}}}


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    for name, text in (
        ("dev", "Zope.Interface==1.4.2 \\\n    --hash=sha256:0\nuvicorn[standard]==0.30.0\n"),
        ("docs", ""),
    ):
        file = tmp_path / "requirements" / f"{name}.txt"
        file.parent.mkdir(exist_ok=True)
        file.write_text(text)
    (tmp_path / "static").mkdir()
    (tmp_path / "static" / "package-lock.json").write_text(json.dumps(LOCK))
    return tmp_path


def record(ecosystem: str, name: str, **affected: Any) -> dict[str, Any]:
    return {
        "id": "TEST-1",
        "summary": "bad",
        "affected": [{"package": {"ecosystem": ecosystem, "name": name}, **affected}],
    }


def within(*events: dict[str, str]) -> dict[str, Any]:
    return {"ranges": [{"type": "ECOSYSTEM", "events": list(events)}]}


def test_what_is_locked(checkout: Path) -> None:
    assert locked(checkout) == {
        ("PyPI", "zope-interface"): {"1.4.2"},
        ("PyPI", "uvicorn"): {"0.30.0"},
        ("npm", "@x/pad"): {"2.0.0-beta.2"},
    }
    own = locked(audit.ROOT)
    assert {("PyPI", "fastapi"), ("PyPI", "numpy"), ("npm", "typescript")} <= own.keys()


@pytest.mark.parametrize(
    ("version", "events", "expected"),
    [
        ("1.4.2", [{"introduced": "0"}, {"fixed": "1.4.3"}], True),
        ("1.4.2", [{"introduced": "0"}, {"fixed": "1.4.2"}], False),
        ("1.10.0", [{"introduced": "1.2"}, {"fixed": "1.9"}], False),  # by number, not by letter
        ("1.4.2", [{"introduced": "1.5"}], False),
        ("1.4.2", [{"introduced": "0"}, {"last_affected": "1.4.2"}], True),
        ("1.4.3", [{"introduced": "0"}, {"last_affected": "1.4.2"}], False),
        ("3.1", [{"introduced": "0"}, {"fixed": "2.0"}, {"introduced": "3.0"}, {"fixed": "3.2"}], True),
        ("2.5", [{"introduced": "0"}, {"fixed": "2.0"}, {"introduced": "3.0"}, {"fixed": "3.2"}], False),
        ("2.0rc1", [{"introduced": "0"}, {"fixed": "2.0"}], True),
    ],
)
def test_ranges(version: str, events: list[dict[str, str]], expected: bool) -> None:
    affected = record("PyPI", "A_B", **within(*events))["affected"][0]
    assert package_of(affected) == ("PyPI", "a-b")
    assert applies("PyPI", version, affected) is expected


@pytest.mark.parametrize(
    ("version", "fixed", "expected"),
    # The order of Semantic Versioning 2.0.0, section 11.
    [
        ("1.0.0-alpha", "1.0.0-alpha.1", True),
        ("1.0.0-alpha.beta", "1.0.0-alpha.1", False),
        ("1.0.0-beta.2", "1.0.0-beta.11", True),
        ("1.0.0-rc.1", "1.0.0", True),
        ("1.0.0+build.5", "1.0.0", False),
        ("1.10.0", "1.9.0", False),
    ],
)
def test_the_order_of_versions_of_npm(version: str, fixed: str, expected: bool) -> None:
    affected = record("npm", "pad", **within({"introduced": "0"}, {"fixed": fixed}))["affected"][0]
    assert applies("npm", version, affected) is expected


def test_stored_advisories(checkout: Path, capsys: pytest.CaptureFixture[str]) -> None:
    harmless = record("PyPI", "uvicorn", **within({"introduced": "0.31"}))
    withdrawn = record("PyPI", "uvicorn", versions=["0.30.0"]) | {"withdrawn": "2024-01-01T00:00:00Z"}
    of_another = record("npm", "uvicorn", versions=["0.30.0"])
    archive, single = checkout / "all.zip", checkout / "one.json"
    with zipfile.ZipFile(archive, "w") as file:
        for n, one in enumerate((harmless, withdrawn, of_another, {"id": "TEST-2"})):
            file.writestr(f"{n}.json", json.dumps(one))
    assert against_files([archive], checkout) == NONE
    assert "4 advisories, 3 packages, 0 that apply." in capsys.readouterr().out
    single.write_text(json.dumps(record("npm", "@x/pad", **within({"introduced": "1.0.0"}, {"fixed": "2.0.0"}))))
    assert against_files([archive, single], checkout) == FOUND
    assert "@x/pad 2.0.0-beta.2 (npm): TEST-1 bad" in capsys.readouterr().out


def test_without_advisories_nothing_is_called_well(
    checkout: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for text in ("[]", "{}", "no JSON"):
        (checkout / "none.json").write_text(text)
        assert against_files([checkout / "none.json"], checkout) == UNKNOWN
    assert against_files([checkout / "missing"], checkout) == UNKNOWN

    def answered(stdout: str, status: int) -> None:
        done = subprocess.CompletedProcess[str]([], status, stdout, "ConnectionError: no route\n")
        monkeypatch.setattr(subprocess, "run", lambda *_, **__: done)

    answered("", 1)
    assert against_registries(checkout) == UNKNOWN
    answered('{"message": "404 Not Found", "error": {}}', 1)  # a registry without the service
    assert against_registries(checkout) == UNKNOWN
    said = capsys.readouterr().out
    assert said.count("NO ADVISORIES COULD BE HAD") == 4
    answered('{"dependencies": [{"name": "a", "skip_reason": "not found"}], "vulnerabilities": {}}', 0)
    assert against_registries(checkout) == UNKNOWN
    assert "these packages: 1 of 1, a." in capsys.readouterr().out
    answered('{"dependencies": [], "vulnerabilities": {}}', 0)
    assert against_registries(checkout) == NONE
    answered('{"dependencies": [{"name": "a"}], "vulnerabilities": {"a": {}}}', 1)
    assert against_registries(checkout) == FOUND
