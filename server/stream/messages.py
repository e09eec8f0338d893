"""The text messages from the server to the browser, each defined once.

:mod:`server.stream.generate` writes the JSON Schema, the TypeScript types and validators, and ``docs/wire.md`` from
these classes and those of the parts (:mod:`server.parts.wire`). A field whose default is ``UNSET`` may be omitted.
Angles are in radians, lengths in metres, times in seconds; poses are ``[x, y, yaw]`` in the map frame.
"""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import UNSET, Meta, Struct, UnsetType

from server.stream.message_parts import (
    Block,
    CameraName,
    CellState,
    Compared,
    Contribution,
    Edits,
    LayerInfo,
    LogInfo,
    Parameter,
    Point,
    Pose,
    RobotCameraName,
    Segment,
    Table,
    TrajectoryInfo,
    Values,
)


class Hello(Struct, tag_field="type", tag="hello"):
    """First message of a connection: description of the session."""

    protocol: Annotated[str, Meta(description="name of the protocol, `gridbloom.v3`")]
    session: Annotated[str, Meta(description="id of the session")]
    kind: Annotated[
        str,
        Meta(
            description="`simulation`: a simulated robot; `log`: a recording; `costmaps`, `map`; `volume`: a map in 3D"
        ),
    ]
    title: Annotated[str, Meta(description="title of the world or log")]
    epoch_id: Annotated[str, Meta(description="changes when the server restarts or the session is created again")]
    speeds: Annotated[
        tuple[float, float],
        Meta(description="least and greatest playback speed", extra={"labels": ("least", "greatest")}),
    ]
    parameters: Annotated[Table, Meta(description="mapping parameters")]
    sensor: Annotated[Table | None, Meta(description="parameters of the simulated sensor; null if there is none")]
    log: Annotated[LogInfo | None, Meta(description="the log; null if there is none")]
    tables: Annotated[
        dict[str, list[Parameter]],
        Meta(description="parameters of the parts of the session, by the type of the command that sets them"),
    ]
    world: Annotated[str | UnsetType, Meta(description="simulations: name of the world")] = UNSET
    seed: Annotated[
        int | UnsetType,
        Meta(description="simulations: seed; the same seed and commands give the same scans"),
    ] = UNSET


class ForeignHello(Struct, tag_field="type", tag="hello"):
    """The whole message to a page with another protocol version, which makes the page reload."""

    protocol: str


class LayersMessage(Struct, tag_field="type", tag="layers"):
    """The layers of the session. Sent at the start and after a change."""

    layers: Annotated[list[LayerInfo], Meta(description="the layers; without a subscription the first is sent")]


class Geometry(Struct, tag_field="type", tag="geometry"):
    """The grid to which the tiles of an epoch belong. Tiles of another epoch are ignored.

    Sent before the first tiles of an epoch, for each grid that the page has subscribed to.
    """

    layer: Annotated[int, Meta(description="id of the layer")]
    epoch: Annotated[int, Meta(description="number of the epoch; grows with each new geometry")]
    resolution: Annotated[float, Meta(gt=0, description="side of a cell, m")]
    rows: Annotated[int, Meta(description="cells along y")]
    cols: Annotated[int, Meta(description="cells along x")]
    origin: Annotated[Pose, Meta(description="pose of the outer corner of cell (0, 0) in the map frame")]
    low: Annotated[float, Meta(description="value of -127 in a tile")]
    high: Annotated[float, Meta(description="value of +127 in a tile")]
    tile: Annotated[Literal[64], Meta(description="cells along the side of a tile")]


class ScanFields(Struct, kw_only=True):
    """The fields of :class:`FrameMessage` about the newest scan."""

    scan_pose: Annotated[
        Pose | UnsetType, Meta(description="T_map_laser at the newest scan, without the mount correction")
    ] = UNSET
    believed_scan_pose: Annotated[
        Pose | UnsetType, Meta(description="estimate of `scan_pose` that the map uses; only while the odometry drifts")
    ] = UNSET
    ranges: Annotated[
        list[float | None] | UnsetType,
        Meta(description="readings of the newest scan, m; null for no return or no valid reading"),
    ] = UNSET
    angle_min: Annotated[float | UnsetType, Meta(description="bearing of the first beam, rad")] = UNSET
    angle_increment: Annotated[float | UnsetType, Meta(description="angle between two beams, rad")] = UNSET
    bearings: Annotated[
        list[float] | UnsetType, Meta(description="bearing of each beam if they are uneven (sonars), rad")
    ] = UNSET
    beam_width: Annotated[float | UnsetType, Meta(description="full angle of a sonar's cone, rad")] = UNSET
    range_max: Annotated[float | UnsetType, Meta(description="largest range that is used, m")] = UNSET


