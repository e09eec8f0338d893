"""Bags and MCAP files that are cut, flipped, lying or meant to harm: a log, or one of our own errors, in little memory.

Each format meets 10,000 damaged files with ``GRIDBLOOM_FUZZ=10000 pytest tests/hostile/test_recordings.py``; without
it, a seeded part of them, and not every prefix.
"""

from __future__ import annotations

import bz2
import contextlib
import gzip
import os
import sqlite3
import struct
import tracemalloc
import zlib
from dataclasses import replace
from functools import cache
from pathlib import Path

import lz4.frame
import numpy as np
import pytest
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.records import Channel, Chunk, Schema

from mapper.errors import LimitError, MapperError, ReadError
from mapper.limits import DEFAULT_LIMITS, Limits
from mapper.logs import open_log
from mapper.scan import ScanLog
from tests.mapper.logs import recorded
from tests.mapper.logs.recorded import SECOND, odometry, scan, sonar, transform

pytestmark = pytest.mark.timeout(1200)
ROUNDS = int(os.environ.get("GRIDBLOOM_FUZZ", "400"))
ALL = "GRIDBLOOM_FUZZ" in os.environ
T0 = 1_700_000_000 * SECOND


def said(n: int = 6) -> list[recorded.Said]:
    """A bit of everything that is decoded."""
    messages = [transform(T0, "base_link", "laser", 0.2, topic="/tf_static")]
    for i in range(n):
        at = T0 + i * SECOND // 10
        messages += [
            transform(at, "odom", "base_link", i / 10),
            odometry(at, i / 10, 0.0, 0.0),
            scan(at, [1.0, 2.0, 3.0]),
            recorded.echoes(at, [[1.0], [], [2.0, 3.0]]),
            sonar(at, 1.0),
        ]
    return messages


@cache
def good(kind: str) -> bytes:
    """A small whole file of each kind."""
    import tempfile

    if kind.startswith("mcap"):
        _, compression, *flat = kind.split("-")
        return recorded.mcap_bytes(said(), compression, use_chunking=not flat, chunk_size=800)
    with tempfile.TemporaryDirectory() as folder:
        if kind == "db3":
            return recorded.written(Path(folder), said(), "db3").read_bytes()
        return recorded.write_bag(Path(folder) / "a.bag", said(), kind.split("-")[1]).read_bytes()


BAGS = ("bag-none", "bag-bz2", "bag-lz4")
MCAPS = ("mcap-none", "mcap-none-flat", "mcap-lz4", "mcap-zstd")


def opened(folder: Path, data: bytes, limits: Limits = DEFAULT_LIMITS) -> ScanLog | MapperError:
    """The log, or the error in one sentence; anything else is a defect."""
    path = folder / "fuzz.log"
    path.write_bytes(data)
    refusal = None
    try:
        log = open_log(path, limits=limits)
    except MapperError as error:
        refusal = error
    if refusal is not None:
        assert isinstance(refusal, ReadError | LimitError), refusal
        assert refusal.code.startswith("log.")
        assert refusal.message.endswith(".")
        assert len(refusal.message) < 1500
        assert str(folder) not in refusal.message
        return refusal
    assert log.n_scans >= 1
    assert not np.any(log.ranges <= 0.0)
    assert all(np.isfinite(trajectory.poses).all() for trajectory in log.trajectories.values())
    return log


@pytest.mark.parametrize("kind", [*BAGS, *MCAPS])
def test_of_every_prefix_what_is_whole_is_there_and_marked_or_it_is_refused(tmp_path, kind):
    data = good(kind)
    whole = opened(tmp_path, data)
    assert isinstance(whole, ScanLog)
    assert whole.notes == ()
    scans = 0
    for n in range(0, len(data), 1 if ALL else 41):
        log = opened(tmp_path, data[:n])
        if isinstance(log, ReadError):
            assert scans == 0, f"{n} bytes give nothing, but fewer gave {scans} scans"
            continue
        assert isinstance(log, ScanLog)
        assert log.n_scans >= scans, "more bytes never give less"
        scans = log.n_scans
        np.testing.assert_array_equal(log.ranges, whole.ranges[:scans])
        # After the last message there is only the index, which nobody misses.
        assert log.notes or scans == whole.n_scans, f"{n} bytes are not marked as cut"
    assert scans == whole.n_scans


