"""Bags and MCAP files with false lengths, other types, or invalid poses and frames: left out, and named."""

from __future__ import annotations

import struct
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from mcap.data_stream import RecordBuilder
from mcap.records import Channel, Schema

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import DEFAULT_LIMITS
from mapper.io.logs import open_log
from mapper.sensors.scan import ScanLog
from tests.hostile.corpus import T0, bag_record, ended, recording, said
from tests.hostile.damage import opened
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import odometry, scan, transform


@pytest.fixture
def peak_memory():
    """A function that tells how many bytes Python has held at most since the test began."""
    tracemalloc.start()
    yield lambda: tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()


def test_an_mcap_with_wrong_checksums_leaves_the_damaged_chunks_out(tmp_path):
    data = recorded.mcap_bytes(said(), "none", chunk_size=800)
    whole = opened(tmp_path / "a.log", data)
    at = data.rindex(struct.pack("<3f", 1, 2, 3)) + 1
    broken = opened(tmp_path / "a.log", data[:at] + bytes([data[at] ^ 4]) + data[at + 1 :])
    assert isinstance(whole, ScanLog)
    assert isinstance(broken, ScanLog)
    assert broken.n_scans < whole.n_scans
    assert any("has not the checksum" in note for note in broken.notes)
    # The first chunk is where the channels are announced; the file's end repeats them.
    at = data.index(struct.pack("<3f", 1, 2, 3)) + 1
    broken = opened(tmp_path / "a.log", data[:at] + bytes([data[at] ^ 4]) + data[at + 1 :])
    assert isinstance(broken, ScanLog)
    assert 0 < open_log(tmp_path / "a.log", topic="/scan").n_scans < whole.n_scans
    single = recorded.mcap_bytes([scan(T0, [1.0, 2.0, 3.0])], "none")
    at = single.index(struct.pack("<3f", 1, 2, 3)) + 1
    error = opened(tmp_path / "a.log", single[:at] + bytes([single[at] ^ 4]) + single[at + 1 :])
    assert isinstance(error, ReadError)


def test_an_mcap_whose_data_has_another_checksum_is_marked(tmp_path):
    data = recorded.mcap_bytes(said(), "none", use_chunking=False, enable_data_crcs=True)
    at = data.index(struct.pack("<3f", 1, 2, 3)) + 1
    log = opened(tmp_path / "a.log", data[:at] + bytes([data[at] ^ 4]) + data[at + 1 :])
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
    log = opened(tmp_path / "a.log", b"\x89MCAP0\r\n" + records)
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
    log = opened(tmp_path / "a.log", bag)
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
        lying(ranges=np.zeros(0, dtype=np.float32)),
    ],
    ids=["nan angle", "infinite step", "no beams"],
)
def test_an_invalid_scan_is_left_out_and_counted(tmp_path, message):
    data = recorded.mcap_bytes([scan(T0, [1.0, 2.0]), message])
    log = opened(tmp_path / "a.log", data)
    assert isinstance(log, ScanLog)
    assert log.n_scans == 1
    assert any("1 of 2 on /scan" in note for note in log.notes)


def test_invalid_poses_are_left_out(tmp_path):
    nowhere = [odometry(T0 + i, x, 0.0, 0.0) for i, x in enumerate([float("nan"), float("inf"), 1e300, 5.0])]
    unturned = odometry(T0, 1.0, 0.0, 0.0)
    unturned.fields["pose"]["pose"]["orientation"] = dict.fromkeys("xyzw", 0.0)
    log = opened(tmp_path / "a.log", recorded.mcap_bytes([*nowhere, unturned, scan(T0, [1.0])]))
    assert isinstance(log, ScanLog)
    assert log.trajectory("odom").poses.tolist() == [[5.0, 0.0, 0.0]]
    assert any("4 of 5 on /odom" in note for note in log.notes)


