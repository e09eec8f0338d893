"""The commands that move the robot, its sensor or its world. Each is recorded in the journal for replay."""

from __future__ import annotations

from typing import Any

from mapper.simulation import Edits
from mapper.simulation.live_map import LiveMap
from server.sessions.tick import TickResult
from server.stream.protocol import ProtocolError, number, values

ACTIONS = ("teleport", "drive", "auto", "sensor", "edit")


def flag(command: dict[str, Any], key: str) -> bool:
    """Return a flag of a command, False if it is left out. Raises :class:`ProtocolError`."""
    value = command.get(key, False)
    if not isinstance(value, bool):
        raise ProtocolError(f"command.{key}", f'"{key}" must be true or false, not {value!r:.80}.')
    return value


def edits_of(command: dict[str, Any]) -> Edits:
    """Return the edits in a command, which may be none. Raises :class:`ConfigError`."""
    return Edits.of(command.get("added", []), command.get("erased", []))


def act(mapper: LiveMap, command: dict[str, Any], result: TickResult) -> None:
    """Carry out one of :data:`ACTIONS`. Raises as the mapper does, and nothing has changed then."""
    simulation = mapper.simulation
    steps = simulation.steps
    match command["type"]:
        case "teleport":
            yaw = None if command.get("yaw") is None else number(command, "yaw")
            change, message = mapper.teleport(number(command, "x"), number(command, "y"), yaw)
            result.add(change)
            if message is not None:
                result.notice("teleport.moved", message)
        case "drive":
            simulation.drive(number(command, "linear"), number(command, "angular"))
        case "auto":
            simulation.auto = flag(command, "value")
        case "sensor":
            result.new_grid |= mapper.set_sensor(simulation.sensor.with_values(values(command)))
        case "edit":
            if mapper.edit(edits_of(command), watch=flag(command, "watch")):
                result.notice("edit.moved", "The robot was where you drew: it was moved aside.")
        case other:
            raise ProtocolError("command.unknown", f"A simulation has no command {other!r:.80}.")
    mapper.journal.append((steps, {key: value for key, value in command.items() if key != "watch"}))