def test_of_every_prefix_of_a_db3_what_is_whole_is_there_or_it_is_refused(tmp_path):
    data = good("db3")
    whole = opened(tmp_path, data)
    assert isinstance(whole, ScanLog)
    salvaged = 0
    for n in range(0, len(data), max(1, len(data) // (3000 if ALL else 100))):
        log = opened(tmp_path, data[:n])
        if not isinstance(log, ScanLog):
            continue
        assert any("ends early" in note or "damaged" in note for note in log.notes)
        with contextlib.suppress(ReadError):  # SQLite may lose rows in the middle: of a sensor, perhaps all
            scans = open_log(tmp_path / "fuzz.log", topic="/scan")
            assert scans.n_scans <= whole.n_scans
            np.testing.assert_array_equal(scans.ranges, whole.ranges[: scans.n_scans])
            salvaged = max(salvaged, scans.n_scans)
    assert salvaged > 0


@pytest.mark.parametrize("pack", [gzip.compress, zstandard.compress], ids=["gzip", "zstd"])
@pytest.mark.parametrize("kind", ["bag-none", "mcap-none"])
def test_a_compressed_file_that_is_cut_keeps_what_came_before(tmp_path, kind, pack):
    # Noise does not compress, so that a cut leaves some of it.
    noise = np.random.default_rng(1).uniform(1, 9, (4000, 50))
    messages = [scan(T0 + i, row) for i, row in enumerate(noise)]
    path = tmp_path / "a.bag"
    plain = (
        recorded.write_bag(path, messages).read_bytes()
        if kind == "bag-none"
        else recorded.mcap_bytes(messages, "none", chunk_size=3000)
    )
    packed = pack(plain)
    log = opened(tmp_path, packed[: len(packed) // 2])
    assert isinstance(log, ScanLog)
    assert 500 < log.n_scans < 3500
    assert any("ends early" in note for note in log.notes)


@pytest.mark.parametrize("kind", [*BAGS, *MCAPS, "db3"])
def test_flipped_bits_give_a_log_or_an_error_of_ours(tmp_path, kind):
    data = good(kind)
    family = [one for one in (*BAGS, *MCAPS, "db3") if one[:3] == kind[:3]]
    rng = np.random.default_rng(sum(map(ord, kind)))
    logs = 0
    for _ in range(-(-ROUNDS // len(family))):
        damaged = bytearray(data)
        for _ in range(int(rng.integers(1, 5))):
            at = int(rng.integers(0, len(data)))
            damaged[at] = (
                int(rng.integers(0, 256)) if rng.random() < 0.5 else damaged[at] ^ (1 << int(rng.integers(0, 8)))
            )
        logs += isinstance(opened(tmp_path, bytes(damaged)), ScanLog)
    assert logs > 0


@pytest.mark.parametrize("kind", [*BAGS, *MCAPS, "db3"])
def test_a_length_of_four_billion_anywhere(tmp_path, kind):
    data = good(kind)
    places = range(0, len(data) - 4, 1 if ALL else max(1, len(data) // 100))
    for at in places:
        opened(tmp_path, data[:at] + b"\xff\xff\xff\xff" + data[at + 4 :])


@pytest.fixture
def peak_memory():
    """A function that tells how many bytes Python has held at most since the test began."""
    tracemalloc.start()
    yield lambda: tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()


def ended(builder: RecordBuilder) -> bytes:
    return bytes(builder.end())  # type: ignore[no-untyped-call]


def bag_record(fields: dict[str, bytes], data: bytes) -> bytes:
    header = b"".join(struct.pack("<I", len(n) + 1 + len(v)) + n.encode() + b"=" + v for n, v in fields.items())
    return struct.pack("<I", len(header)) + header + struct.pack("<I", len(data)) + data


def bag_with_chunk(compression: str, data: bytes) -> bytes:
    chunk = bag_record({"op": b"\x05", "compression": compression.encode(), "size": b"\xff\xff\xff\xff"}, data)
    return b"#ROSBAG V2.0\n" + chunk


def mcap_with_chunk(compression: str, data: bytes, size: int, crc: int = 0) -> bytes:
    builder = RecordBuilder()
    Chunk(
        compression=compression,
        data=data,
        message_end_time=0,
        message_start_time=0,
        uncompressed_crc=crc,
        uncompressed_size=size,
    ).write(builder)
    return b"\x89MCAP0\r\n" + ended(builder)


ZEROS = bytes(1 << 20)


def bomb(kind: str, megabytes: int) -> bytes:
    """Zeros, compressed."""
    if kind == "zstd":
        packer = zstandard.ZstdCompressor(write_content_size=True).compressobj(size=megabytes << 20)
    elif kind == "zstd, no size":
        packer = zstandard.ZstdCompressor().compressobj()
    elif kind == "bz2":
        packer = bz2.BZ2Compressor()  # type: ignore[assignment]
    elif kind == "lz4":
        compressor = lz4.frame.LZ4FrameCompressor()
        return b"".join(
            [compressor.begin(), *(compressor.compress(ZEROS) for _ in range(megabytes)), compressor.flush()]
        )
    else:
        packer = zlib.compressobj(9, wbits=31)  # type: ignore[assignment]
    return b"".join(packer.compress(ZEROS) for _ in range(megabytes)) + packer.flush()


@pytest.mark.parametrize(
    ("kind", "wrap"),
    [
        ("bz2", lambda data: bag_with_chunk("bz2", data)),
        ("lz4", lambda data: bag_with_chunk("lz4", data)),
        ("lz4", lambda data: mcap_with_chunk("lz4", data, 100)),
        ("zstd", lambda data: mcap_with_chunk("zstd", data, 100)),
        ("zstd", lambda data: mcap_with_chunk("zstd", data, 4 << 30)),
        ("zstd, no size", lambda data: mcap_with_chunk("zstd", data, 2**64 - 1)),
    ],
    ids=["bag bz2", "bag lz4", "mcap lz4", "mcap zstd", "mcap zstd, 4 GiB stated", "mcap zstd, no size"],
)
def test_a_chunk_that_expands_without_end_is_refused_in_little_memory(tmp_path, peak_memory, kind, wrap):
    limits = replace(DEFAULT_LIMITS, max_chunk_bytes=8 << 20)
    data = wrap(bomb(kind, 64))
    tracemalloc.reset_peak()
    error = opened(tmp_path, data, limits)
    assert peak_memory() < 40 << 20
    assert isinstance(error, LimitError)
    assert error.code == "log.too_many_bytes"
    assert "expands to more than" in error.message


@pytest.mark.skipif(not ALL, reason="takes a minute; GRIDBLOOM_FUZZ is not set")
@pytest.mark.parametrize("kind", ["bz2", "lz4", "zstd", "gzip"])
@pytest.mark.timeout(600)
def test_four_gibibytes_with_the_limits_as_they_are(tmp_path, kind):
    data = bomb(kind, 4096)
    if kind == "zstd":
        data = mcap_with_chunk(kind, data, 4 << 30)
    elif kind != "gzip":
        data = bag_with_chunk(kind, data)
    else:
        data = gzip.compress(b"#ROSBAG V2.0\n") + data
    error = opened(tmp_path, data)
    assert isinstance(error, MapperError)


@pytest.mark.parametrize("kind", ["gzip", "zstd"])
def test_a_whole_file_that_expands_without_end(tmp_path, peak_memory, kind):
    limits = replace(DEFAULT_LIMITS, max_log_bytes=8 << 20, max_chunk_bytes=2 << 20)
    # Records that nobody reads, so that none of them is too large.
    record = bag_record({"op": b"\x09"}, bytes(1000))
    plain = b"#ROSBAG V2.0\n" + record * ((32 << 20) // len(record))
    data = gzip.compress(plain) if kind == "gzip" else bytes(bytearray(zstandard.compress(plain)))  # not its buffer
    del plain
    tracemalloc.reset_peak()
    error = opened(tmp_path, data, limits)
    assert peak_memory() < 20 << 20
    assert isinstance(error, LimitError)
    assert error.code == "log.too_many_bytes"


def test_a_compressed_sqlite_file_that_expands_without_end(tmp_path, peak_memory):
    limits = replace(DEFAULT_LIMITS, max_log_bytes=8 << 20)
    data = gzip.compress(b"SQLite format 3\0") + bomb("gzip", 64)
    tracemalloc.reset_peak()
    error = opened(tmp_path, data, limits)
    assert peak_memory() < 40 << 20
    assert isinstance(error, LimitError)


def test_a_zstd_window_of_terabytes_is_refused(tmp_path):
    # A frame header that asks for the largest window there is, then a raw block.
    frame = b"\x28\xb5\x2f\xfd" + bytes([0x00, 0xFF]) + b"\x01\0\0"
    error = opened(tmp_path, mcap_with_chunk("zstd", frame, 0))
    assert isinstance(error, ReadError)
    assert isinstance(opened(tmp_path, frame), ReadError)


def test_an_mcap_with_wrong_checksums_leaves_the_damaged_chunks_out(tmp_path):
    data = recorded.mcap_bytes(said(), "none", chunk_size=800)
    whole = opened(tmp_path, data)
    at = data.rindex(struct.pack("<3f", 1, 2, 3)) + 1
    broken = opened(tmp_path, data[:at] + bytes([data[at] ^ 4]) + data[at + 1 :])
    assert isinstance(whole, ScanLog)
    assert isinstance(broken, ScanLog)
    assert broken.n_scans < whole.n_scans
    assert any("has not the checksum" in note for note in broken.notes)
    # The first chunk is where the channels are announced; the file's end repeats them.
    at = data.index(struct.pack("<3f", 1, 2, 3)) + 1
    broken = opened(tmp_path, data[:at] + bytes([data[at] ^ 4]) + data[at + 1 :])
    assert isinstance(broken, ScanLog)
    assert 0 < open_log(tmp_path / "fuzz.log", topic="/scan").n_scans < whole.n_scans
    single = recorded.mcap_bytes([scan(T0, [1.0, 2.0, 3.0])], "none")
    at = single.index(struct.pack("<3f", 1, 2, 3)) + 1
    error = opened(tmp_path, single[:at] + bytes([single[at] ^ 4]) + single[at + 1 :])
    assert isinstance(error, ReadError)


def test_an_mcap_whose_data_has_another_checksum_is_marked(tmp_path):
    data = recorded.mcap_bytes(said(), "none", use_chunking=False, enable_data_crcs=True)
    at = data.index(struct.pack("<3f", 1, 2, 3)) + 1
    log = opened(tmp_path, data[:at] + bytes([data[at] ^ 4]) + data[at + 1 :])
    assert isinstance(log, ScanLog)
    assert any("checksum" in note for note in log.notes)


DEFINITIONS = {
    "a definition that redefines LaserScan": "float64 ranges\nstring[1000000] x",
    "one that refers to itself": "sensor_msgs/LaserScan a\n===\nMSG: sensor_msgs/LaserScan\nsensor_msgs/LaserScan a",
    "an array of a million strings": "string[1000000] x",
    "no definition": "",
    "garbage": "\0\xff" * 100,
    "100,000 fields": "\n".join(f"int8 a{i}" for i in range(100_000)),
}


@pytest.mark.parametrize("case", DEFINITIONS)
def test_message_definitions_in_the_file_are_not_read(tmp_path, case):
    builder = RecordBuilder()
    Schema(
        id=1, name="sensor_msgs/msg/LaserScan", encoding="ros2msg", data=DEFINITIONS[case].encode("utf-8", "replace")
    ).write(builder)
    Channel(id=1, topic="/scan", message_encoding="cdr", metadata={}, schema_id=1).write(builder)
    message = struct.pack("<HIQQ", 1, 0, T0, T0) + recorded.serialised(scan(T0, [1.0, 2.0]), 2)
    records = ended(builder) + struct.pack("<BQ", 5, len(message)) + message
    log = opened(tmp_path, b"\x89MCAP0\r\n" + records)
    assert isinstance(log, ScanLog)
    np.testing.assert_array_equal(log.ranges, [[1.0, 2.0]])

    connection = bag_record(
        {"op": b"\x07", "conn": bytes(4), "topic": b"/scan"},
        b"".join(
            struct.pack("<I", len(n) + 1 + len(v)) + n + b"=" + v
            for n, v in {
                b"type": b"sensor_msgs/LaserScan",
                b"message_definition": DEFINITIONS[case].encode("utf-8", "replace"),
            }.items()
        ),
    )
    content = recorded.serialised(scan(T0, [1.0, 2.0]), 1)
    bag = b"#ROSBAG V2.0\n" + connection + bag_record({"op": b"\x02", "conn": bytes(4), "time": bytes(8)}, content)
    log = opened(tmp_path, bag)
    assert isinstance(log, ScanLog)
    np.testing.assert_array_equal(log.ranges, [[1.0, 2.0]])


def lying(**changes: object) -> recorded.Said:
    one = scan(T0, [1.0, 2.0])
    one.fields |= changes
    return one


@pytest.mark.parametrize(
    "message",
    [
        lying(angle_min=float("nan")),
        lying(angle_increment=float("inf")),
        lying(range_max=float("nan")),
        lying(range_max=-1.0),
        lying(ranges=np.zeros(0, dtype=np.float32)),
    ],
    ids=["nan angle", "infinite step", "nan limit", "negative limit", "no beams"],
)
def test_a_scan_that_cannot_be_is_left_out_and_counted(tmp_path, message):
    data = recorded.mcap_bytes([scan(T0, [1.0, 2.0]), message])
    log = opened(tmp_path, data)
    assert isinstance(log, ScanLog)
    assert log.n_scans == 1
    assert any("1 of 2 on /scan" in note for note in log.notes)


def test_poses_that_are_no_places_are_left_out(tmp_path):
    nowhere = [odometry(T0 + i, x, 0.0, 0.0) for i, x in enumerate([float("nan"), float("inf"), 1e300, 5.0])]
    unturned = odometry(T0, 1.0, 0.0, 0.0)
    unturned.fields["pose"]["pose"]["orientation"] = dict.fromkeys("xyzw", 0.0)
    log = opened(tmp_path, recorded.mcap_bytes([*nowhere, unturned, scan(T0, [1.0])]))
    assert isinstance(log, ScanLog)
    assert log.trajectory("odom").poses.tolist() == [[5.0, 0.0, 0.0]]
    assert any("4 of 5 on /odom" in note for note in log.notes)


def test_frames_that_go_round_in_a_circle(tmp_path):
    circle = [transform(T0 + i, f"f{(i + 1) % 5}", f"f{i}", 0.1 * i) for i in range(5)]
    log = opened(tmp_path, recorded.mcap_bytes([*circle, scan(T0, [1.0], frame="f0"), transform(T0, "f0", "f0")]))
    assert isinstance(log, ScanLog)


@pytest.mark.parametrize(
    ("change", "code"),
    [
        ({"max_messages": 8}, "log.too_many_messages"),
        ({"max_topics": 2}, "log.too_many_topics"),
        ({"max_scans": 5}, "log.too_many_scans"),
        ({"max_readings": 20}, "log.too_many_scans"),
        ({"max_beams": 2}, "log.too_many_beams"),
        ({"max_log_bytes": 2000}, "log.too_many_bytes"),
        ({"max_chunk_bytes": 300}, "log.t"),
    ],
)
@pytest.mark.parametrize("kind", ["bag-none", "mcap-zstd", "db3"])
def test_the_limits_hold(tmp_path, kind, change, code):
    if kind == "db3" and "max_chunk_bytes" in change:
        pytest.skip("SQLite's own limit, as an SQLite error")
    limits = replace(DEFAULT_LIMITS, **change)
    error = opened(tmp_path, good(kind), limits)
    assert isinstance(error, LimitError), error
    assert error.code.startswith(code) or error.code == "log.chunk_too_large"


def test_a_bag_of_another_version_and_one_that_is_encrypted(tmp_path):
    old = opened(tmp_path, b"#ROSBAG V1.2\n" + bytes(100))
    assert isinstance(old, ReadError)
    assert old.code == "log.version"
    locked = opened(tmp_path, b"#ROSBAG V2.0\n" + bag_record({"op": b"\x03", "encryptor": b"aes"}, b""))
    assert isinstance(locked, ReadError)
    assert locked.code == "log.encrypted"


def sqlite_file(folder: Path, *statements: str) -> bytes:
    path = folder / "made.db3"
    path.unlink(missing_ok=True)
    with contextlib.closing(sqlite3.connect(path)) as connection:
        for statement in statements:
            connection.execute(statement)
        connection.commit()
    return path.read_bytes()


TOPICS = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT)"
ENDLESS = (
    "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) "
    "SELECT i AS id, 1 AS topic_id, i AS timestamp, x'' AS data FROM n"
)


@pytest.mark.parametrize(
    "statements",
    [
        (TOPICS, f"CREATE VIEW messages AS {ENDLESS}"),
        (
            TOPICS,
            "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INT, timestamp INT, data AS (zeroblob(1e9)))",
        ),
        (TOPICS, "CREATE TABLE messages(rowid TEXT, topic_id INT, timestamp INT, data BLOB)"),
        (TOPICS, "CREATE TABLE messages(id INT, topic_id INT, timestamp INT)"),
        (TOPICS, "CREATE VIRTUAL TABLE messages USING fts5(topic_id, timestamp, data)"),
        (TOPICS,),
        ("CREATE TABLE something(x)",),
    ],
    ids=[
        "endless view",
        "computed column",
        "rowid of another kind",
        "no data",
        "virtual table",
        "no messages",
        "other",
    ],
)
def test_an_sqlite_file_that_is_no_bag(tmp_path, statements):
    try:
        data = sqlite_file(tmp_path, *statements)
    except sqlite3.OperationalError as without:
        pytest.skip(f"this SQLite cannot make it: {without}")
    error = opened(tmp_path, data)
    assert isinstance(error, ReadError)
    assert error.code == "log.unknown_format"


def test_an_sqlite_file_with_values_of_other_kinds(tmp_path):
    data = sqlite_file(
        tmp_path,
        TOPICS,
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data)",
        "INSERT INTO topics VALUES (1, x'ff00', 5, NULL), (2, '/scan', 'sensor_msgs/msg/LaserScan', 'cdr')",
        "INSERT INTO messages VALUES (1, 'x', 2, x''), (2, 2, 'now', 'text'), (3, 2, 1, 5.5), (4, NULL, NULL, NULL)",
    )
    error = opened(tmp_path, data)
    assert isinstance(error, ReadError)
    assert error.code == "log.no_scans"


@pytest.mark.parametrize("name", ["a b?mode=rw&x=1#.db3", "100%.db3"])
def test_a_db3_of_any_name(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(good("db3"))
    assert open_log(path).n_scans == 6
    assert [one.name for one in tmp_path.iterdir()] == [name]


def test_notes_of_a_file_of_many_damaged_chunks_are_few(tmp_path):
    chunk = bag_record({"op": b"\x05", "compression": b"bz2"}, b"no bz2 data")
    data = good("bag-none")
    log = opened(tmp_path, data[:13] + chunk * 500 + data[13:])
    assert isinstance(log, ScanLog)
    assert len(log.notes) < 30


def test_the_memory_of_a_claimed_length_is_not_taken(tmp_path, peak_memory):
    tracemalloc.reset_peak()
    opened(tmp_path, b"\x89MCAP0\r\n" + struct.pack("<BQ", 6, 2**63) + b"abc")
    opened(tmp_path, b"#ROSBAG V2.0\n" + struct.pack("<I", 0xFFFFFFFF))
    opened(tmp_path, bag_record({"op": b"\x05", "compression": b"none"}, b"")[:-4] + b"\xff" * 4)
    assert peak_memory() < 8 << 20
