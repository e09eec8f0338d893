"""The objects and types contained in the text messages of :mod:`server.stream.messages`, each defined once."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from dataclasses import asdict, replace
from typing import Annotated, Any, Literal

from msgspec import UNSET, Meta, Struct, UnsetType
from msgspec.json import schema

from mapper.core.parameter import Parameter as TableRow

Number = Annotated[float, Meta(ge=-sys.float_info.max, le=sys.float_info.max)]
Whole = Annotated[int, Meta(ge=-(2**53), le=2**53)]
Pose = Annotated[
    tuple[float, float, float],
    Meta(title="Pose", description="[x, y, yaw] in m, m, rad", extra={"labels": ("x", "y", "yaw")}),
]
Point = Annotated[tuple[float, float], Meta(title="Point", description="[x, y] in m", extra={"labels": ("x", "y")})]
Place = Annotated[
    tuple[float, float, float],
    Meta(title="Place", description="[x, y, z] in m", extra={"labels": ("x", "y", "z")}),
]
Value = Annotated[float | str | bool, Meta(title="Value", description="value of a parameter")]
Values = Annotated[dict[str, Value], Meta(title="Values", description="parameters by name")]
#: unchecked values of a command; the parameter table validates them and names the invalid one
UncheckedValues = Annotated[
    dict[str, Any],
    Meta(title="Values", description="parameters by name", extra_json_schema={"additionalProperties": schema(Value)}),
]
CellState = Annotated[
    Literal["free", "unknown", "occupied"], Meta(title="CellState", description="state of a cell by its probability")
]
CameraName = Literal["overview", "above", "south", "west", "north", "east"]
RobotCameraName = Literal["follow", "first person"]
LayerKind = Annotated[
    Literal["grid", "points", "path", "graph"], Meta(title="LayerKind", description="kind of content of a layer")
]
DrawnSolid = Annotated[
    tuple[Literal["wall", "box"], int, int, int, int],
    Meta(
        title="DrawnSolid",
        description="wall from corner to corner, or axis-aligned box between two corners; cm in the map frame",
        extra={"labels": ("kind", "x0", "y0", "x1", "y1")},
    ),
]
Segment = Annotated[
    tuple[float, float, float, float],
    Meta(title="Segment", description="[ax, ay, bx, by] in m", extra={"labels": ("ax", "ay", "bx", "by")}),
]
Sides = Annotated[
    tuple[float, float],
    Meta(title="Sides", description="one number for each of two maps: [A, B]", extra={"labels": ("a", "b")}),
]
StateCounts = Annotated[tuple[int, int, int], Meta(title="StateCounts", description="cells by state in B")]


class Part(Struct):
    """Base class of the objects that messages contain."""


class Parameter(Part):
    """One row of a parameter table."""

    name: Annotated[str, Meta(description="key in the values")]
    label: Annotated[str, Meta(description="short name on the page")]
    group: Annotated[str, Meta(description="panel that shows it")]
    kind: Annotated[Literal["number", "choice", "flag"], Meta(description="which of the other fields apply")]
    initial: Annotated[Value, Meta(description="initial value")]
    sentence: Annotated[str, Meta(description="explanation, one sentence")]
    unit: Annotated[str, Meta(description="unit of a number; may be empty")]
    low: Annotated[float, Meta(description="least value of a number")]
    high: Annotated[float, Meta(description="greatest value of a number")]
    step: Annotated[float, Meta(description="step of a number's slider")]
    choices: Annotated[tuple[str, ...], Meta(description="values of a choice")]
    only_for: Annotated[tuple[str, ...], Meta(description="sensor models to which it applies; empty: all")]


def rows_of(table: Iterable[TableRow], first: object = None) -> list[Parameter]:
    """Return the rows of a parameter table; ``first`` has initial values that replace those of the rows."""
    return [
        Parameter(**asdict(row if first is None else replace(row, initial=getattr(first, row.name)))) for row in table
    ]


class Table(Part):
    """A parameter table and its current values."""

    table: Annotated[list[Parameter], Meta(description="one row for each parameter")]
    values: Annotated[Values, Meta(description="present values")]


class TrajectoryInfo(Part):
    """A trajectory of a log."""

    name: Annotated[str, Meta(description="name, as the command `trajectory` takes it")]
    description: Annotated[str, Meta(description="source of the poses")]
    from_scans: Annotated[bool, Meta(description="whether they were found from the scans, as by SLAM")]
    same_as: Annotated[str | None, Meta(description="trajectory before it with the same path; null for none")]


class LogInfo(Part):
    """The log of a log session."""

    id: Annotated[str, Meta(description="id in the library")]
    topic: Annotated[str, Meta(description='sensor of the map; " + " between several')]
    cut: Annotated[
        Table | None,
        Meta(description="how the scans are cut out of point clouds or depth images; null for those of a lidar"),
    ]
    trajectory: Annotated[str, Meta(description="trajectory of the map")]
    trajectories: Annotated[list[TrajectoryInfo], Meta(description="all trajectories of the log")]
    compared: Annotated[
        tuple[str, str] | None,
        Meta(description="reference and estimate whose errors are told first; null for one trajectory"),
    ]
    n_beams: Annotated[int, Meta(description="beams of each scan")]
    n_scans: Annotated[int, Meta(description="scans of the log")]
    duration_s: Annotated[
        float, Meta(description="recorded time from the earliest stamp to the latest, s; 0 for a log without times")
    ]
    format: Annotated[str, Meta(description="file format of the log")]
    notes: Annotated[list[str], Meta(description="remarks of the reader, one sentence each")]
    start_s: Annotated[
        float | None, Meta(description="earliest stamp, s since 1970; null for a clock that began elsewhere")
    ]


class Edits(Part):
    """Edits of a world."""

    added: Annotated[list[DrawnSolid], Meta(description="solids that were drawn")]
    erased: Annotated[list[int], Meta(description="indices of the built solids that were erased")]


class Block(Part):
    """A solid of a world with heights of its own, such as a low table or a lintel."""

    outline: Annotated[list[Point], Meta(description="its corners seen from above")]
    low: Annotated[float, Meta(description="height of its bottom, m")]
    high: Annotated[float, Meta(description="height of the highest point of its top, m")]


class Compared(Part):
    """The parameters of the second map of a session that differ from those of the first."""

    values: Annotated[Values, Meta(description="parameters in which it differs")]
    with_faults: Annotated[bool, Meta(description="whether the robot's faults affect it")]
    trajectory: Annotated[str | UnsetType, Meta(description="log sessions: trajectory of the second map")] = UNSET
    log: Annotated[
        str | UnsetType | None, Meta(description="log sessions: id of its log; null for the session's own log")
    ] = UNSET
    topic: Annotated[str | UnsetType | None, Meta(description="log sessions: topic of its scans")] = UNSET
    title: Annotated[str | UnsetType, Meta(description="log sessions: title of its log")] = UNSET


class BrushStroke(Part):
    """A stroke of the brush that paints keepout zones and speed limits."""

    width: Annotated[float, Meta(gt=0, le=5, description="width of the brush, m")]
    erases: Annotated[bool, Meta(description="whether it erases")]
    points: Annotated[list[Point], Meta(description="places of the brush's middle, at least one")]
    speed: Annotated[
        int | UnsetType | None, Meta(description="value of the speed filter's mask, 1 to 100; null: a keepout zone")
    ] = UNSET


class LayerCost(Part):
    """Contribution of one layer of a costmap to a cell."""

    layer: Annotated[str, Meta(description="name of the layer")]
    cost: Annotated[int, Meta(description="its own cost there, 255: none")]
    master: Annotated[int, Meta(description="cost of the costmap after it")]
    sentence: Annotated[str, Meta(description="why, one sentence")]


class Numbers(Part):
    """Comparison of two maps on one lattice, A being the second map and B the first; see `mapper.grid.compare`."""

    cells: Annotated[int, Meta(description="cells compared")]
    states: Annotated[
        tuple[StateCounts, StateCounts, StateCounts],
        Meta(description="states[i][j]: cells with state i in A and j in B; order free, occupied, unknown"),
    ]
    same: Annotated[int, Meta(description="cells with the same state in A and B")]
    only: Annotated[Sides, Meta(description="cells observed only in A, only in B")]
    both: Annotated[int, Meta(description="cells observed in both")]
    entropy_bits: Annotated[Sides, Meta(description="entropy of each map, bits")]
    contrast: Annotated[Sides, Meta(description="contrast of each map")]
    mean_difference: Annotated[float, Meta(description="mean absolute difference of the probabilities")]
    max_difference: Annotated[float, Meta(description="greatest absolute difference of the probabilities")]
    max_at: Annotated[Point | None, Meta(description="centre of that cell; null if the maps do not differ")]


class Contribution(Part):
    """The contribution of one beam to a cell."""

    n: Annotated[int, Meta(description="number of the contribution, from 1")]
    scan: Annotated[int, Meta(description="index of the scan, from 0")]
    stamp: Annotated[float, Meta(description="recorded time of the scan, s")]
    beam: Annotated[int, Meta(description="index of the beam, from 0")]
    pose: Annotated[Pose, Meta(description="T_map_laser with the mount correction of the parameters")]
    bearing: Annotated[float, Meta(description="angle of the beam from the sensor's x axis, rad")]
    range: Annotated[float | None, Meta(description="reading, m; null for no return")]
    hit: Annotated[bool, Meta(description="whether it raised the log-odds")]
    increment: Annotated[float, Meta(description="log-odds added")]
    log_odds: Annotated[float, Meta(description="log-odds of the cell afterwards, clamped")]
    sensor: Annotated[str | UnsetType, Meta(description="its topic, where several sensors make the map")] = UNSET
    outweighed: Annotated[
        bool | UnsetType, Meta(description="true for a miss that counts for nothing, as its scan hits the cell")
    ] = UNSET


class LayerInfo(Part):
    """One of the layers of a session."""

    id: Annotated[int, Meta(description="`layer` of its binary frames, from 1")]
    name: Annotated[str, Meta(description="name, as the commands take it")]
    kind: Annotated[LayerKind, Meta(description="kind of its content")]
    title: Annotated[str, Meta(description="title on the page")]
    style: Annotated[str, Meta(description="how the page paints it: a palette of grids, or an overlay")]
    columns: Annotated[
        list[str], Meta(description="names of the columns of its table: `x`, `y` and more; empty for a grid")
    ]


class ColourScale(Part):
    """The values at the ends of a colour scale. Values beyond them have the colours of the ends."""

    low: Annotated[float, Meta(description="at the beginning")]
    high: Annotated[float, Meta(description="at the end")]
    unit: Annotated[
        str, Meta(description="`m`; `s` after the first scan; `scan`: its number; empty: as the file states it")
    ]


class VolumeChanges(Part):
    """Differences between the map of a session in 3D, B, and another one, A."""

    title: Annotated[str, Meta(description="of A")]
    appeared: Annotated[int, Meta(description="voxels that are free in A and occupied in B")]
    vanished: Annotated[int, Meta(description="voxels that are occupied in A and free in B")]
    same: Annotated[int, Meta(description="voxels with one state in both")]
    only_first: Annotated[int, Meta(description="voxels that only A knows")]
    only_second: Annotated[int, Meta(description="voxels that only B knows")]


class VoxelPoint(Struct):
    """The measured point in a voxel that is nearest to the line of sight, or to the queried place."""

    place: Annotated[Place, Meta(description="where it is, m")]
    scan: Annotated[int, Meta(description="number of its scan, from 1")]
    values: Annotated[dict[str, list[float]], Meta(description="what is known of it: intensity, class, rgb")]
    count: Annotated[int, Meta(description="points in the voxel")]


class VoxelUpdate(Part):
    """Update of a voxel by one scan."""

    scan: Annotated[int, Meta(description="number of the scan, from 1")]
    hit: Annotated[bool, Meta(description="whether a beam ended in it; else beams passed it")]
    beams: Annotated[int, Meta(description="how many, at most 64")]
    before: Annotated[float | None, Meta(description="log-odds before; null: unknown")]
    after: Annotated[float, Meta(description="log-odds after")]


class SurfaceUpdate(Part):
    """Update of a voxel of a surface by one scan."""

    scan: Annotated[int, Meta(description="number of the scan, from 1")]
    measured: Annotated[float, Meta(description="signed distance that it measured, m, cut at the truncation")]
    added: Annotated[float, Meta(description="weight of the measurement")]
    before: Annotated[float | None, Meta(description="mean distance before, m; null: unknown")]
    after: Annotated[float, Meta(description="mean distance after, m")]
    weight: Annotated[float, Meta(description="weight of the mean after")]
