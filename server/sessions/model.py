"""What a session computes, as its host sees it: the interface that every kind of session implements.

Methods run on a worker thread unless they say otherwise. What a model shows is read by the event loop between two
ticks. A model knows no socket and no asyncio; what it needs of both it asks of its
:class:`server.sessions.hosting.ModelHost`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from mapper.grid import OccupancyGrid
from mapper.replay.incremental import CheckpointPrefetcher
from mapper.sensors.scan import ScanLog
from server.sessions.drawings import Drawing, Point, Quaternion
from server.sessions.playback import Playback
from server.sessions.scene_controls import SceneControls
from server.sessions.tick import TickResult
from server.stream.layers import Layer
from server.stream.protocol import ProtocolError

if TYPE_CHECKING:
    from server.sessions.parts import Comparable, Recording, Story

NO_SCAN: dict[str, Any] = {}


@dataclass(frozen=True, slots=True)
class Footprint:
    """The memory that a model holds: cells of its grids, and logs."""

    cells: int = 0
    logs: tuple[ScanLog, ...] = ()


class SessionModel(ABC):
    """What a session computes. A kind has to say what it shows and what time does; all else has a default."""

    kind: ClassVar[str]  #: name of the kind, as in :data:`server.sessions.kinds.KINDS`
    replacing: ClassVar[frozenset[str]] = frozenset()
    """Types of commands that make a map useless which is still being computed."""
    resent_on_refusal: ClassVar[Mapping[str, str]] = {}
    """Where a command of this type is refused: the type of the message that its sender gets again."""

    recording: Recording | None = None  #: the log that is shown
    comparison: Comparable | None = None  #: the comparison of the map with another one
    story: Story | None = None  #: from which the session can be made again

    def __init__(self, playback: Playback | None = None) -> None:
        self.playback = playback or Playback()

    # -- what every kind says -------------------------------------------------------------------------------------

    @property
    @abstractmethod
    def layers(self) -> Sequence[Layer]:
        """What is shown, the map first."""

    @abstractmethod
    def advance(self, dt: float, result: TickResult) -> None:
        """Let ``dt`` seconds pass, 0 to only finish what commands began.

        Raises :class:`mapper.core.errors.WorkCancelledError` where a newer command ended it, and
        :class:`mapper.core.errors.MapperError` for what cannot go on: time stops then.
        """

    # -- what it is -----------------------------------------------------------------------------------------------

    @property
    def title(self) -> str:
        """A title for people."""
        return self.kind.capitalize()

    @property
    def file_stem(self) -> str:
        """What files of the session are named after."""
        return self.title

    @property
    def frame_id(self) -> str | None:
        """The frame of the map, None where it is not known."""
        return "map"

    @property
    def grid(self) -> OccupancyGrid | None:
        """The map that can be downloaded, None where there is none."""
        return None

    @property
    def footprint(self) -> Footprint:
        """The memory that the model holds (any thread)."""
        return Footprint()

    @property
    def progress(self) -> tuple[int, int]:
        """``(index, count)``: scans in the map, scans that there are."""
        return (0, 0)

    def particulars(self) -> dict[str, Any]:
        """Return the fields of ``hello`` that the kind adds or sets."""
        return {}

    def messages(self) -> list[dict[str, Any]]:
        """Return the messages that each new client gets: the newest of each type."""
        return []

    def frame(self) -> dict[str, Any]:
        """Return the fields of the ``frame`` message that the kind adds or sets."""
        return {}

    def scan(self) -> dict[str, Any]:
        """Return the fields of ``frame`` about the newest scan: the same object while that is the same."""
        return NO_SCAN

    # -- 3D -------------------------------------------------------------------------------------------------------

    def drawings(self) -> list[Drawing]:
        """Return what is shown in 3D (event loop, between two ticks). The arrays may be the model's own."""
        return []

    def controls(self) -> SceneControls:
        """Return what the panel of the 3D view offers (event loop, between two ticks)."""
        return SceneControls(playing=self.playback.playing)

    def on_scene_click(self, x: float, y: float) -> dict[str, Any] | None:  # noqa: ARG002 - most kinds need none
        """Return the command that a click on the floor of the 3D view at (x, y) gives, None for none.

        Event loop, possibly during a tick: read only what a tick replaces as a whole.
        """
        return None

    def on_gizmo_moved(
        self,
        name: str,  # noqa: ARG002 - most kinds have none
        position: Point,  # noqa: ARG002
        wxyz: Quaternion,  # noqa: ARG002
    ) -> dict[str, Any] | None:
        """Return the command that a move of the gizmo ``name`` gives, None for none. As :meth:`on_scene_click`."""
        return None

    # -- commands -------------------------------------------------------------------------------------------------

    def play(self) -> None:
        """Let time pass."""
        self.playback.playing = True

    def obey(self, command: dict[str, Any], result: TickResult) -> None:  # noqa: ARG002
        """Carry out a command that is not one of every session (play, pause, speed).

        Sets ``result.changed`` where a new frame is to be published. Raises :class:`ProtocolError` or
        :class:`mapper.core.errors.MapperError` for a command that is refused; nothing has changed then.
        """
        raise ProtocolError("command.unknown", f"A {self.kind} session knows no command {command['type']!r:.80}.")

    def settle(self, result: TickResult) -> None:  # noqa: B027 - most kinds need none
        """Compute what the commands of this tick asked for together, such as a map with other parameters."""

    def draw(self, result: TickResult) -> None:  # noqa: B027 - most kinds need none
        """Bring the layers up to date with what the tick changed."""

    # -- long work ------------------------------------------------------------------------------------------------

    @property
    def fraction(self) -> float | None:
        """How much of the present computation is done, 0 to 1; None where that is not known (any thread)."""
        return None

    @property
    def has_deferred_work(self) -> bool:
        """Whether something is left to compute that no picture waits for (event loop)."""
        return False

    def run_deferred_work(self, result: TickResult) -> None:  # noqa: B027 - most kinds need none
        """Compute it."""

    def prefetcher(self) -> CheckpointPrefetcher | None:
        """Return what prepares seeks in idle time, None where there is nothing to prepare (event loop)."""
        return None
