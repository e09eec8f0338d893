"""The commands of every session from the browser to the server, each defined once; see :mod:`server.stream.messages`.

Commands of parts are in the folders of the parts; :mod:`server.parts.wire` lists all of them. Fields with a default may
be omitted. Unknown fields are ignored.
"""

from __future__ import annotations

from typing import Annotated

from msgspec import UNSET, Meta, Struct, UnsetType

from server.stream.message_parts import DrawnSolid, Number, Place, Point, UncheckedValues, Whole


class AckCommand(Struct, tag_field="type", tag="ack"):
    """Acknowledge that the binary frames up to `seq` were painted."""

    seq: Annotated[Whole, Meta(description="number of the newest such frame")]


class ResumeCommand(Struct, tag_field="type", tag="resume"):
    """After a reconnect, before `subscribe`: the tiles of a grid that the page still has. Only newer ones are sent."""

    epoch_id: Annotated[str, Meta(description="of the `hello` of the earlier connection")]
    layer: Annotated[str, Meta(description="name of the grid")]
    epoch: Annotated[Whole, Meta(description="epoch of the tiles")]
    revision: Annotated[Whole, Meta(description="all tiles up to this revision were received")]


class SubscribeCommand(Struct, tag_field="type", tag="subscribe"):
    """Set the layers to send from now on. Without it the first layer is sent."""

    layers: Annotated[list[str], Meta(description="names of all layers that are wanted", max_length=64)]


class SelectCommand(Struct, tag_field="type", tag="select"):
    """Mark a place on the map in the 3D views of this page."""

    place: Annotated[Point | None, Meta(description="the place; null for none")] = None


class MeasureCommand(Struct, tag_field="type", tag="measure"):
    """Draw this page's measurement in its 3D views, where each click is then answered with `place`."""

    points: Annotated[
        Annotated[list[Place], Meta(max_length=1000)] | None,
        Meta(description="the points so far, map metres; null: nothing is measured"),
    ] = None
    closed: Annotated[bool, Meta(description="whether the last is joined to the first: a polygon")] = False


class PlayCommand(Struct, tag_field="type", tag="play"):
    """Start playing."""


class PauseCommand(Struct, tag_field="type", tag="pause"):
    """Pause."""


class RestartCommand(Struct, tag_field="type", tag="restart"):
    """Restart with an empty map."""


class StepCommand(Struct, tag_field="type", tag="step"):
    """Pause, and step forward or back by some scans."""

    scans: Annotated[Whole, Meta(description="number of scans; negative: back")] = 1


class SpeedCommand(Struct, tag_field="type", tag="speed"):
    """Set the playback speed."""

    value: Annotated[Number, Meta(description="within `speeds` of `hello`; 1 is real time")]


class SeekCommand(Struct, tag_field="type", tag="seek"):
    """Log sessions: seek the map after a number of scans."""

    index: Annotated[Whole, Meta(description="number of scans in the map, 0 to that of the log")]


class CancelCommand(Struct, tag_field="type", tag="cancel"):
    """Log sessions: cancel the current computation. A seek stops where it is; parameters are restored."""


class ParametersCommand(Struct, tag_field="type", tag="parameters"):
    """Change mapping parameters and recompute the map."""

    values: Annotated[UncheckedValues, Meta(description="new values; the others stay")]


class SensorCommand(Struct, tag_field="type", tag="sensor"):
    """Simulations: change the simulated sensor."""

    values: Annotated[UncheckedValues, Meta(description="new values; the others stay")]


class FaultsCommand(Struct, tag_field="type", tag="faults"):
    """Simulations: set which faults of the robot affect the map. The whole map is recomputed."""

    values: Annotated[UncheckedValues, Meta(description="`drift`, `specular`: true or false")]


class CompareCommand(Struct, tag_field="type", tag="compare"):
    """Simulations: make a second map of the same recording. For logs use `PUT /api/sessions/{id}/compare`."""

    values: Annotated[
        UncheckedValues | None, Meta(description="parameters in which it differs; null: no second map")
    ] = None


class TeleportCommand(Struct, tag_field="type", tag="teleport"):
    """Simulations: place the robot; a position inside a wall is replaced by the nearest free one."""

    x: Annotated[Number, Meta(description="x in the map frame, m")]
    y: Annotated[Number, Meta(description="y in the map frame, m")]
    yaw: Annotated[Number | None, Meta(description="heading, rad; null: unchanged")] = None


class DriveCommand(Struct, tag_field="type", tag="drive"):
    """Simulations: drive by hand. The speed is held for 0.5 s."""

    linear: Annotated[Number, Meta(description="forward speed, m/s")]
    angular: Annotated[Number, Meta(description="turn rate, rad/s, positive to the left")]


class AutoCommand(Struct, tag_field="type", tag="auto"):
    """Simulations: switch the robot's own exploration on or off."""

    value: Annotated[bool, Meta(description="whether it explores")] = False


class EditCommand(Struct, tag_field="type", tag="edit"):
    """Simulations: set all edits of the world; they replace the earlier ones."""

    added: Annotated[list[DrawnSolid], Meta(description="walls and boxes to draw")] = []
    erased: Annotated[list[Whole], Meta(description="indices of the built solids to erase")] = []
    watch: Annotated[bool | UnsetType, Meta(description="send `forgetting` about what this erases")] = UNSET


class WorldCommand(Struct, tag_field="type", tag="world"):
    """Simulations: restart in another world."""

    name: Annotated[str, Meta(description="one of `names` of the message `world`")]
    added: Annotated[list[DrawnSolid], Meta(description="walls and boxes to draw")] = []
    erased: Annotated[list[Whole], Meta(description="indices of the built solids to erase")] = []


class TrajectoryCommand(Struct, tag_field="type", tag="trajectory"):
    """Log sessions: recompute the map with another trajectory."""

    name: Annotated[str, Meta(description="one of the `trajectories` of `hello`")]


class PingCommand(Struct, tag_field="type", tag="ping"):
    """Request a `pong`."""

    id: Annotated[Whole, Meta(description="returned in the answer")]


COMMANDS = (
    AckCommand,
    ResumeCommand,
    SubscribeCommand,
    SelectCommand,
    MeasureCommand,
    PlayCommand,
    PauseCommand,
    RestartCommand,
    StepCommand,
    SpeedCommand,
    SeekCommand,
    CancelCommand,
    ParametersCommand,
    SensorCommand,
    FaultsCommand,
    CompareCommand,
    TeleportCommand,
    DriveCommand,
    AutoCommand,
    EditCommand,
    WorldCommand,
    TrajectoryCommand,
    PingCommand,
)
