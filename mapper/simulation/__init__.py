"""Simulator: worlds, sensors, and a robot that explores autonomously."""

from typing import TYPE_CHECKING

from mapper.core.lazy_imports import imported_later

if TYPE_CHECKING:
    from mapper.simulation.edits import Drawn, Edits, edited
    from mapper.simulation.faults import Faults
    from mapper.simulation.floor_plans import WORLDS
    from mapper.simulation.lidar import SENSOR_PARAMETERS, SensorConfig
    from mapper.simulation.recording import Recording
    from mapper.simulation.sample import sample_log
    from mapper.simulation.simulation import Simulation, Teleport
    from mapper.simulation.worlds import World

__all__ = [
    "SENSOR_PARAMETERS",
    "WORLDS",
    "Drawn",
    "Edits",
    "Faults",
    "Recording",
    "SensorConfig",
    "Simulation",
    "Teleport",
    "World",
    "edited",
    "sample_log",
]

__getattr__ = imported_later(__name__, __file__)
