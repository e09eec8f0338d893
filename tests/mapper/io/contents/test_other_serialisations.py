"""Messages in Protocol Buffers, in JSON and by IDL: the official encoder's bytes, what was written, and rosbags."""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.writer import Writer
from rosbags.typesys import Stores, get_types_from_idl, get_typestore

from mapper.core.errors import LimitError, ReadError
from mapper.io.contents.definitions import MAX_BYTES, definitions_of
from mapper.io.contents.fields import field_series, fields_of
from mapper.io.contents.idl import definitions_in_idl
from mapper.io.contents.inspection import inspect
from mapper.io.contents.message_tree import raw_message, tree_of, tree_of_json
from mapper.io.contents.protobuf_tree import table_of, tree_of_protobuf
from mapper.io.contents.tree_values import MAX_SHOWN, MAX_VALUES, SHOWN
from tests.mapper.io.logs import recorded

SECOND = 1_000_000_000
T0 = 1_700_000_000 * SECOND

# Written by google.protobuf 7.36: the descriptors of google.protobuf.Timestamp and of own.msgs.Own (proto3, which has a
# field of every type, a nested type, an enumeration, an optional field, a map, and a field of its own type).
DEFINITION = base64.b64decode(
    "Cv8BCh9nb29nbGUvcHJvdG9idWYvdGltZXN0YW1wLnByb3RvEg9nb29nbGUucHJvdG9idWYiOwoJVGltZXN0YW1wEhgKB3NlY29uZHMYASABKA"
    "NSB3NlY29uZHMSFAoFbmFub3MYAiABKAVSBW5hbm9zQoUBChNjb20uZ29vZ2xlLnByb3RvYnVmQg5UaW1lc3RhbXBQcm90b1ABWjJnb29nbGUu"
    "Z29sYW5nLm9yZy9wcm90b2J1Zi90eXBlcy9rbm93bi90aW1lc3RhbXBwYvgBAaICA0dQQqoCHkdvb2dsZS5Qcm90b2J1Zi5XZWxsS25vd25UeX"
    "Blc2IGcHJvdG8zCscFCglvd24ucHJvdG8SCG93bi5tc2dzGh9nb29nbGUvcHJvdG9idWYvdGltZXN0YW1wLnByb3RvIuoECgNPd24SEAoIYV9k"
    "b3VibGUYASABKAESDwoHYV9mbG9hdBgCIAEoAhIPCgdhX2ludDMyGAMgASgFEg8KB2FfaW50NjQYBCABKAMSEAoIYV91aW50MzIYBSABKA0SEA"
    "oIYV91aW50NjQYBiABKAQSEAoIYV9zaW50MzIYByABKBESEAoIYV9zaW50NjQYCCABKBISEQoJYV9maXhlZDMyGAkgASgHEhEKCWFfZml4ZWQ2"
    "NBgKIAEoBhISCgphX3NmaXhlZDMyGAsgASgPEhIKCmFfc2ZpeGVkNjQYDCABKBASDgoGYV9ib29sGA0gASgIEhAKCGFfc3RyaW5nGA4gASgJEg"
    "8KB2FfYnl0ZXMYDyABKAwSKQoFc3RhbXAYFCABKAsyGi5nb29nbGUucHJvdG9idWYuVGltZXN0YW1wEiMKBnBvaW50cxgVIAMoCzITLm93bi5t"
    "c2dzLk93bi5Qb2ludBIOCgZwYWNrZWQYFiADKBESFAoIdW5wYWNrZWQYFyADKAFCAhAAEh4KBWxldmVsGBggASgOMg8ub3duLm1zZ3MuTGV2ZW"
    "wSEgoFbWF5YmUYGSABKAFIAIgBARInCgVuYW1lZBgaIAMoCzIYLm93bi5tc2dzLk93bi5OYW1lZEVudHJ5Eh0KBml0c2VsZhgbIAEoCzINLm93"
    "bi5tc2dzLk93bhIMCgR6ZXJvGBwgASgBGh0KBVBvaW50EgkKAXgYASABKAESCQoBeRgCIAEoAhosCgpOYW1lZEVudHJ5EgsKA2tleRgBIAEoCR"
    "INCgV2YWx1ZRgCIAEoBToCOAFCCAoGX21heWJlKhoKBUxldmVsEgcKA0xPVxAAEggKBEhJR0gQAmIGcHJvdG8z"
)
MESSAGE = base64.b64decode(
    "CQAAAAAAAATAFQAAgD4Y/f//////////ASCAgICAgICAgPABKIDQrPMOMP///////////wE4CUALTQcAAABRCAAAAAAAAABd9////2H2//////"
    "///2gBcgdncsO8w59legIA/6IBCQiA4s+qBhD0A6oBCQkAAAAAAADwP6oBBRUAAABAsgEEAgHYBLkBAAAAAAAA4D+5AQAAAAAAAPB/wAECyQEA"
    "AAAAAAAAANIBBQoBYRAB2gEHGAHaAQJoAQ=="
)
ZERO = {
    "a_double": 0.0, "a_float": 0.0, "a_int32": 0, "a_int64": 0, "a_uint32": 0, "a_uint64": 0, "a_sint32": 0,
    "a_sint64": 0, "a_fixed32": 0, "a_fixed64": 0, "a_sfixed32": 0, "a_sfixed64": 0, "a_bool": False, "a_string": "",
    "a_bytes": [], "points": [], "packed": [], "unpacked": [], "level": 0, "named": [], "zero": 0.0,
}  # fmt: skip
#: What was given to the encoder.
EXPECTED = ZERO | {
    "a_double": -2.5, "a_float": 0.25, "a_int32": -3, "a_int64": str(-(1 << 60)), "a_uint32": 4_000_000_000,
    "a_uint64": str((1 << 64) - 1), "a_sint32": -5, "a_sint64": -6, "a_fixed32": 7, "a_fixed64": 8, "a_sfixed32": -9,
    "a_sfixed64": -10, "a_bool": True, "a_string": "grüße", "a_bytes": [0, 255], "level": 2, "maybe": 0.0,
    "stamp": {"seconds": 1_700_000_000, "nanos": 500}, "points": [{"x": 1.0, "y": 0.0}, {"x": 0.0, "y": 2.0}],
    "packed": [1, -1, 300], "unpacked": [0.5, ".inf"], "named": [{"key": "a", "value": 1}],
    "itself": ZERO | {"a_int32": 1, "itself": ZERO | {"a_bool": True}},
}  # fmt: skip