class FrameMessage(ScanFields, tag_field="type", tag="frame", kw_only=True):
    """Newest state of the session, sent directly before the tiles of the same instant.

    The fields of the scan (`scan_pose`, `believed_scan_pose`, `ranges`, `angle_min`, `angle_increment`, `bearings`,
    `beam_width`, `range_max`) are sent only with a new scan. If `ranges` is missing, all of them are unchanged.
    """

    t: Annotated[float, Meta(description="monotonic clock of the server, s; for measuring the age of the frame")]
    playing: Annotated[bool, Meta(description="whether the session plays")]
    speed: Annotated[float, Meta(description="playback speed; 1 is real time")]
    index: Annotated[int, Meta(description="scans in the map")]
    count: Annotated[int, Meta(description="scans in total")]
    stamp: Annotated[float, Meta(description="simulated or recorded time of the state, s")]
    pose: Annotated[Pose, Meta(description="T_map_base now")]
    sensor_pose: Annotated[Pose, Meta(description="T_map_laser now, without the mount correction of the parameters")]
    auto: Annotated[bool, Meta(description="whether the robot explores by itself")]
    believed_pose: Annotated[
        Pose | UnsetType, Meta(description="estimate of `pose` that the map uses; only while the odometry drifts")
    ] = UNSET
    remade_ms: Annotated[
        float | UnsetType, Meta(description="time in which the map was last recomputed with other parameters, ms")
    ] = UNSET


class Trajectory(Struct, tag_field="type", tag="trajectory"):
    """Log sessions: the robot's path. Sent at the start and after a change of the trajectory."""

    name: Annotated[str, Meta(description="name of the trajectory")]
    frame: Annotated[str | None, Meta(description="frame of the poses and of the map; null where the log names none")]
    every: Annotated[int, Meta(description="a point for each `every`-th scan")]
    poses: Annotated[list[Point], Meta(description="position of the base at those scans")]
    stamps: Annotated[list[float], Meta(description="recorded time at those scans, from the first scan, s")]


class ParametersMessage(Struct, tag_field="type", tag="parameters"):
    """Current parameters, sent after each change and after a refused change."""

    values: Annotated[Values, Meta(description="mapping parameters")]
    sensor: Annotated[Values | None, Meta(description="simulated sensor; null if there is none")]
    faults: Annotated[Values | UnsetType, Meta(description="simulations: faults that affect the map")] = UNSET
    compare: Annotated[Compared | UnsetType | None, Meta(description="the second map; null if there is none")] = UNSET


class Trajectories(Struct, tag_field="type", tag="trajectories"):
    """Log sessions: the trajectories of the log, after one was added, replaced or deleted."""

    trajectories: Annotated[list[TrajectoryInfo], Meta(description="all trajectories of the log")]
    compared: Annotated[
        tuple[str, str] | None,
        Meta(description="reference and estimate whose errors are told first; null for one trajectory"),
    ]


class WorldMessage(Struct, tag_field="type", tag="world"):
    """Simulations: the true walls and boxes. Sent at the start and after a change."""

    name: Annotated[str, Meta(description="name of the world")]
    title: Annotated[str, Meta(description="title of the world")]
    names: Annotated[list[str], Meta(description="all worlds, as the command `world` takes them")]
    bounds: Annotated[
        tuple[float, float, float, float],
        Meta(description="[x0, y0, x1, y1], m", extra={"labels": ("x0", "y0", "x1", "y1")}),
    ]
    polygons: Annotated[list[list[Point]], Meta(description="outlines of the solids")]
    ids: Annotated[
        list[int], Meta(description="of each polygon: index of the built solid, or -1 - its index in `added`")
    ]
    edits: Annotated[Edits, Meta(description="edits of the world")]
    polished: Annotated[list[Segment], Meta(description="faces that give no return while the fault `specular` is on")]
    blocks: Annotated[list[Block], Meta(description="solids with heights of their own")] = []


class Forgetting(Struct, tag_field="type", tag="forgetting"):
    """Simulations: how two maps, with and without clamping, forget what an `edit` with `watch` erased."""

    cells: Annotated[int, Meta(description="occupied cells of what was erased; 0: nothing is watched")]
    scans: Annotated[int, Meta(description="scans since then")]
    with_clamp: Annotated[
        int | None, Meta(description="scans after which 9 in 10 of the cells were free with clamping; null: not yet")
    ]
    without_clamp: Annotated[int | None, Meta(description="the same without clamping")]
    free_with_clamp: Annotated[float, Meta(description="share of the cells that are free with clamping, 0 to 1")]
    free_without_clamp: Annotated[float, Meta(description="the same without clamping")]


class WorkingMessage(Struct, tag_field="type", tag="working"):
    """Progress of a computation that takes more than 0.3 s. Sent four times a second until it has ended."""

    elapsed_s: Annotated[float | None, Meta(description="time since its start, s; null: it has ended")]
    fraction: Annotated[float | None, Meta(description="share that is done, 0 to 1; null if not known")]
    what: Annotated[
        str,
        Meta(description="`map`, or what a part computes, such as `costmap`; its words are in the page"),
    ] = "map"


class NoticeMessage(Struct, tag_field="type", tag="notice"):
    """A notice to the user, such as the end of the log."""

    code: Annotated[str, Meta(description="stable name of the notice")]
    message: Annotated[str, Meta(description="one sentence")]


