"""The stream's message about a comparison."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct

from server.stream.message_parts import Numbers


class ComparisonMessage(Struct, tag_field="type", tag="comparison"):
    """Log sessions: comparison of the map, B, with the second map, A. Both fields are null without a comparison."""

    index: Annotated[int, Meta(description="scans in the map")]
    refused: Annotated[str | None, Meta(description="reason why the maps cannot be compared, one sentence")]
    numbers: Annotated[Numbers | None, Meta(description="the comparison")]


MESSAGES = (ComparisonMessage,)