def of_length(number: int, data: bytes) -> bytes:
    """A field of Protocol Buffers that has a length."""
    return varint(number << 3 | 2) + varint(len(data)) + data


def varint(value: int) -> bytes:
    out = b""
    while value >= 0x80:
        out, value = out + bytes([value & 0x7F | 0x80]), value >> 7
    return out + bytes([value])


def test_every_kind_of_field_of_protocol_buffers() -> None:
    table = table_of("own.msgs.Own", DEFINITION)
    assert tree_of_protobuf("own.msgs.Own", table, MESSAGE) == EXPECTED
    assert list(tree_of_protobuf("own.msgs.Own", table, b"")) == list(ZERO)
    assert tree_of_protobuf("own.msgs.Own", table, of_length(99, b"unknown")) == ZERO


def test_long_arrays_of_protocol_buffers_are_cut() -> None:
    table = table_of("own.msgs.Own", DEFINITION)
    numbers = b"".join(varint(n << 1) for n in range(1000))
    tree = tree_of_protobuf("own.msgs.Own", table, of_length(22, numbers) + of_length(22, numbers))
    assert tree["packed"] == [*range(SHOWN), f"… {2000 - SHOWN:,} more"]
    tree = tree_of_protobuf("own.msgs.Own", table, of_length(21, b"") * 200 + of_length(15, bytes(500)))
    assert tree["points"][SHOWN:] == [f"… {200 - SHOWN} more"]
    assert tree["a_bytes"][SHOWN:] == [f"… {500 - SHOWN} more"]


@pytest.mark.parametrize(
    "data",
    [
        b"\x08",  # a number without its end
        of_length(14, b"abc")[:-1],
        varint(22 << 3 | 2) + varint(1 << 40),  # longer than the message
        varint(14 << 3),  # no value
        varint(1 << 3 | 2) + b"\x03abc",  # three bytes of a double
        varint(20 << 3 | 3),  # a group
        varint(20 << 3) + b"\x01",  # a number in place of a message
        b"\xff" * 11,
    ],
)
def test_messages_of_protocol_buffers_that_lie_are_refused(data: bytes) -> None:
    with pytest.raises(ReadError, match=r"is no own\.msgs\.Own"):
        tree_of_protobuf("own.msgs.Own", table_of("own.msgs.Own", DEFINITION), data)


