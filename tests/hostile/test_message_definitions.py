"""MCAP files whose definitions or messages are made to harm the decoder, which each of them really reaches."""

from __future__ import annotations

import struct
import tracemalloc
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from mcap.writer import CompressionType, Writer

from mapper.core.errors import LimitError, MapperError, ReadError
from mapper.io.contents import message_tree
from mapper.io.contents.fields import field_series, fields_of
from mapper.io.contents.inspection import inspect
from mapper.io.contents.message_tree import raw_message
from mapper.io.contents.tree_values import Tree, check_size
from tests.hostile.corpus import T0

TOPIC, KIND = "/odd", "robot_msgs/Odd"
CDR = b"\x00\x01\x00\x00"  #: how each message begins: little-endian
MOST_BYTES = 64 << 20  #: that Python may hold while it reads any of the files, of a few kB each
FOUR_BILLION = struct.pack("<I", 0xFFFFFFFF)


def types(*sections: str) -> str:
    """A definition: that of the type itself, then those of the types that it uses, each after ``Name:``."""
    first, *others = sections
    rule = "=" * 80
    named = (f"{rule}\nMSG: robot_msgs/{name}\n{text}" for name, text in (one.split(":", 1) for one in others))
    return "\n".join([first, *named])


def nested(depth: int, fields: int) -> str:
    """Types within types, each with so many fields of the next one; the last has no bytes."""
    used = ["\n".join(f"Level{level + 1} {chr(97 + n)}" for n in range(fields)) for level in range(depth)]
    levels = (f"Level{level}:{text}" for level, text in enumerate(used))
    return types("Level0 first", *levels, f"Level{depth}:uint8[0] nothing")


#: Definition, message behind its first four bytes, and the error that the decoder raises.
CASES: dict[str, tuple[str, bytes, type[MapperError], str]] = {
    "a type within itself": ("Odd again", b"", LimitError, "message.too_deep"),
    "two types within each other": (types("Other one", "Other:Odd two"), b"", LimitError, "message.too_deep"),
    "arrays of itself": ("Odd[] again", struct.pack("<I", 1) * 100, LimitError, "message.too_deep"),
    "an array of itself of 4·10⁹": ("Odd[4000000000] again", b"", LimitError, "message.too_deep"),
    "4·10⁹ bytes": ("uint8[4000000000] data", bytes(100), ReadError, "message.damaged"),
    "4·10⁹ numbers, as the message says": ("float64[] data", FOUR_BILLION, ReadError, "message.damaged"),
    "4·10⁹ texts, as the message says": ("string[] data", FOUR_BILLION, ReadError, "message.damaged"),
    "4·10⁹ of a type of 4·10⁹": (
        types("Many[4000000000] data", "Many:float64[4000000000] more"), bytes(8), ReadError, "message.damaged",
    ),
    "a text of 2 GB": ("string data", struct.pack("<I", 2 << 30) + b"short", ReadError, "message.damaged"),
    "an array of 2 GB": ("uint8[] data", struct.pack("<I", 2 << 30) + b"short", ReadError, "message.damaged"),
    "200 types in one another": (nested(200, 1), b"", LimitError, "message.too_deep"),
    "20 types, each twice in the one before": (nested(20, 2), b"", LimitError, "message.too_large"),
}  # fmt: skip


@pytest.fixture
def decoded(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The types of the values whose decoding was begun, in order."""
    begun: list[str] = []
    decode: Callable[..., Tree] = message_tree._Decoder.message

    def noting(self: message_tree._Decoder, kind: str, depth: int) -> Tree:
        begun.append(kind)
        return decode(self, kind, depth)

    monkeypatch.setattr(message_tree._Decoder, "message", noting)
    monkeypatch.setattr(message_tree, "check_size", partial(check_size, most=20_000))  # a million take seconds
    return begun


def recording(path: Path, definition: str, message: bytes, kind: str = KIND) -> Path:
    """An MCAP with one message."""
    with path.open("wb") as file:
        writer = Writer(file, compression=CompressionType.NONE)
        writer.start("ros2")
        schema = writer.register_schema(kind, "ros2msg", definition.encode())
        channel = writer.register_channel(TOPIC, "cdr", schema)
        writer.add_message(channel, log_time=T0, data=CDR + message, publish_time=T0)
        writer.finish()  # type: ignore[no-untyped-call]
    return path


@pytest.mark.parametrize("case", CASES)
def test_the_decoder_is_reached_and_refuses(tmp_path: Path, decoded: list[str], case: str) -> None:
    definition, message, error, code = CASES[case]
    path = recording(tmp_path / "odd.mcap", definition, message)
    tracemalloc.start()
    try:
        with pytest.raises(error) as caught:
            raw_message(path, TOPIC, T0)
        assert (caught.value.code, decoded[0]) == (code, KIND)
        decoded.clear()
        (fields,) = fields_of(path, [(TOPIC, KIND)])
        assert (fields.fields, fields.why, decoded[0]) == ((), caught.value.message, KIND)
        decoded.clear()
        with pytest.raises(MapperError):
            field_series(path, TOPIC, KIND)
        assert decoded[0] == KIND
        (topic,) = inspect(path).topics
        assert (topic.name, topic.messages, topic.bytes) == (TOPIC, 1, len(CDR + message))
        assert tracemalloc.get_traced_memory()[1] < MOST_BYTES
    finally:
        tracemalloc.stop()


def test_a_record_that_claims_2_gb_has_no_message(tmp_path: Path) -> None:
    path = recording(tmp_path / "odd.mcap", "uint8[] data", bytes(4))
    data = path.read_bytes()
    body = struct.pack("<HIQQ", 1, 0, T0, T0) + CDR + bytes(4)
    at = data.index(body) - 8
    assert struct.unpack_from("<Q", data, at)[0] == len(body)
    path.write_bytes(data[:at] + struct.pack("<Q", 2 << 30) + body)
    tracemalloc.start()
    try:
        with pytest.raises(MapperError):
            raw_message(path, TOPIC, T0)
        assert tracemalloc.get_traced_memory()[1] < MOST_BYTES
    finally:
        tracemalloc.stop()