class ErrorMessage(Struct, tag_field="type", tag="error"):
    """The last command was refused, or the session had an error. The connection stays open."""

    code: Annotated[str, Meta(description="stable name of the error")]
    message: Annotated[str, Meta(description="one sentence")]
    detail: Annotated[None, Meta(description="reserved")] = None


class CellMessage(Struct, tag_field="type", tag="cell"):
    """Answer to `inspect`: one cell."""

    row: Annotated[int, Meta(description="row of the cell")]
    col: Annotated[int, Meta(description="column of the cell")]
    epoch: Annotated[int, Meta(description="epoch of the geometry")]
    x: Annotated[float, Meta(description="x of the cell's centre in the map frame, m")]
    y: Annotated[float, Meta(description="y of the cell's centre in the map frame, m")]
    observed: Annotated[bool, Meta(description="whether any beam has updated the cell")]
    log_odds: Annotated[float, Meta(description="log-odds of being occupied")]
    p_occ: Annotated[float, Meta(description="probability of being occupied")]
    state: Annotated[CellState, Meta(description="state by the thresholds of the map")]
    layer: Annotated[str, Meta(description="name of the layer of that map")]


class WhyMessage(Struct, tag_field="type", tag="why"):
    """Answer to `why`: the beams that updated a cell in the map of `index` scans."""

    row: Annotated[int, Meta(description="row of the cell")]
    col: Annotated[int, Meta(description="column of the cell")]
    epoch: Annotated[int, Meta(description="epoch of the geometry")]
    index: Annotated[int, Meta(description="scans in the map")]
    log_odds: Annotated[float, Meta(description="log-odds of the cell")]
    prior: Annotated[float, Meta(description="log-odds of a cell before any scan")]
    log_odds_min: Annotated[float | None, Meta(description="lower clamping limit; null without clamping")]
    log_odds_max: Annotated[float | None, Meta(description="upper clamping limit; null without clamping")]
    per_scan: Annotated[bool, Meta(description="whether each scan counts once")]
    total: Annotated[int, Meta(description="beams that updated the cell")]
    hits: Annotated[int, Meta(description="those that raised its log-odds")]
    outweighed: Annotated[int, Meta(description="those that count for nothing, as their scans hit the cell")]
    first_scan: Annotated[int | None, Meta(description="index of the first scan that updated it")]
    curve: Annotated[
        list[tuple[int, float]],
        Meta(description="[n, log-odds] over all contributions, at most 600 points; extremes are kept"),
    ]
    contributions: Annotated[list[Contribution], Meta(description="at most 300 contributions, up to the requested one")]
    layer: Annotated[str, Meta(description="name of the layer of that map")]


class PickedMessage(Struct, tag_field="type", tag="picked"):
    """Logs: the object that was clicked in a 3D view of the session. Sent to the page of that view."""

    what: Annotated[
        Literal["loop", "pose", "cell"],
        Meta(
            description="a loop of the pose graph, a pose of the path, which the map then goes to, or a cell of the map"
        ),
    ]
    x: Annotated[float, Meta(description="x of its place in the map frame, m")]
    y: Annotated[float, Meta(description="y of its place in the map frame, m")]
    yaw: Annotated[float | None, Meta(description="yaw of the pose, rad; null for others")]
    index: Annotated[int | None, Meta(description="scans up to that of the pose, itself included; null for others")]
    edge: Annotated[int | None, Meta(description="number of the loop's edge; null for others")]


class PlaceMessage(Struct, tag_field="type", tag="place"):
    """Answer to a click in a 3D view of a page that measures: the object at that place."""

    x: Annotated[float, Meta(description="x of the place in the map frame, m")]
    y: Annotated[float, Meta(description="y of the place in the map frame, m")]
    z: Annotated[float | None, Meta(description="height, m; null: a place of a plane map")]
    size: Annotated[
        float | None, Meta(description="side of the voxel there, m; 0: a measured point; null: a place of a plane map")
    ]


class SceneMessage(Struct, tag_field="type", tag="scene"):
    """Settings of the 3D view of the session, from when it is first opened."""

    cameras: Annotated[list[CameraName | RobotCameraName], Meta(description="places of the camera")]
    layers: Annotated[dict[str, bool], Meta(description="whether each layer is shown, by its label")]
    height: Annotated[float, Meta(description="height of the map's columns, of the default")]
    grid: Annotated[float, Meta(description="distance between two lines of the layer `Grid`, m")]


class Pong(Struct, tag_field="type", tag="pong"):
    """Answer to `ping`."""

    id: Annotated[int, Meta(description="id of the ping")]
    t: Annotated[float, Meta(description="monotonic clock of the server, s")]


MESSAGES = (
    Hello,
    LayersMessage,
    Geometry,
    FrameMessage,
    Trajectory,
    Trajectories,
    ParametersMessage,
    WorldMessage,
    Forgetting,
    WorkingMessage,
    NoticeMessage,
    ErrorMessage,
    CellMessage,
    WhyMessage,
    PickedMessage,
    PlaceMessage,
    SceneMessage,
    Pong,
)