@pytest.mark.parametrize(
    ("change", "code"),
    [
        ({"max_messages": 8}, "log.too_many_messages"),
        ({"max_topics": 2}, "log.too_many_topics"),
        ({"max_scans": 5}, "log.too_many_scans"),
        ({"max_readings": 20}, "log.too_many_scans"),
        ({"max_beams": 2}, "log.too_many_beams"),
    ],
)
@pytest.mark.parametrize("kind", ["bag-none", "mcap-zstd", "db3"])
def test_limits_are_enforced(tmp_path, kind, change, code):
    limits = replace(DEFAULT_LIMITS, **change)
    error = opened(tmp_path / "a.log", recording(kind), limits)
    assert isinstance(error, LimitError), error
    assert error.code in (code, "log.chunk_too_large")


@pytest.mark.parametrize("kind", ["bag-bz2", "mcap-zstd"])
def test_the_total_size_of_expanded_chunks_is_limited(tmp_path, kind):
    few = replace(DEFAULT_LIMITS, max_unpacked_bytes=2000, max_expansion=0)
    error = opened(tmp_path / "a.log", recording(kind), few)
    assert isinstance(error, LimitError), error
    assert error.code == "log.too_many_bytes"
    enough = replace(few, max_expansion=100)  # times the size of the file
    assert isinstance(opened(tmp_path / "a.log", recording(kind), enough), ScanLog)


@pytest.mark.parametrize("kind", ["bag-bz2", "mcap-zstd"])  # a db3 has no chunks
def test_a_chunk_has_a_limit(tmp_path, kind):
    error = opened(tmp_path / "a.log", recording(kind), replace(DEFAULT_LIMITS, max_chunk_bytes=300))
    assert isinstance(error, LimitError), error
    assert error.code in ("log.too_many_bytes", "log.chunk_too_large")


def test_a_bag_of_another_version_and_one_that_is_encrypted(tmp_path):
    old = opened(tmp_path / "a.log", b"#ROSBAG V1.2\n" + bytes(100))
    assert isinstance(old, ReadError)
    assert old.code == "log.version"
    locked = opened(tmp_path / "a.log", b"#ROSBAG V2.0\n" + bag_record({"op": b"\x03", "encryptor": b"aes"}, b""))
    assert isinstance(locked, ReadError)
    assert locked.code == "log.encrypted"


def test_a_bag_header_of_megabytes_is_damage(tmp_path):
    data = recording("bag-none")
    for length in (b"\x01\0\x10\0", b"\xff" * 4):
        log = opened(tmp_path / "a.log", data + length + bytes(100))
        assert isinstance(log, ScanLog)
        assert f"The bag is damaged before byte {len(data) + 4}: the rest is left out." in log.notes


def test_notes_of_a_file_of_many_damaged_chunks_are_few(tmp_path):
    chunk = bag_record({"op": b"\x05", "compression": b"bz2"}, b"no bz2 data")
    data = recording("bag-none")
    log = opened(tmp_path / "a.log", data[:13] + chunk * 500 + data[13:])
    assert isinstance(log, ScanLog)
    assert len(log.notes) < 30


def test_the_memory_of_a_claimed_length_is_not_taken(tmp_path, peak_memory):
    tracemalloc.reset_peak()
    opened(tmp_path / "a.log", b"\x89MCAP0\r\n" + struct.pack("<BQ", 6, 2**63) + b"abc")
    opened(tmp_path / "a.log", b"#ROSBAG V2.0\n" + struct.pack("<I", 0xFFFFFFFF))
    opened(tmp_path / "a.log", bag_record({"op": b"\x05", "compression": b"none"}, b"")[:-4] + b"\xff" * 4)
    assert peak_memory() < 8 << 20


def test_an_mcap_whose_summary_has_another_checksum_is_marked_and_its_summary_not_used(tmp_path):
    data = recording("mcap-none")
    (start,) = struct.unpack_from("<Q", data, len(data) - 28)
    at = data.index(b"/scan", start)
    log = opened(tmp_path / "a.log", data[:at] + b"/scam" + data[at + 5 :])
    assert isinstance(log, ScanLog)
    assert log.n_scans == 6
    assert {topic.name for topic in log.topics} >= {"/scan"}
    assert any("summary" in note and "checksum" in note for note in log.notes)