def test_messages_of_protocol_buffers_that_grow_without_end_are_refused() -> None:
    table = table_of("own.msgs.Own", DEFINITION)
    nested = b""
    for _ in range(60):
        nested = of_length(27, nested)
    with pytest.raises(LimitError, match="nested"):
        tree_of_protobuf("own.msgs.Own", table, nested)
    with pytest.raises(LimitError, match="values"):
        tree_of_protobuf("own.msgs.Own", table, b"\x68\x01" * (MAX_VALUES + 1))


def test_descriptors_that_lie_are_refused() -> None:
    def described(*fields: bytes) -> bytes:
        message = of_length(1, b"Own") + b"".join(of_length(2, one) for one in fields)
        return of_length(1, of_length(2, b"own") + of_length(4, message))

    def field(name: bytes, number: int, kind: int, of: bytes = b"") -> bytes:
        return of_length(1, name) + b"\x18" + varint(number) + b"\x28" + varint(kind) + (of and of_length(6, of))

    assert list(table_of("own.Own", described(field(b"a", 1, 1), field(b"b", 2, 11, b".own.Own")))) == [1, 2]
    deep = b""
    for _ in range(2000):
        deep = of_length(3, deep)
    for definition, said in (
        (described(field(b"a", 1, 11, b".own.Missing")), "does not define every type"),
        (described(field(b"a", 1, 10)), "the type 10"),
        (described(*(field(b"a", n, 1) for n in range(5000))), "has over"),
        (described(), "does not define the type 'own.Other'"),
        (of_length(1, of_length(4, deep)), "is no set of descriptors"),
        (b"\x0a\xff", "is no set of descriptors"),
        (bytes(MAX_BYTES + 1), "has more than"),
    ):
        with pytest.raises(ReadError, match=said):
            table_of("own.Other" if "Other" in said else "own.Own", definition)


def test_messages_in_json() -> None:
    data = b'{"a": [1, NaN, true], "b": {"c": "x", "d": null}, "e": 1e999, "f": 12345678901234567890, "g": "\\ud800"}'
    assert tree_of_json("own", data) == {
        "a": [1, ".nan", True], "b": {"c": "x", "d": None}, "e": ".inf", "f": "12345678901234567890", "g": "?",
    }  # fmt: skip
    tree = tree_of_json("own", json.dumps({"a": list(range(1000)), "b": "x" * 9000}).encode())
    assert tree["a"] == [*range(SHOWN), f"… {1000 - SHOWN} more"]
    assert tree["b"].endswith("9,000 characters")


@pytest.mark.parametrize("data", [b"", b"{", b"[]", b"7", b"\xff\xfe{", b'{"a": ' + b"9" * 5000 + b"}"])
def test_what_is_no_object_of_json_is_refused(data: bytes) -> None:
    with pytest.raises(ReadError, match="is no own"):
        tree_of_json("own", data)


def test_json_that_grows_without_end_is_refused() -> None:
    for deep in (50, 20_000):
        with pytest.raises(LimitError, match="nested"):
            tree_of_json("own", b'{"a": ' + b"[" * deep + b"]" * deep + b"}")
    with pytest.raises(LimitError, match="values"):
        tree_of_json("own", json.dumps({str(n): n for n in range(30_000)}).encode())
    with pytest.raises(LimitError, match="bytes of JSON"):
        tree_of_json("own", bytes((1 << 24) + 1))
    wide: Any = 1
    for _ in range(3):
        wide = [wide] * 100
    shown = json.dumps(tree_of_json("own", json.dumps({"a": wide}).encode()))
    assert shown.count("1") < MAX_SHOWN < 1_000_000


IDL = r"""
================================================================================
IDL: own_msgs/msg/Own
// generated from own_msgs/msg/Own.msg
#include "geometry_msgs/msg/Point.idl"
#include "own_msgs/msg/Nothing.idl"

module own_msgs {
  module msg {
    typedef double double__36[36];
    typedef geometry_msgs::msg::Point geometry_msgs__msg__Point__2[2];
    module Own_Constants {
      const uint8 LIMIT = 3;
      const string WORD = "a; } // b";
    };
    @verbatim (language="comment", text=
      "One of every kind: see http://example.org (or not)" "\n"
      "and \"this\"")
    struct Own {
      @verbatim (language="comment", text="a name; with } in it")
      @unit (value="m")
      string<10> name;
      @default (value=1.5)
      float one;
      double__36 covariance;
      geometry_msgs__msg__Point__2 corners;
      sequence<geometry_msgs::msg::Point> points;
      sequence<int16, 5> few;
      sequence<string> words;
      boolean flag;
      octet raw;
      unsigned long long big;
      uint8 small, other;
      /* the last
         one */
      own_msgs::msg::Nothing nothing;
      short last;
    };
  };
};

================================================================================
IDL: geometry_msgs/msg/Point
module geometry_msgs {
  module msg {
    struct Point {
      double x;
      double y;
      double z;
    };
  };
};

================================================================================
IDL: own_msgs/msg/Nothing
module own_msgs {
  module msg {
    struct Nothing {
      uint8 structure_needs_at_least_one_member;
    };
  };
};
"""


