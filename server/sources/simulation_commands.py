"""The commands that move the robot, its sensor or its world. Each is recorded in the journal for replay."""

from __future__ import annotations

from msgspec import UNSET, structs

from mapper.simulation import Edits
from mapper.simulation.live_map import LiveMap
from server.sessions.tick import TickResult
from server.sources.history import Action
from server.stream.commands import AutoCommand, DriveCommand, EditCommand, SensorCommand, TeleportCommand


def act(mapper: LiveMap, command: Action, result: TickResult) -> None:
    """Carry out an action. Raises as the mapper does, and nothing has changed then."""
    simulation = mapper.simulation
    steps = simulation.steps
    match command:
        case TeleportCommand(x=x, y=y, yaw=yaw):
            change, message = mapper.teleport(x, y, yaw)
            result.add(change)
            if message is not None:
                result.notice("teleport.moved", message)
        case DriveCommand(linear=linear, angular=angular):
            simulation.drive(linear, angular)
        case AutoCommand(value=value):
            simulation.auto = value
        case SensorCommand(values=values):
            result.new_grid |= mapper.set_sensor(simulation.sensor.with_values(values))
        case EditCommand(added=added, erased=erased, watch=watch):
            if mapper.edit(Edits.of(added, erased), watch=bool(watch)):
                result.notice("edit.moved", "The robot stood where you drew, so it was moved aside.")
    if isinstance(command, EditCommand):
        command = structs.replace(command, watch=UNSET)
    mapper.journal.append((steps, command))