def test_unknown_types_are_counted_and_never_decoded(tmp_path, monkeypatch):
    """Types that are named nearly as the known ones, and a known one that is said to be encoded in another way."""
    from mapper.io.logs.ros import ros_messages

    decoded: list[bytes] = []
    decode = ros_messages.laser_scan

    def counted(data: bytes, *, cdr: bool) -> ros_messages.Beams:
        decoded.append(data)
        return decode(data, cdr=cdr)

    monkeypatch.setitem(ros_messages.SENSORS, "sensor_msgs/LaserScan", counted)
    message = struct.pack("<IQQ", 0, T0, T0) + recorded.serialised(scan(T0, [1.0, 2.0]), 2)
    records = []
    for number, (kind, schema, encoding) in enumerate(
        [
            ("sensor_msgs/msg/LaserScan", "ros2msg", "cdr"),
            ("sensor_msgs/msg/LaserScan2", "ros2msg", "cdr"),
            ("other_msgs/msg/LaserScan", "ros2msg", "cdr"),
            ("LaserScan", "ros2msg", "cdr"),
            ("", "ros2msg", "cdr"),
            ("sensor_msgs/msg/LaserScan", "protobuf", "cdr"),
            ("sensor_msgs/msg/LaserScan", "ros2msg", "protobuf"),
            ("sensor_msgs/msg/LaserScan", "jsonschema", "json"),
        ],
        1,
    ):
        builder = RecordBuilder()
        Schema(id=number, name=kind, encoding=schema, data=b"").write(builder)
        Channel(id=number, topic=f"/t{number}", message_encoding=encoding, metadata={}, schema_id=number).write(builder)
        content = struct.pack("<H", number) + message
        records.append(ended(builder) + struct.pack("<BQ", 5, len(content)) + content)
    log = opened(tmp_path / "a.log", b"\x89MCAP0\r\n" + b"".join(records))
    assert isinstance(log, ScanLog)
    assert len(decoded) == log.n_scans == 1
    assert {topic.name: topic.count for topic in log.topics} == {f"/t{number}": 1 for number in range(1, 9)}
    assert not any("decoded" in note for note in log.notes)


def test_names_in_a_file_are_shown_in_one_line_and_as_they_are(tmp_path):
    nasty = "/a\n\u202egnp.exe\x1b[31m"
    log = opened(
        tmp_path / "a.log",
        recorded.mcap_bytes([scan(T0, [1.0], nasty, frame="f\r\n\u2066"), transform(T0, "o\n", "f")]),
    )
    assert isinstance(log, ScanLog)
    shown = [topic.name for topic in log.topics] + [topic.frame or "" for topic in log.topics]
    for text in (*shown, *log.notes, log.format, *log.trajectories):
        assert text.isprintable(), text


def test_a_message_of_absurdly_many_echoes_or_transforms_is_none(tmp_path):
    """Each of them becomes an object of its own: those of one message of 256 MiB would fill gigabytes."""
    frame = struct.pack("<IIII", 1, 5, 7, 0)
    echoes = frame + bytes(28) + struct.pack("<I", 1 << 21) + bytes(4 << 21)
    edges = struct.pack("<I", 20_000) + (frame + struct.pack("<I7d", 0, 0, 0, 0, 0, 0, 0, 1)) * 20_000
    for kind, message in (("sensor_msgs/MultiEchoLaserScan", echoes), ("tf2_msgs/TFMessage", edges)):
        builder = RecordBuilder()
        Schema(id=1, name=kind, encoding="ros1msg", data=b"").write(builder)
        Channel(id=1, topic="/t", message_encoding="ros1", metadata={}, schema_id=1).write(builder)
        content = struct.pack("<HIQQ", 1, 0, T0, T0) + message
        error = opened(
            tmp_path / "a.log",
            b"\x89MCAP0\r\n" + ended(builder) + struct.pack("<BQ", 5, len(content)) + content,
        )
        assert isinstance(error, ReadError)
        assert "could not be read: 1 of 1 on /t" in error.message