def test_definitions_in_idl_are_read_as_rosbags_reads_them() -> None:
    store = get_typestore(Stores.EMPTY)
    for file in re.sub("#include.*", "", IDL).split("=" * 80)[1:]:  # which rosbags does not read
        store.register(get_types_from_idl(file.split("\n", 2)[2]))
    types = store.types
    point, nothing = types["geometry_msgs/msg/Point"], types["own_msgs/msg/Nothing"]
    corners = [point(1.0, 2.0, 3.0), point(4.0, 5.0, 6.0)]
    message = types["own_msgs/msg/Own"](
        name="left", one=0.5, covariance=np.arange(36.0), corners=corners, points=corners[:1],
        few=np.array([-3, 4], np.int16), words=["a", ""], flag=True, raw=7, big=1 << 40, small=1, other=2,
        nothing=nothing(0), last=-2,
    )  # fmt: skip
    data = bytes(store.serialize_cdr(message, "own_msgs/msg/Own"))
    kind = "own_msgs/Own"
    assert tree_of(definitions_in_idl(kind, IDL), kind, data, cdr=True) == {
        "name": "left", "one": 0.5, "covariance": list(range(36)),
        "corners": [{"x": 1.0, "y": 2.0, "z": 3.0}, {"x": 4.0, "y": 5.0, "z": 6.0}],
        "points": [{"x": 1.0, "y": 2.0, "z": 3.0}], "few": [-3, 4], "words": ["a", ""], "flag": True, "raw": 7,
        "big": 1 << 40, "small": 1, "other": 2, "nothing": {}, "last": -2,
    }  # fmt: skip


def test_a_definition_in_idl_is_that_of_the_same_message_in_msg() -> None:
    idl = """
        module a { module msg { struct P { b::msg::Q at; sequence<Q> some; double x[3]; }; struct Q { float f; }; }; };
        module b { module msg { struct Q { long n; }; }; };
    """
    msg = "b/Q at\na/Q[] some\nfloat64[3] x\n===\nMSG: b/Q\nint32 n\n===\nMSG: a/Q\nfloat32 f\n"
    assert definitions_in_idl("a/P", idl) == definitions_of("a/P", msg)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("module a { struct P { wstring s; }; };", "does not define every type: 'wstring'"),
        ("module a { struct P { sequence<sequence<double>> s; }; };", "not read of IDL"),
        ("module a { struct P { double s[2][3]; }; };", "not read of IDL"),
        ("module a { typedef double D[2]; struct P { sequence<D> s; }; };", "not read of IDL"),
        ("module a { struct P { a::N s; }; };", "does not define every type: 'a::N'"),
        ("module a { typedef E D; typedef D E; struct P { D s; }; };", "not read of IDL"),
        ("module a { enum E { ONE }; struct P { double x; }; };", "has 'enum'"),
        ("module a { union U switch (long) { case 1: long x; }; };", "has 'union'"),
        ("module a { struct Q { double x; }; struct P : Q { double y; }; };", "has ':'"),
        ("module a { struct P { double x;", "ends early"),
        ("module a { struct P { double x; }; };" + "module a {" * 100, "has 'module'"),
        ("module a { struct P { " + "sequence<" * 20_000, "not read of IDL"),
        ("module a { struct P { " + "double x; " * 5000 + "}; };", "has over"),
        ("module a { struct P { double " + ",".join(["x"] * 5000) + "; }; };", "has over"),
        ("module a { struct Q { double x; }; };", "does not define the type 'a/P'"),
        ('module a { @b (text="' + "x" * 100_000, "ends early"),
        ("/* " * 80_000, "does not define the type"),
        ("x" * (MAX_BYTES + 1), "has more than"),
    ],
)
def test_idl_that_is_not_read_is_refused_with_its_reason(text: str, said: str) -> None:
    with pytest.raises(ReadError, match=said):
        definitions_in_idl("a/P", text)


def written(
    folder: Path, encoding: str, schema: tuple[str, str, bytes] | None, message: Callable[[int], bytes]
) -> Path:
    """An MCAP with ten messages on /own, one a second."""
    path = folder / "own.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        of = 0 if schema is None else writer.register_schema(*schema)
        channel = writer.register_channel("/own", encoding, of)
        for n in range(10):
            writer.add_message(channel, T0 + n * SECOND, message(n), T0 + n * SECOND)
        writer.finish()  # type: ignore[no-untyped-call]
    return path


