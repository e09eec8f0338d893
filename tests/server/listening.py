"""The TCP ports on which a process and its children listen (Linux)."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import pytest

LISTEN = "0A"


def listening_ports(pid: int) -> set[int]:
    """The ports of all listening TCP sockets, IPv4 and IPv6, of process ``pid`` and of its descendants."""
    if not Path("/proc/self/net/tcp").exists():
        pytest.skip("this system has no /proc/net/tcp")
    held = {name for one in _with_descendants(pid) for name in _open_files(one)}
    ports = set()
    for table in ("tcp", "tcp6"):
        path = Path(f"/proc/{pid}/net/{table}")
        for line in path.read_text().splitlines()[1:] if path.exists() else ():
            fields = line.split()
            if fields[3] == LISTEN and f"socket:[{fields[9]}]" in held:
                ports.add(int(fields[1].rpartition(":")[2], 16))
    return ports


def _with_descendants(pid: int) -> list[int]:
    found = [pid]
    for one in found:
        with suppress(FileNotFoundError, ProcessLookupError):  # the process has ended
            for children in Path(f"/proc/{one}/task").glob("*/children"):
                with suppress(FileNotFoundError, ProcessLookupError):  # the thread has ended
                    found += map(int, children.read_text().split())
    return found


def _open_files(pid: int) -> list[str]:
    names = []
    with suppress(FileNotFoundError, ProcessLookupError):  # the process has ended
        for link in Path(f"/proc/{pid}/fd").iterdir():
            with suppress(FileNotFoundError):  # the file is closed
                names.append(str(link.readlink()))
    return names
