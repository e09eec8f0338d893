"""The simulator: worlds, lidar, and a robot that walks by itself."""

from mapper.world.edits import Drawn, Edits, edited
from mapper.world.faults import Faults
from mapper.world.floor_plans import WORLDS
from mapper.world.lidar import SENSOR_PARAMETERS, SensorConfig
from mapper.world.recording import Recording
from mapper.world.sample import sample_log
from mapper.world.simulation import Simulation, Teleport
from mapper.world.worlds import World

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
