"""HAProxy with the configuration of ``deploy/`` in front of services of the tests; as a program, install HAProxy.

``make test`` runs the program before the tests: it prints the path of HAProxy, or one sentence on what to do. Then it
exits with 1 in CI, where the tests need it; elsewhere they are skipped.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from tests.programs import MissingProgramError, find_or_install

PURPOSE = "The tests of several services need HAProxy"
ADVICE = "install it (Debian, Ubuntu: apt-get install haproxy) or put it on the PATH"
CONFIGURATION = Path(__file__).parents[1] / "deploy" / "haproxy.cfg"
_SERVERS = re.compile(r"^ *server-template .*$", re.MULTILINE)


def haproxy() -> str:
    """Return the path of HAProxy; raise :class:`MissingProgramError` where there is none."""
    found = shutil.which("haproxy", path=f"{os.environ.get('PATH', '')}:/usr/sbin:/usr/local/sbin")
    if found is None:
        raise MissingProgramError(f"{PURPOSE}: {ADVICE}.")
    return found


@contextmanager
def running_haproxy(folder: Path, port: int, services: Sequence[int]) -> Iterator[str]:
    """Run HAProxy on a loopback port in front of services on loopback ports; yield its address.

    Raises :class:`MissingProgramError` where there is no HAProxy.
    """
    program = haproxy()
    servers = "".join(f"    server replica{n} 127.0.0.1:{one}\n" for n, one in enumerate(services))
    text, replaced = _SERVERS.subn(servers, CONFIGURATION.read_text())
    assert replaced == 1
    file = folder / "haproxy.cfg"
    file.write_text(text.replace(":${PORT}", "127.0.0.1:${PORT}"))
    environment = os.environ | {"PORT": str(port)}
    with (folder / "haproxy.log").open("wb") as output:
        process = subprocess.Popen(
            [program, "-W", "-f", file], env=environment, stdout=output, stderr=subprocess.STDOUT
        )
    try:
        yield f"http://127.0.0.1:{port}"
    finally:
        process.terminate()
        process.wait(60)


def main() -> int:
    """Print the path of HAProxy; install it first where it is missing."""
    return find_or_install(haproxy, ("haproxy",), PURPOSE, ADVICE)


if __name__ == "__main__":
    sys.exit(main())
