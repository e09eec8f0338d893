"""Frames come back as they went out, and what is no frame is refused in one sentence."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.stream.protocol import (
    ProtocolError,
    TilePayload,
    decode_command,
    decode_tiles,
    encode_text,
    encode_tiles,
    integer,
    number,
    text,
    values,
)

TILES = st.lists(
    st.builds(
        TilePayload,
        tx=st.integers(-(2**15), 2**15 - 1),
        ty=st.integers(-(2**15), 2**15 - 1),
        revision=st.integers(0, 2**32 - 1),
        data=st.binary(max_size=40),
    ),
    max_size=5,
)


@given(st.integers(0, 2**32 - 1), st.integers(0, 2**32 - 1), TILES, st.booleans())
def test_tiles_come_back(epoch: int, seq: int, tiles: list[TilePayload], complete: bool) -> None:
    frame = decode_tiles(encode_tiles(epoch, seq, tiles, complete=complete))
    assert (frame.epoch, frame.seq, frame.complete, list(frame.tiles)) == (epoch, seq, complete, tiles)


def test_the_bytes_are_those_of_the_protocols_text() -> None:
    frame = encode_tiles(0x01020304, 5, [TilePayload(-2, 3, 9, b"zs")], complete=True)
    assert frame == bytes.fromhex("01 01 0000 04030201 05000000 01000000 feff 0300 09000000 02000000") + b"zs"


@given(TILES.filter(bool), st.data())
def test_every_cut_frame_is_refused(tiles: list[TilePayload], data: st.DataObject) -> None:
    frame = encode_tiles(1, 1, tiles)
    with pytest.raises(ProtocolError):
        decode_tiles(frame[: data.draw(st.integers(0, len(frame) - 1))])
    with pytest.raises(ProtocolError):
        decode_tiles(frame + b"x")


@pytest.mark.parametrize(
    ("sent", "code"),
    [
        (b"\x00\x01", "command.binary"),
        ("", "command.json"),
        ('{"type": "ack", "seq"', "command.json"),
        ("[" * 60_000, "command.json"),
        ('{"type": "speed", "value": NaN}', "command.number"),
        ('{"type": "speed", "value": -Infinity}', "command.number"),
        ('"play"', "command.type"),
        ("[]", "command.type"),
        ("{}", "command.type"),
        ('{"type": 3}', "command.type"),
        ('{"type": "play", "x": "' + "x" * 70_000 + '"}', "command.too_long"),
        ('{"type": "seek", "index": ' + "9" * 5000 + "}", "command.json"),
    ],
)
def test_what_is_no_command_is_refused(sent: str | bytes, code: str) -> None:
    with pytest.raises(ProtocolError) as refused:
        decode_command(sent)
    assert refused.value.code == code
    assert len(refused.value.message) < 200


@given(st.recursive(st.none() | st.booleans() | st.floats() | st.integers() | st.text(), st.lists))
def test_helpers_return_what_they_promise_or_refuse(value: Any) -> None:
    command = {"type": "x", "key": value, "values": value}
    for read, kind in ((number, float), (integer, int), (text, str)):
        try:
            assert type(read(command, "key")) is kind
        except ProtocolError as error:
            assert error.code == "command.key"  # noqa: PT017 - either is right
    try:
        assert isinstance(values(command), dict)
    except ProtocolError as error:
        assert error.code == "command.values"  # noqa: PT017 - either is right


def test_what_json_cannot_say_is_a_defect() -> None:
    assert json.loads(encode_text({"type": "x", "ω": 1.5})) == {"type": "x", "ω": 1.5}
    with pytest.raises(ValueError, match="JSON"):
        encode_text({"type": "x", "value": float("nan")})
