"""``python -m tests.audit``: the locked dependencies of Python and of the pages against known advisories.

With a FILE these are records of OSV (https://osv.dev), as JSON or as the archive of an ecosystem
(https://osv-vulnerabilities.storage.googleapis.com/PyPI/all.zip, npm/all.zip); several files are read together. Without
one ``pip-audit`` and ``npm audit`` ask their registries. Exit status: 0 nothing was found, 1 advisories apply, 2 there
were no advisories to compare with.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import zipfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from packaging.utils import canonicalize_name
from packaging.version import InvalidVersion, Version

ROOT = Path(__file__).parent.parent
REQUIREMENTS = ("requirements/dev.txt", "requirements/docs.txt")
ASKED_S = 300.0  #: seconds that a registry has to answer
NONE, FOUND, UNKNOWN = 0, 1, 2  #: exit status
NO_ADVISORIES = "NO ADVISORIES COULD BE HAD, so nothing is known about these packages"

Package = tuple[str, str]  #: ecosystem as OSV names it, and the name


def locked(root: Path) -> dict[Package, set[str]]:
    """Return the versions of all packages that the lock files name."""
    out: dict[Package, set[str]] = {}
    for name in REQUIREMENTS:
        for package, version in re.findall(
            r"(?m)^([\w.-]+)(?:\[[^]]*\])?==([^\s;\\]+)", (root / name).read_text("utf-8")
        ):
            out.setdefault(("PyPI", canonicalize_name(package)), set()).add(version)
    packages = json.loads((root / "static" / "package-lock.json").read_text("utf-8"))["packages"]
    for path, one in packages.items():
        if path and "version" in one:
            out.setdefault(("npm", path.rpartition("node_modules/")[2]), set()).add(one["version"])
    return out


def records(path: Path) -> Iterator[dict[str, Any]]:
    """Yield the records of OSV in a file. Raises :class:`ValueError` for what is none, and :class:`OSError`."""
    if zipfile.is_zipfile(path):
        with zipfile.ZipFile(path) as archive:
            for name in archive.namelist():
                if name.endswith(".json"):
                    yield json.loads(archive.read(name))
        return
    found = json.loads(path.read_text("utf-8"))
    found = found.get("vulns", [found]) if isinstance(found, dict) else found
    if not isinstance(found, list) or not all(isinstance(one, dict) and "id" in one for one in found):
        raise ValueError("these are no records of OSV")
    yield from found


def _order(ecosystem: str, version: str) -> Any:
    if ecosystem == "PyPI":
        return Version(version)
    # Semantic Versioning 2.0.0, section 11: a pre-release comes before its release, numbers before words.
    release, _, rest = version.partition("+")[0].partition("-")
    before = [(0, int(one), "") if one.isdigit() else (1, 0, one) for one in rest.split(".")] if rest else [(2, 0, "")]
    return [int(one) for one in release.split(".")], before


def _is_within(ecosystem: str, version: str, events: Iterable[Mapping[str, str]]) -> bool:
    """Return whether a version is affected by a range of OSV: introduced, and neither fixed nor past the last one."""
    here, affected = _order(ecosystem, version), False
    for event in events:
        for what, at in event.items():
            where = None if at == "0" else _order(ecosystem, at)
            if what == "introduced" and (where is None or here >= where):
                affected = True
            elif (what == "fixed" and where is not None and here >= where) or (
                what == "last_affected" and where is not None and here > where
            ):
                affected = False
    return affected


def package_of(affected: Mapping[str, Any]) -> Package:
    """Return the package that an entry ``affected`` of a record is on."""
    named = affected.get("package") or {}
    ecosystem, name = str(named.get("ecosystem", "")), str(named.get("name", ""))
    return ecosystem, canonicalize_name(name) if ecosystem == "PyPI" else name


def applies(ecosystem: str, version: str, affected: Mapping[str, Any]) -> bool:
    """Return whether an entry on a package applies to a version of it; one that cannot be ordered is affected."""
    if version in affected.get("versions", ()):
        return True
    try:
        return any(
            _is_within(ecosystem, version, one["events"])
            for one in affected.get("ranges", ())
            if one.get("type") in ("ECOSYSTEM", "SEMVER")
        )
    except (InvalidVersion, ValueError):
        return True


def against_files(files: Sequence[Path], root: Path = ROOT) -> int:
    """Print the advisories of these files that apply to what is locked."""
    packages, count, found = locked(root), 0, set[str]()
    for file in files:
        try:
            for record in records(file):
                count += 1
                if record.get("withdrawn"):
                    continue
                for affected in record.get("affected") or ():
                    ecosystem, name = package = package_of(affected)
                    found |= {
                        f"{name} {version} ({ecosystem}): {record.get('id')} {record.get('summary', '')}".rstrip()
                        for version in packages.get(package, ())
                        if applies(ecosystem, version, affected)
                    }
        except (OSError, ValueError, KeyError) as error:
            print(f"{file}: no advisories: {error}")
            return UNKNOWN
    print("\n".join(sorted(found)))
    print(f"{count} advisories, {len(packages)} packages, {len(found)} that apply.")
    if not count:
        return UNKNOWN
    return FOUND if found else NONE


def _ask(title: str, command: Sequence[str], folder: Path, answer: str) -> int:
    """Run an auditor, which answers with a JSON object that has the key ``answer``, and print what it says."""
    try:
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=ASKED_S, check=False)
    except (OSError, subprocess.TimeoutExpired) as error:
        print(f"{title}: {NO_ADVISORIES} ({error}).")
        return UNKNOWN
    try:
        said = json.loads(done.stdout)
    except ValueError:
        said = None
    if not (isinstance(said, dict) and answer in said):
        reasons = (done.stderr.strip() or done.stdout.strip()).splitlines() or ["no answer"]
        print(f"{title}: {NO_ADVISORIES} ({reasons[-1][:200]}).")
        return UNKNOWN
    # pip-audit calls it well where it knows nothing of a package.
    entries = said[answer] if isinstance(said[answer], list) else []
    skipped = [str(one.get("name")) for one in entries if "skip_reason" in one]
    if skipped and done.returncode == 0:
        print(f"{title}: {NO_ADVISORIES}: {len(skipped)} of {len(entries)}, {', '.join(skipped)}.")
        return UNKNOWN
    print(f"{title}: {'nothing was found' if done.returncode == 0 else done.stdout}")
    return NONE if done.returncode == 0 else FOUND


def against_registries(root: Path = ROOT) -> int:
    """Have ``pip-audit`` and ``npm audit`` ask, and print what they say."""
    python = [sys.executable, "-m", "pip_audit", "--format", "json", "--disable-pip", "--progress-spinner", "off"]
    files = [part for name in REQUIREMENTS for part in ("--requirement", str(root / name))]
    npm = [sys.executable, str(root / "static" / "build_pages.py"), "audit", "--json", "--package-lock-only"]
    found = {
        _ask("Python", [*python, *files], root, "dependencies"),
        _ask("the pages", npm, root / "static", "vulnerabilities"),
    }
    return FOUND if FOUND in found else UNKNOWN if UNKNOWN in found else NONE


if __name__ == "__main__":
    given = [Path(one) for one in sys.argv[1:]]
    sys.exit(against_files(given) if given else against_registries())
