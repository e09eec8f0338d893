"""The stream's commands and messages of a costmap."""

from __future__ import annotations

from typing import Annotated

from msgspec import UNSET, Meta, Struct, UnsetType

from server.stream.message_parts import BrushStroke, LayerCost, Number, Point, UncheckedValues, Values


class CostmapCommand(Struct, tag_field="type", tag="costmap"):
    """Simulations and logs: begin a costmap over the robot's map, change it, or end it. Omitted fields are kept."""

    value: Annotated[bool | UnsetType, Meta(description="false: end it")] = UNSET
    values: Annotated[UncheckedValues, Meta(description="navigation parameters to change")] = {}
    footprint: Annotated[list[Point] | None, Meta(description="corners of the robot's outline, in its frame")] = None
    keepout: Annotated[list[BrushStroke] | None, Meta(description="all that is painted; replaces the earlier")] = None


class CostCommand(Struct, tag_field="type", tag="cost"):
    """Sessions with a costmap: ask why a cell has its cost; answered with `cost`."""

    x: Annotated[Number, Meta(description="x in the map frame, m")]
    y: Annotated[Number, Meta(description="y in the map frame, m")]


class Nav2Command(Struct, tag_field="type", tag="nav2"):
    """Sessions with a costmap: ask for its parameters as a Nav2 parameter file, or set them from one."""

    text: Annotated[str | None, Meta(description="a Nav2 parameter file; null: answer with one")] = None


class CostmapMessage(Struct, tag_field="type", tag="costmap"):
    """The costmap over the map of a simulation or a log."""

    is_on: Annotated[bool, Meta(description="whether there is one")]
    values: Annotated[Values, Meta(description="navigation parameters")]
    footprint: Annotated[list[Point], Meta(description="corners of the robot's outline, in its frame, without padding")]
    inscribed_radius: Annotated[float, Meta(description="of the padded outline, m")]
    circumscribed_radius: Annotated[float, Meta(description="of the padded outline, m")]
    keepout: Annotated[list[BrushStroke], Meta(description="all that is painted")]


class CostMessage(Struct, tag_field="type", tag="cost"):
    """Answer to `cost`: what each layer says of a cell, bottom first."""

    x: Annotated[float, Meta(description="the place that was asked for, m")]
    y: Annotated[float, Meta(description="the place that was asked for, m")]
    layers: Annotated[list[LayerCost], Meta(description="one for each layer that is on")]
    speed: Annotated[str | None, Meta(description="the speed limit there, a sentence; null: none is painted")]


class Nav2Message(Struct, tag_field="type", tag="nav2"):
    """Answer to `nav2`."""

    text: Annotated[str | None, Meta(description="a Nav2 parameter file; null: the parameters were set")]


COMMANDS = (CostmapCommand, CostCommand, Nav2Command)
MESSAGES = (CostmapMessage, CostMessage, Nav2Message)
