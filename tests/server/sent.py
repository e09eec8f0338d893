"""Messages of sessions as pages receive them."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

from msgspec import Struct

from server.stream.protocol import encode_text


def sent(messages: Iterable[Struct]) -> list[dict[str, Any]]:
    """The messages as JSON has them."""
    return [sent_one(message) for message in messages]


def sent_one(message: Struct) -> dict[str, Any]:
    """The message as JSON has it."""
    plain: dict[str, Any] = json.loads(encode_text(message))
    return plain
