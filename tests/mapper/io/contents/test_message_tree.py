"""Messages as trees are what rosbags reads of the same bytes; definitions and messages that lie are refused."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from mapper.core.errors import LimitError, ReadError
from mapper.io.contents import message_tree
from mapper.io.contents.definitions import definitions_of
from mapper.io.contents.tree_values import SHOWN, Tree

STORES = {True: get_typestore(Stores.ROS2_JAZZY), False: get_typestore(Stores.ROS1_NOETIC)}
OWN = """
# arrays of every kind, strings with bounds, a constant and a default
uint8 LIMIT=3
string<=10 name
float64[] none
float64[3] three
int16[<=5] few
string[] words
bool[2] flags
std_msgs/ColorRGBA[] colours
int64 big
float32 infinite
geometry_msgs/Point at
================================================================================
MSG: std_msgs/ColorRGBA
float32 r
float32 g
float32 b
float32 a
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
"""


def tree_of(kind: str, text: str, data: bytes, *, cdr: bool) -> Tree:
    return message_tree.tree_of(definitions_of(kind, text), kind, data, cdr=cdr)


def plain(value: Any) -> Any:
    """Return a message of rosbags as the tree has it."""
    if dataclasses.is_dataclass(value):
        own = {one.name: plain(getattr(value, one.name)) for one in dataclasses.fields(value)}
        return {
            name: one for name, one in own.items() if name not in ("__msgtype__", "structure_needs_at_least_one_member")
        }
    if isinstance(value, np.ndarray | list | tuple):
        return [plain(one) for one in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    return str(value) if isinstance(value, int) and not isinstance(value, bool) and abs(value) > 1 << 53 else value


def serialised(store: Any, kind: str, message: Any, *, cdr: bool) -> bytes:
    return bytes(store.serialize_cdr(message, kind) if cdr else store.serialize_ros1(message, kind))


@pytest.mark.parametrize("cdr", [True, False])
def test_every_kind_of_field_is_read_as_rosbags_reads_it(cdr: bool) -> None:
    store = get_typestore(Stores.ROS2_JAZZY if cdr else Stores.ROS1_NOETIC)
    kind = "own_msgs/msg/Own"
    text = OWN if cdr else OWN.replace("<=10", "").replace("[<=5]", "[]")
    store.register({name: one for name, one in get_types_from_msg(text, kind).items() if name == kind})
    types = store.types
    colour = types["std_msgs/msg/ColorRGBA"](0.5, 0.25, 1.0, 0.0)
    message = types[kind](
        name="left", none=np.zeros(0), three=np.array([1.0, -2.5, math.nan]), few=np.array([-3, 4], np.int16),
        words=["one", "", "drei"], flags=np.array([True, False]), colours=[colour, colour], big=(1 << 60) + 1,
        infinite=-math.inf, at=types["geometry_msgs/msg/Point"](1.0, 2.0, 3.0), LIMIT=3,
    )  # fmt: skip
    data = serialised(store, kind, message, cdr=cdr)
    expected = plain(message)
    expected.pop("LIMIT", None)
    assert tree_of(kind, text, data, cdr=cdr) == expected
    for end in range(len(data)):
        with pytest.raises(ReadError):
            tree_of(kind, text, data[:end], cdr=cdr)


@pytest.mark.parametrize("cdr", [True, False])
@pytest.mark.parametrize("kind", ["sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry", "std_msgs/msg/Empty"])
def test_definitions_of_ros_are_read(kind: str, cdr: bool) -> None:
    store = STORES[cdr]
    text, _ = store.generate_msgdef(kind, ros_version=2 if cdr else 1)
    found = definitions_of(kind, text)
    names = [one.name for one in dataclasses.fields(store.types[kind]) if "__" not in one.name]  # type: ignore[arg-type]
    own = found[kind.replace("/msg", "")]
    assert [one.name for one in own] == [name for name in names if name != "structure_needs_at_least_one_member"]


def test_a_long_array_is_cut_in_the_tree_and_read_to_its_end() -> None:
    data = (1000).to_bytes(4, "little") + bytes(range(250)) * 4 + b"\x07"
    tree = tree_of("own/Bytes", "uint8[] data\nuint8 last", data, cdr=False)
    assert tree["data"] == [*range(SHOWN), f"… {1000 - SHOWN} more"]
    assert tree["last"] == 7


def test_lengths_that_lie_are_refused() -> None:
    most = (0xFFFFFFFF).to_bytes(4, "little")
    for text in ("uint8[] data", "string data", "own/P[] data\n===\nMSG: own/P\nfloat64 x", "float64[100000000] data"):
        with pytest.raises(ReadError, match="is no own/Data"):
            tree_of("own/Data", text, most + b"\0" * 8, cdr=False)


def test_definitions_that_grow_without_end_are_refused() -> None:
    most = "[4000000000]"
    empty = f"own/E{most} a\n===\nMSG: own/E\nown/F{most} b\n===\nMSG: own/F\nown/G{most} c\n===\nMSG: own/G\n"
    with pytest.raises(LimitError):
        tree_of("own/Data", empty, b"", cdr=False)
    with pytest.raises(LimitError):
        tree_of("own/Data", "own/Data a", b"", cdr=False)
    nested = (
        "own/T0 a\n"
        + "\n".join(f"===\nMSG: own/T{n}\nown/T{n + 1}[2] a" for n in range(100))
        + "\n===\nMSG: own/T100\n"
    )
    with pytest.raises(LimitError):
        tree_of("own/Data", nested, b"", cdr=False)
    with pytest.raises(ReadError, match=r"own/Data\.a is of type own/Missing"):
        tree_of("own/Data", "Missing a", b"", cdr=False)
    with pytest.raises(ReadError, match="which is not a definition"):
        tree_of("own/Data", "struct { int a; }", b"", cdr=False)