def in_protobuf(n: int) -> bytes:
    """Own: the stamp is half a second before the time of recording."""
    stamp = b"\x08" + varint(T0 // SECOND + n - 1) + b"\x10" + varint(SECOND // 2)
    return of_length(20, stamp) + b"\x68\x01" + np.array([n]).astype("<f8").tobytes().join([b"\x09", b""])


def in_json(n: int) -> bytes:
    return json.dumps({"stamp": {"sec": T0 // SECOND + n - 1, "nsec": SECOND // 2}, "a_double": n}).encode()


@pytest.mark.parametrize(
    ("encoding", "schema", "message"),
    [
        ("protobuf", ("own.msgs.Own", "protobuf", DEFINITION), in_protobuf),
        ("json", ("own.Own", "jsonschema", b"{}"), in_json),
        ("json", None, in_json),
    ],
)
def test_messages_and_fields_of_a_recording(
    tmp_path: Path, encoding: str, schema: tuple[str, str, bytes] | None, message: Callable[[int], bytes]
) -> None:
    file = written(tmp_path, encoding, schema, message)
    kind = schema[0] if schema else ""
    found = raw_message(file, "/own", T0 + 4 * SECOND + 1)
    assert (found.type, found.stamp_ns, found.tree["a_double"]) == (kind, T0 + 4 * SECOND, 4)
    contents = inspect(file)
    assert [(one.name, one.type, one.messages) for one in contents.topics] == [("/own", kind, 10)]
    (names,) = fields_of(file, [("/own", kind)])
    assert names.why == ""
    series = field_series(file, "/own", kind)
    column = [one.label for one in series.columns].index("a_double")
    assert series.columns[column].label in names.fields
    np.testing.assert_array_equal(series.values[:, column], np.arange(10.0))
    np.testing.assert_array_equal(series.stamps_ns, T0 - SECOND // 2 + SECOND * np.arange(10))
    assert not series.recorded


def test_a_scan_of_foxglove_is_shown_as_it_was_recorded(tmp_path: Path) -> None:
    """For a map it is made a message of ROS, whose type the topic has in the list."""
    values = {"timestamp": {"sec": 5, "nsec": 0}, "frame_id": "laser", "start_angle": -1.0, "ranges": [1.0, 2.5]}
    file = written(tmp_path, "json", ("foxglove.LaserScan", "jsonschema", b"{}"), lambda _: json.dumps(values).encode())
    assert [one.type for one in inspect(file).topics] == ["sensor_msgs/LaserScan"]
    found = raw_message(file, "/own", T0)
    assert (found.type, found.tree) == ("foxglove.LaserScan", values)
    assert fields_of(file, [("/own", "sensor_msgs/LaserScan")])[0].fields[-2:] == ("ranges[0]", "ranges[1]")
    series = field_series(file, "/own", "sensor_msgs/LaserScan")
    assert series.values[0].tolist() == [5.0, 0.0, -1.0, 1.0, 2.5]


def test_a_recording_with_definitions_in_idl(tmp_path: Path) -> None:
    store = recorded.store(2)
    point = store.types["geometry_msgs/msg/Point"]
    file = written(
        tmp_path,
        "cdr",
        ("geometry_msgs/msg/Point", "ros2idl", IDL.split("=" * 80)[2].encode()),
        lambda n: bytes(store.serialize_cdr(point(float(n), 0.0, 0.0), "geometry_msgs/msg/Point")),
    )
    assert raw_message(file, "/own", T0 + SECOND).tree == {"x": 1.0, "y": 0.0, "z": 0.0}
    assert field_series(file, "/own", "geometry_msgs/Point").values[:, 0].tolist() == list(range(10))


@pytest.mark.parametrize(
    ("encoding", "form"), [("cbor", "jsonschema"), ("cdr", "omgidl"), ("flatbuffer", "flatbuffer"), ("protobuf", "x")]
)
def test_another_serialisation_is_named(tmp_path: Path, encoding: str, form: str) -> None:
    file = written(tmp_path, encoding, ("own.Own", form, b"x"), lambda _: b"x" * 8)
    with pytest.raises(ReadError, match=f"'{encoding}' with definitions of the kind '{form}' are not read"):
        raw_message(file, "/own", T0)
    assert f"'{form}'" in fields_of(file, [("/own", "own.Own")])[0].why
