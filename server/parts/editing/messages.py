"""The stream's commands and message of an edited map."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct

from server.stream.message_parts import Number, Point, Whole


class MapEditCommand(Struct, tag_field="type", tag="map_edit"):
    """Maps: edit the map; see `mapper.editing`. Points are in the coordinates after the earlier edits."""

    op: Annotated[str, Meta(description="paint, fill, keepout, speed, despeckle, rotate, crop or origin")]
    points: Annotated[
        list[Point] | None,
        Meta(description="paint: the line; fill, keepout, speed: the corners; crop: two corners; origin: the place"),
    ] = None
    state: Annotated[str | None, Meta(description="paint and fill: free, occupied or unknown")] = None
    width: Annotated[Number | None, Meta(description="paint: width of the brush, m")] = None
    value: Annotated[
        Number | None,
        Meta(description="keepout and speed: value of the filter's mask, 1 to 100, 0 for none; despeckle: most cells"),
    ] = None
    angle: Annotated[Number | None, Meta(description="rotate: by this; origin: its heading, rad")] = None


class MapHistoryCommand(Struct, tag_field="type", tag="map_history"):
    """Maps: undo edits, or redo them."""

    steps: Annotated[Whole, Meta(description="negative: number of steps to undo; positive: to redo")]


class MapEditsMessage(Struct, tag_field="type", tag="map_edits"):
    """Maps: the edits so far."""

    n: Annotated[int, Meta(description="number of edits that are not undone")]
    undone: Annotated[int, Meta(description="number of edits that are undone")]
    last: Annotated[list[str], Meta(description="the last of the edits, oldest first, a phrase each")]
    keepout_cells: Annotated[int, Meta(description="cells of keepout zones")]
    speed_cells: Annotated[int, Meta(description="cells with a speed limit")]
    notes: Annotated[list[str], Meta(description="what the reader of the map noted")]


COMMANDS = (MapEditCommand, MapHistoryCommand)
MESSAGES = (MapEditsMessage,)
