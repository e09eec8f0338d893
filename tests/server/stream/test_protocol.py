"""Invalid commands are refused with one sentence."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.stream.protocol import (
    ProtocolError,
    decode_command,
    encode_text,
    integer,
    number,
    text,
    values,
)


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
        ('{"type": "nav2", "text": "\\ud800"}', "command.json"),
        ('{"type": "seek", "index": ' + "9" * 5000 + "}", "command.json"),
    ],
)
def test_invalid_commands_are_refused(sent: str | bytes, code: str) -> None:
    with pytest.raises(ProtocolError) as refused:
        decode_command(sent)
    assert refused.value.code == code
    assert len(refused.value.message) < 200


@given(st.recursive(st.none() | st.booleans() | st.floats() | st.integers() | st.text(), st.lists))
def test_helpers_return_the_stated_type_or_refuse(value: Any) -> None:
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


def test_values_that_json_cannot_represent_are_a_defect() -> None:
    assert json.loads(encode_text({"type": "x", "ω": 1.5})) == {"type": "x", "ω": 1.5}
    with pytest.raises(ValueError, match="JSON"):
        encode_text({"type": "x", "value": float("nan")})
