"""Invalid commands are refused with one sentence."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.parts.notes.messages import NotesMessage
from server.parts.path.messages import GoalCommand
from server.parts.volume.messages import VoxelCommand
from server.parts.wire import command_of, decode_command
from server.stream.commands import ParametersCommand, TeleportCommand
from server.stream.messages import Trajectories
from server.stream.protocol import ProtocolError, encode_text, place_of


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
def test_a_field_has_its_type_or_the_command_is_refused_by_its_name(value: Any) -> None:
    for kind, field, of in (
        ("speed", "value", float),
        ("seek", "index", int),
        ("trajectory", "name", str),
        ("auto", "value", bool),
        ("parameters", "values", dict),
    ):
        try:
            read = getattr(command_of({"type": kind, field: value}), field)
        except ProtocolError as error:
            assert error.code == f"command.{field}"  # noqa: PT017 - either is right
        else:
            assert type(read) is of
            assert read == value
            assert not isinstance(read, float) or math.isfinite(read)


_VALUES = st.recursive(
    st.none() | st.booleans() | st.floats(allow_nan=False, allow_infinity=False) | st.integers() | st.text(), st.lists
)


@given(st.floats(allow_nan=False, allow_infinity=False), st.dictionaries(st.text(), _VALUES))
def test_a_text_gives_the_numbers_and_values_that_python_reads_from_it(number: float, values: dict[str, Any]) -> None:
    teleport = json.dumps({"type": "teleport", "x": number, "y": -number})
    assert decode_command(teleport) == TeleportCommand(json.loads(teleport)["x"], json.loads(teleport)["y"])
    text = json.dumps({"values": values, "type": "parameters"})
    read: Any = decode_command(text)
    assert repr(read.values) == repr(json.loads(text)["values"]), "the types of numbers too"


def test_a_refusal_says_what_is_expected() -> None:
    with pytest.raises(ProtocolError) as refused:
        command_of({"type": "why", "row": 0, "col": 0, "epoch": 1, "until": "all"})
    assert refused.value.code == "command.until"
    assert refused.value.message.endswith("Expected a whole number or null, got a string.")


@pytest.mark.parametrize("read", [command_of, lambda fields: decode_command(json.dumps(fields))])
def test_wrong_values_are_left_to_the_table_of_parameters(read: Callable[[object], object]) -> None:
    given: Any = {"window": None, "model": [3], "resolution": 2**70}
    assert read({"type": "parameters", "values": given}) == ParametersCommand(given)


def test_a_place_has_all_of_its_coordinates() -> None:
    assert place_of(VoxelCommand()) is None
    assert place_of(VoxelCommand(x=1.0, y=2.0, z=3.0)) == (1.0, 2.0, 3.0)
    with pytest.raises(ProtocolError, match='needs a "y"'):
        place_of(GoalCommand(x=1.0))


def test_values_that_json_cannot_represent_are_a_defect() -> None:
    told = json.loads(encode_text(Trajectories([], None)))
    assert told == {"type": "trajectories", "trajectories": [], "compared": None}
    with pytest.raises(ValueError, match="JSON"):
        encode_text(NotesMessage(float("nan")))
