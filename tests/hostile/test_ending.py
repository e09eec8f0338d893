"""The command ends on a signal whatever its visitors do, and states why it cannot start."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import socket
import sqlite3
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from server.library.store.database import Database
from server.storage import claimed
from tests.server.service import PATIENCE_S

ROOT = Path(__file__).parents[2]
NOBODY = 65_534  #: an account that owns nothing
#: It may not be allowed to read the interpreter, so the program is loaded before it becomes that account's.
SERVE_AS_NOBODY = f"""
import os, server.app, server.serving
from server.cli import main
os.setgroups([]), os.setgid({NOBODY}), os.setuid({NOBODY})
main()
"""
SERVE = [sys.executable, "-c", "from server.cli import main; main()", "serve", "--port", "0", "--data-dir"]

UPGRADE = (
    "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: gridbloom.v3\r\n"
    "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
)


def test_it_ends_in_good_order_whatever_visitors_are_in_the_middle_of(tmp_path: Path) -> None:
    process = subprocess.Popen(
        [*SERVE, str(tmp_path)], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    found = re.search(r":(\d+)/", process.stdout.readline())
    assert found
    port = int(found[1])
    open_connections = []

    def say(text: str, answer: str = "") -> str:
        connection = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S)
        open_connections.append(connection)
        connection.sendall(text.replace("{host}", f"127.0.0.1:{port}").encode())
        heard = ""
        while answer and not re.search(answer, heard):
            heard += connection.recv(65536).decode("latin-1")
        return heard

    try:
        body = '{"kind":"simulation","world":"room"}'
        began = say(
            "POST /api/sessions HTTP/1.1\r\nHost: {host}\r\nContent-Type: application/json\r\n"
            f"Content-Length: {len(body)}\r\n\r\n{body}",
            answer=r'"id":"[^"]+".*\}',
        )
        session_id = re.search(r'"id":"([^"]+)"', began)
        assert session_id
        stream = f"/api/sessions/{session_id[1]}/stream HTTP/1.1\r\nHost: {{host}}\r\n"
        say("GET " + stream + UPGRADE, answer='"type":"frame"')
        say("POST " + stream + UPGRADE)
        say("PUT /api/logs?name=half HTTP/1.1\r\nHost: {host}\r\nContent-Length: 1000000\r\n\r\nFLASER")
        say("POST /api/sessions HTTP/1.1\r\nHost: {host}\r\nContent-Length: 1000\r\n\r\n{")
        say("GET /liv")
        say("")
        say("GET /livez HTTP/1.1\r\nHost: {host}\r\n\r\n", answer="alive")
        process.send_signal(signal.SIGTERM)
        _, errors = process.communicate(timeout=PATIENCE_S)
    finally:
        process.kill()
        for connection in open_connections:
            connection.close()
    assert process.returncode == 0
    assert "Traceback" not in errors
    assert "session ended" in errors
    left = {path.name for path in tmp_path.rglob("*") if path.is_file()}
    assert left == {"identity", "library.db", "library.db-reserve"}


@pytest.mark.parametrize("folder", ["file/below", "file"])
def test_an_unusable_folder_gives_one_sentence(tmp_path: Path, folder: str) -> None:
    (tmp_path / "file").write_text("")
    done = subprocess.run(
        [*SERVE, str(tmp_path / folder)], cwd=ROOT, capture_output=True, text=True, timeout=PATIENCE_S, check=False
    )
    assert done.returncode == 1
    assert done.stdout == ""
    assert len(done.stderr.splitlines()) == 1
    assert done.stderr.startswith("gridbloom: cannot keep data in ")


def test_a_folder_in_use_by_another_service_gives_one_sentence(tmp_path: Path) -> None:
    with claimed(tmp_path):
        done = subprocess.run(
            [*SERVE, str(tmp_path)], cwd=ROOT, capture_output=True, text=True, timeout=PATIENCE_S, check=False
        )
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == (
        f"gridbloom: cannot keep data in {tmp_path}: another Gridbloom is using it. "
        "Choose another folder with --data-dir.\n"
    )


@pytest.fixture
def roots_folder() -> Iterator[Path]:
    """A folder of root that other accounts may enter, as they may not those of pytest."""
    if os.geteuid() != 0:
        pytest.skip("only root can begin a process of another account")
    with tempfile.TemporaryDirectory() as name:
        Path(name).chmod(0o755)
        yield Path(name)


def _closed(folder: Path) -> Path:
    folder.chmod(0o700)
    return folder


def _of_an_earlier_service(folder: Path) -> Path:
    (folder / "library").mkdir()
    Database.open(None, folder / "library").close()
    return folder


def _with_roots_records(folder: Path) -> Path:
    data = folder / "data"
    (data / "library").mkdir(parents=True)
    Database.open(None, data / "library").close()
    for one in (data, data / "library"):
        os.chown(one, NOBODY, NOBODY)
    for one in (data / "library").iterdir():
        one.chmod(0o600)
    return data


@pytest.mark.parametrize(
    ("make", "begins"),
    [
        (lambda folder: folder, "gridbloom: cannot keep data in "),
        (lambda folder: folder / "below", "gridbloom: cannot keep data in "),
        (_closed, "gridbloom: cannot keep data in "),
        (_of_an_earlier_service, "gridbloom: "),
        (_with_roots_records, "gridbloom: "),
    ],
    ids=["only to read", "below one only to read", "closed", "of an earlier service", "own, with root's records"],
)
def test_the_folder_of_another_account_gives_one_sentence(
    roots_folder: Path, make: Callable[[Path], Path], begins: str
) -> None:
    data = make(roots_folder)
    done = subprocess.run(
        [sys.executable, "-c", SERVE_AS_NOBODY, *SERVE[3:], str(data)], cwd=ROOT, capture_output=True, text=True,
        timeout=PATIENCE_S, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (1, "")
    assert len(done.stderr.splitlines()) == 1
    assert done.stderr.startswith(begins)
    assert str(data) in done.stderr


def test_unusable_records_give_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "library").mkdir()
    Database.open(None, tmp_path / "library").close()
    with contextlib.closing(sqlite3.connect(tmp_path / "library" / "library.db")) as connection, connection:
        connection.execute("UPDATE alembic_version SET version_num = '9999'")
    done = subprocess.run(
        [*SERVE, str(tmp_path)], cwd=ROOT, capture_output=True, text=True, timeout=PATIENCE_S, check=False
    )
    assert (done.returncode, done.stdout) == (1, "")
    assert len(done.stderr.splitlines()) == 1
    assert done.stderr.startswith("gridbloom: The records were written by a newer Gridbloom")
