"""The lock of Python packages: all of pyproject.toml's, each with hashes, for every Python, without addresses."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
RUNTIME = PROJECT["project"]["dependencies"]
EXTRAS = [entry for extra in PROJECT["project"]["optional-dependencies"].values() for entry in extra]
BUILD = PROJECT["build-system"]["requires"] + PROJECT["dependency-groups"]["build"]
DOCS = PROJECT["dependency-groups"]["docs"]
LOCKED = {"runtime": RUNTIME, "build": BUILD, "dev": [*RUNTIME, *EXTRAS, *BUILD], "docs": DOCS}
PYTHONS = ("3.11", "3.12", "3.13")


def pins(name: str) -> list[tuple[Requirement, list[str]]]:
    """Every requirement of a lock file with its hashes."""
    text = re.sub(r"^\s*#.*\n", "", (ROOT / "requirements" / f"{name}.txt").read_text(), flags=re.MULTILINE)
    entries = [line.split("--hash=") for line in text.replace("\\\n", " ").splitlines()]
    return [(Requirement(entry), [one.strip() for one in hashes]) for entry, *hashes in entries]


def versions(name: str, python: str) -> dict[str, str]:
    """The versions that a lock file gives a Python on Linux."""
    machine = {"python_version": python, "python_full_version": f"{python}.0", "sys_platform": "linux"}
    found = [pin for pin, _ in pins(name) if pin.marker is None or pin.marker.evaluate(machine)]
    chosen = {str(canonicalize_name(pin.name)): str(pin.specifier).removeprefix("==") for pin in found}
    assert len(chosen) == len(found), "a package has two versions"
    return chosen


@pytest.mark.parametrize("python", PYTHONS)
@pytest.mark.parametrize("name", LOCKED)
def test_every_dependency_is_locked(name: str, python: str) -> None:
    locked = versions(name, python)
    for wanted in map(Requirement, LOCKED[name]):
        assert locked[canonicalize_name(wanted.name)] in wanted.specifier, f"{wanted}: run make lock"


@pytest.mark.parametrize("name", ["runtime", "build"])
def test_all_files_have_the_versions_that_are_tested(name: str) -> None:
    for python in PYTHONS:
        assert versions(name, python).items() <= versions("dev", python).items()


@pytest.mark.parametrize("python", PYTHONS)
def test_the_documentation_requirements_do_not_change_versions(python: str) -> None:
    """Both files are installed into one environment."""
    tested = versions("dev", python)
    assert {
        name: version for name, version in versions("docs", python).items() if tested.get(name, version) != version
    } == {}


@pytest.mark.parametrize("name", LOCKED)
def test_every_package_has_one_version_and_hashes(name: str) -> None:
    for pin, hashes in pins(name):
        assert re.fullmatch(r"==[^,*]+", str(pin.specifier)), pin
        assert pin.url is None, pin
        assert hashes, pin
        assert all(re.fullmatch(r"sha256:[0-9a-f]{64}", one) for one in hashes), pin


@pytest.mark.parametrize("name", LOCKED)
def test_no_registry_is_named(name: str) -> None:
    text = (ROOT / "requirements" / f"{name}.txt").read_text()
    assert "://" not in text
    assert not re.search(r"^-", text, flags=re.MULTILINE), "an option, as --index-url, names where packages come from"
