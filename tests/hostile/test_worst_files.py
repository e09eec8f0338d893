"""The worst files of each kind, read by the command: each fails or is salvaged, and no file is left."""

from __future__ import annotations

import gzip
import sqlite3
import struct
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import httpx
import pytest
import zstandard

from server.process_folder import PREFIX
from tests.hostile import bombs
from tests.hostile.archives import tarred
from tests.hostile.corpus import TEXTS, bag_record, bag_with_chunk, images, mcap_with_chunk, recording
from tests.hostile.test_crash import files, served
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import SECOND, scan
from tests.server.service import once_read

T0 = 1_700_000_000 * SECOND
SIZE = 4 * bombs.GIB
CARMEN = TEXTS["carmen raw"].encode()


def cut(data: bytes, share: float = 0.5) -> bytes:
    return data[: int(share * len(data))]


def flipped(data: bytes, at: int) -> bytes:
    return data[:at] + bytes([data[at] ^ 4]) + data[at + 1 :]


def overwritten(data: bytes) -> bytes:
    at = 2 * len(data) // 3
    return data[:at] + b"\xff" * 40 + data[at + 40 :]


def endless_view() -> bytes:
    with closing(sqlite3.connect(":memory:")) as connection:
        connection.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format)")
        connection.execute(
            "CREATE VIEW messages AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) "
            "SELECT i AS id, 1 AS topic_id, i AS timestamp, x'' AS data FROM n"
        )
        connection.commit()
        return connection.serialize()


def absurd_names() -> bytes:
    return recorded.mcap_bytes([scan(T0, [1.0, 2.0], "/<script>\u202e\n../../etc", frame="f\0\r\n")])


#: The file's name, the file, and the code of its refusal, or what a note says of what was saved of it.
WORST: dict[str, tuple[Callable[[], bytes], str]] = {
    "../../../etc/passwd": (lambda: cut(recording("bag-none")), "The bag ends early"),
    "a\0b.bag": (lambda: cut(recording("bag-bz2")), "The bag ends early"),
    "<script>alert(1)</script>.mcap": (lambda: cut(recording("mcap-zstd"), 0.3), "The file ends early"),
    "\u202egol.3bd": (lambda: cut(recording("db3"), 0.9), "log.sqlite|ends early"),
    "n" * 900: (lambda: flipped(recording("mcap-none"), 6000), "checksum"),
    "bz2.bag": (lambda: bag_with_chunk("bz2", bombs.of_zeros("bz2", SIZE)), "log.too_many_bytes"),
    "lz4.bag": (lambda: bag_with_chunk("lz4", bombs.of_zeros("lz4", SIZE)), "log.too_many_bytes"),
    "zstd.mcap": (lambda: mcap_with_chunk("zstd", bombs.of_zeros("zstd", SIZE), 100), "log.too_many_bytes"),
    "zeros.bag.zst": (lambda: bombs.of_zeros("zstd", SIZE, b"#ROSBAG V2.0\n"), "log.no_scans"),
    "line.log.gz": (lambda: bombs.of_zeros("gzip", SIZE, CARMEN), "log.line_too_long"),
    "line.log.zst": (lambda: bombs.of_zeros("zstd", SIZE, CARMEN), "log.line_too_long"),
    "window.mcap": (lambda: mcap_with_chunk("zstd", b"\x28\xb5\x2f\xfd\0\xff\x01\0\0", 0), "log.no_scans"),
    "length.mcap": (lambda: b"\x89MCAP0\r\n" + struct.pack("<BQ", 6, 2**63) + b"abc", "log.no_scans"),
    "length.bag": (lambda: b"#ROSBAG V2.0\n" + b"\xff" * 4, "log.no_scans"),
    "records.bag": (lambda: b"#ROSBAG V2.0\n" + bag_record({"op": b"\x02"}, b"") * 50_000, "log.no_scans"),
    "view.db3": (endless_view, "log.unknown_format"),
    "names.mcap": (absurd_names, "no poses"),
    "cut.log": (lambda: CARMEN[:-20], "no line end|in the middle of line"),
    "cut.log.gz": (lambda: gzip.compress(CARMEN)[:-8], "The gzip data ends early"),
    "cut.log.zst": (lambda: cut(zstandard.compress(CARMEN)), "log.truncated"),
    "middle.log.gz": (lambda: overwritten(gzip.compress(CARMEN, mtime=0)), "The gzip data is damaged"),
    "folder.tar": (lambda: bytes(257) + b"ustar" + bytes(762) + CARMEN, "log.archive"),
    "way.tar": (lambda: tarred({"../../way.log": CARMEN, "/etc/passwd": b"root"}), "RLASER"),
    "cut.tar": (lambda: cut(tarred({"a.log": CARMEN}), 0.2), "The archive ends early"),
    "twice.gz.gz": (lambda: gzip.compress(gzip.compress(CARMEN)), "log.unknown_format"),
    "map.pgm": (lambda: images()["pgm"], "log.unknown_format"),
    "zeros": (lambda: bytes(1 << 20), "log.binary"),
}


@pytest.fixture(scope="module")
def process(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[httpx.Client, Path, Path]]:
    """One server process for all, its data folder, and the folder where it keeps what is temporary."""
    data, temporary = tmp_path_factory.mktemp("data"), tmp_path_factory.mktemp("temporary")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TMPDIR", str(temporary))
        with served(data) as (_, client):
            yield client, data, temporary


@pytest.fixture(autouse=True)
def nothing_before(process: tuple[httpx.Client, Path, Path]) -> None:
    """Remove what a failed case has left before the next one."""
    client, _, _ = process
    for log in client.get("/api/logs").json()["logs"]:
        client.delete(f"/api/logs/{log['id']}")


def alive(client: httpx.Client) -> bool:
    """Whether the service answers within a second; on a machine with other work to do it may be asked often."""
    for _ in range(60):
        try:
            return client.get("/livez", timeout=1.0).status_code == 200
        except httpx.TimeoutException:
            continue
    return False


@pytest.mark.parametrize("name", WORST, ids=lambda name: name[:30].encode("unicode_escape").decode())
def test_the_service_continues_and_no_files_are_left(process, name):
    client, data, temporary = process
    make, expected = WORST[name]
    answer = client.put("/api/logs", params={"name": name}, content=make())
    assert answer.status_code == 202, answer.text
    assert alive(client)
    there = f"/api/logs/{answer.json()['id']}"
    log = once_read(client, answer.json()["id"])
    assert log["name"].isprintable()
    assert alive(client)
    said = log["error"]["code"] if log["state"] == "failed" else " ".join(log["notes"])
    assert any(part in said for part in expected.split("|")), (log["state"], said, log["error"])
    if log["state"] == "ready":
        opened = client.post("/api/sessions", json={"kind": "log", "log": log["id"]})
        assert opened.status_code == 201, opened.text
        assert client.delete(f"/api/sessions/{opened.json()['id']}").status_code == 204
    else:
        assert log["error"]["message"].endswith(".")
        assert str(data) not in log["error"]["message"]
    assert client.delete(there).status_code == 204
    assert files(data) == {"blobs": 0, "packs": 0, "incoming": 0}
    left = [path for path in temporary.rglob("*") if not path.relative_to(temporary).parts[0].startswith(PREFIX)]
    assert left == [], "nothing but the sockets of the service"
    assert alive(client)
