"""The stream's command and message of a path."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct

from server.stream.message_parts import Number, Point


class GoalCommand(Struct, tag_field="type", tag="goal"):
    """Sessions with a costmap: set the goal of the path, and whether the robot drives along it."""

    x: Annotated[Number | None, Meta(description="x in the map frame, m; null: no goal")] = None
    y: Annotated[Number | None, Meta(description="y in the map frame, m")] = None
    drives: Annotated[bool | None, Meta(description="whether it drives; null: as before")] = None


class PathMessage(Struct, tag_field="type", tag="path"):
    """Sessions with a costmap: the path to the goal; its points are in the layer `plan`."""

    goal: Annotated[Point | None, Meta(description="the goal; null: there is none")]
    drives: Annotated[bool, Meta(description="whether the robot drives along it")]
    length: Annotated[float | None, Meta(description="length, m; null: there is no path")]
    cost: Annotated[float | None, Meta(description="sum of the costs of its steps; null: there is no path")]
    travel_s: Annotated[
        float | None,
        Meta(
            description="time along it at the desired velocity, less where speed limits are, s; null: there is no path"
        ),
    ]
    reaches_goal: Annotated[bool, Meta(description="whether it ends at the goal")]
    reason: Annotated[str | None, Meta(description="why there is no path, or why it ends before the goal")]
    carrot: Annotated[Point | None, Meta(description="the point ahead that the robot aims at")]
    plan_ms: Annotated[float, Meta(description="duration of the planning, ms")]
    speed_limit: Annotated[str | None, Meta(description="the painted speed limit at the robot, in words; null: none")]


COMMANDS = (GoalCommand,)
MESSAGES = (PathMessage,)
