"""The stream's commands about one cell of a map; the answers may also be shown to a class."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct

from server.stream.message_parts import Whole


class InspectCommand(Struct, tag_field="type", tag="inspect"):
    """Request the state of one cell; answered with `cell`."""

    row: Annotated[Whole, Meta(description="row of the cell")]
    col: Annotated[Whole, Meta(description="column of the cell")]
    epoch: Annotated[Whole, Meta(description="epoch of that map's geometry")]
    layer: Annotated[str, Meta(description="name of the layer of that map")] = "map"


class WhyCommand(Struct, tag_field="type", tag="why"):
    """Request the contributions to a cell; answered with `why`. Of several in a tick only the last is answered."""

    row: Annotated[Whole, Meta(description="row of the cell")]
    col: Annotated[Whole, Meta(description="column of the cell")]
    epoch: Annotated[Whole, Meta(description="epoch of that map's geometry")]
    until: Annotated[Whole | None, Meta(description="last contribution to describe, from 1; null: the newest")] = None
    layer: Annotated[str, Meta(description="name of the layer of that map")] = "map"


COMMANDS = (InspectCommand, WhyCommand)
