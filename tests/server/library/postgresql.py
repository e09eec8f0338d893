"""A private PostgreSQL server for the tests; as a program, install PostgreSQL where that is possible.

The server's files and its Unix socket lie in a temporary folder, and it listens on no port. ``make test`` runs the
program before the tests: it prints the folder of PostgreSQL's programs, or one sentence on what to do. Then it exits
with 1 in CI, where the tests need PostgreSQL; elsewhere they are skipped.
"""

from __future__ import annotations

import os
import pwd
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tests.programs import MissingProgramError, find_or_install

PURPOSE = "The tests of records in PostgreSQL need its server"
ADVICE = "install it (Debian, Ubuntu: apt-get install postgresql) or put its programs on the PATH"
#: Where distributions keep the programs that they do not put on the PATH.
FOLDERS = ("/usr/lib/postgresql/*/bin", "/usr/pgsql-*/bin", "/opt/homebrew/opt/postgresql*/bin")


def programs() -> Path:
    """Return the folder with ``initdb`` and ``postgres``; raise :class:`MissingProgramError` where there is none."""
    on_path = shutil.which("initdb")
    found = [Path(on_path).parent] if on_path else []
    for pattern in FOLDERS:
        found += sorted(Path("/").glob(pattern[1:]), reverse=True)
    for folder in found:
        if all(os.access(folder / name, os.X_OK) for name in ("initdb", "postgres", "pg_isready", "createdb")):
            return folder
    raise MissingProgramError(f"{PURPOSE}: {ADVICE}.")


class Cluster:
    """A running PostgreSQL server with a superuser named ``tests``, who needs no password."""

    def __init__(self, folder: Path, bin_dir: Path, as_user: dict[str, Any]) -> None:
        self._folder = folder
        self._bin_dir = bin_dir
        self._as_user = as_user
        self._databases = 0

    def new_database(self) -> str:
        """Create an empty database; return its URL."""
        self._databases += 1
        name = f"tests_{self._databases}"
        command: list[str | Path] = [self._bin_dir / "createdb", "--host", self._folder, "--username", "tests", name]
        subprocess.run(command, check=True, **self._as_user)
        return f"postgresql://tests@/{name}?host={self._folder}"


@contextmanager
def running_postgresql() -> Iterator[Cluster]:
    """Run a private server until the block ends. Raises :class:`MissingProgramError` where there is no PostgreSQL."""
    bin_dir = programs()
    # Not below pytest's folder: another user cannot read that, and the path of a Unix socket has at most 107 bytes.
    with tempfile.TemporaryDirectory(prefix="gridbloom-pg-") as named:
        folder = Path(named)
        as_user: dict[str, Any] = {"cwd": folder}
        if os.geteuid() == 0:  # PostgreSQL refuses to run as root
            user = _unprivileged_user()
            os.chown(folder, user.pw_uid, user.pw_gid)
            as_user |= {"user": user.pw_uid, "group": user.pw_gid, "extra_groups": []}
        data = folder / "data"
        subprocess.run(
            [bin_dir / "initdb", "--no-sync", "--auth=trust", "--username=tests", "--encoding=UTF8", "--no-locale",
             "--pgdata", data],
            check=True, capture_output=True, **as_user,
        )  # fmt: skip
        log = folder / "server.log"
        with log.open("wb") as output:
            server = subprocess.Popen(
                [bin_dir / "postgres", "-D", data, "-k", folder, "-c", "listen_addresses=", "-c", "fsync=off"],
                stdout=output, stderr=subprocess.STDOUT, **as_user,
            )  # fmt: skip
        try:
            ready: list[str | Path] = [bin_dir / "pg_isready", "--quiet", "--host", folder]
            while subprocess.run(ready, check=False, **as_user).returncode != 0:
                assert server.poll() is None, log.read_text()
                time.sleep(0.05)
            yield Cluster(folder, bin_dir, as_user)
        finally:
            server.send_signal(signal.SIGINT)  # which ends its clients' connections
            try:
                server.wait(180)
            except subprocess.TimeoutExpired:
                server.kill()
                server.wait()


def _unprivileged_user() -> pwd.struct_passwd:
    for name in ("postgres", "nobody"):
        try:
            return pwd.getpwnam(name)
        except KeyError:
            continue
    raise MissingProgramError(f"{PURPOSE}, which does not run as root, and there is no user postgres or nobody.")


def main() -> int:
    """Print the folder of PostgreSQL's programs; install them first where they are missing."""
    return find_or_install(programs, ("postgresql",), PURPOSE, ADVICE)


if __name__ == "__main__":
    sys.exit(main())
