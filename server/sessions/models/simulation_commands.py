"""The commands that move the robot, its sensor or its world. Each is noted in the journal, to be replayed."""

from __future__ import annotations

from typing import Any

from mapper.simulation import Edits
from mapper.simulation.live_map import LiveMap
from server.sessions.tick import TickResult
from server.stream.protocol import ProtocolError, number, values

ACTIONS = ("teleport", "drive", "auto", "sensor", "edit")


def flag(command: dict[str, Any], key: str) -> bool:
    """Return a true or false of a command, false where it is left out. Raises :class:`ProtocolError`."""
    value = command.get(key, False)
    if not isinstance(value, bool):
        raise ProtocolError(f"command.{key}", f'"{key}" must be true or false, not {value!r:.80}.')
    return value


def edits_of(command: dict[str, Any]) -> Edits:
    """Return the edits that a command names, none where it names none. Raises :class:`ConfigError`."""
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
                result.notice("edit.moved", "The robot stood where you drew: it made way.")
        case other:
            raise ProtocolError("command.unknown", f"{other!r:.80} is nothing that a robot or its world can do.")
    mapper.journal.append((steps, {key: value for key, value in command.items() if key != "watch"}))
