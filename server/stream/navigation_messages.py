"""The messages of localization, costmaps, paths and map editing, a part of :mod:`server.stream.messages`."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct

from server.stream.message_parts import (
    BrushStroke,
    LayerCost,
    Point,
    Pose,
    Values,
)


class LocalizationMessage(Struct, tag_field="type", tag="localization"):
    """Estimate of the particle filter; in a simulation, with its error."""

    is_on: Annotated[bool, Meta(description="whether the robot is localized")]
    map: Annotated[str, Meta(description="of a simulation: plan, moved or other, as the command localize has it")]
    values: Annotated[Values, Meta(description="localization parameters that differ from the first ones")]
    pose: Annotated[Pose | None, Meta(description="the best estimate")]
    at: Annotated[Pose | None, Meta(description="the pose, in a simulation the true one, that it is an estimate of")]
    covariance: Annotated[
        tuple[float, float, float, float] | None,
        Meta(
            description="variances of the estimate: xx, xy, yy in m², yaw in rad²",
            extra={"labels": ("xx", "xy", "yy", "yaw")},
        ),
    ]
    is_converged: Annotated[bool, Meta(description="whether the particles agree on one place")]
    share: Annotated[float, Meta(description="weight of the heaviest cluster, 0 to 1")]
    fit: Annotated[float, Meta(description="how well the last scan that was used fits, 0 to 1")]
    entropy: Annotated[float, Meta(description="of the histogram of particles in bins of 0.5 m and 10°, bits")]
    n_particles: Annotated[int, Meta(description="number of particles")]
    n_updates: Annotated[int, Meta(description="scans that were used")]
    error_m: Annotated[float | None, Meta(description="distance of the estimate from the true pose, m")]
    error_rad: Annotated[float | None, Meta(description="its error in heading, rad")]


class CostmapMessage(Struct, tag_field="type", tag="costmap"):
    """The costmap over the map of a simulation or a log."""

    is_on: Annotated[bool, Meta(description="whether there is one")]
    values: Annotated[Values, Meta(description="navigation parameters")]
    footprint: Annotated[list[Point], Meta(description="corners of the robot's outline, in its frame, without padding")]
    inscribed_radius: Annotated[float, Meta(description="of the padded outline, m")]
    circumscribed_radius: Annotated[float, Meta(description="of the padded outline, m")]
    keepout: Annotated[list[BrushStroke], Meta(description="all that is painted")]


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


class CostMessage(Struct, tag_field="type", tag="cost"):
    """Answer to `cost`: what each layer says of a cell, bottom first."""

    x: Annotated[float, Meta(description="the place that was asked for, m")]
    y: Annotated[float, Meta(description="the place that was asked for, m")]
    layers: Annotated[list[LayerCost], Meta(description="one for each layer that is on")]
    speed: Annotated[str | None, Meta(description="the speed limit there, a sentence; null: none is painted")]


class MapEditsMessage(Struct, tag_field="type", tag="map_edits"):
    """Maps: the edits so far."""

    n: Annotated[int, Meta(description="number of edits that are not undone")]
    undone: Annotated[int, Meta(description="number of edits that are undone")]
    last: Annotated[list[str], Meta(description="the last of the edits, oldest first, a phrase each")]
    keepout_cells: Annotated[int, Meta(description="cells of keepout zones")]
    speed_cells: Annotated[int, Meta(description="cells with a speed limit")]
    notes: Annotated[list[str], Meta(description="what the reader of the map noted")]


class Nav2Message(Struct, tag_field="type", tag="nav2"):
    """Answer to `nav2`."""

    text: Annotated[str | None, Meta(description="a Nav2 parameter file; null: the parameters were set")]
