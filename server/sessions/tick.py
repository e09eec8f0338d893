"""What one tick of a session's computation leaves for the event loop to send."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from mapper.mapping.integrate import CellBox, Change
from server.stream.hub import Client


@dataclass(frozen=True, slots=True)
class QueuedCommand:
    """A command, and who gave it (None: viser's panel, or code)."""

    command: dict[str, Any]
    client: Client | None = None


@dataclass(slots=True)
class TickResult:
    """Collected on a worker thread, sent on the event loop."""

    rest: list[QueuedCommand] = field(default_factory=list)  #: commands that wait for the next tick
    unfinished: dict[str, Any] | None = None  #: what a long command leaves for the next tick
    changed: bool = False  #: whether there is a new frame to publish
    new_grid: bool = False  #: whether the whole picture has to be read anew
    box: CellBox | None = None  #: otherwise: the cells that may have changed
    remade_ms: float | None = None
    slots: dict[str, dict[str, Any]] = field(default_factory=dict)
    notices: list[dict[str, Any]] = field(default_factory=list)
    answers: list[tuple[Client | None, dict[str, Any]]] = field(default_factory=list)
    reminded: list[Client | None] = field(default_factory=list)  #: whose sliders stand where they were refused
    questions: dict[Client | None, dict[str, Any]] = field(default_factory=dict)  #: each client's newest "why"

    def add(self, change: Change) -> None:
        """Take up what an update of the grid changed."""
        self.changed = True
        self.new_grid = self.new_grid or change.geometry_changed
        if change.box is not None:
            self.box = change.box if self.box is None else self.box | change.box

    def slot(self, message: dict[str, Any]) -> None:
        """Send ``message`` to everyone, unless a newer one of its type comes first."""
        self.slots[message["type"]] = message

    def notice(self, code: str, message: str) -> None:
        """Tell everyone something."""
        self.notices.append({"type": "notice", "code": code, "message": message})


def error_message(code: str, message: str, detail: object = None) -> dict[str, Any]:
    """Return an ``error`` message."""
    return {"type": "error", "code": code, "message": message, "detail": detail}
