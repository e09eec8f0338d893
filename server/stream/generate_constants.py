"""The TypeScript module of the constants that the mapper states and the pages use too."""

from __future__ import annotations

import json

from mapper.diagnosis.examination import LEAST_SCANS
from mapper.grid import FREE_THRESHOLD, OCCUPIED_THRESHOLD
from mapper.grid.merge import LATTICE_TOLERANCE
from mapper.mapping.parameters import PARAMETERS
from mapper.simulation.edits import WALL_THICKNESS
from mapper.simulation.lidar import SensorConfig
from mapper.simulation.live_map import LiveMap
from mapper.simulation.simulation import ROBOT_RADIUS

#: rows of the table of mapping parameters that the profile of the sensor model shows
_SHOWN = [
    row for row in PARAMETERS if row.group == "model" or row.name in {"log_odds_prior", "no_return", "resolution"}
]
_LIVE = LiveMap.first_config(SensorConfig())

#: name, value, meaning
CONSTANTS: tuple[tuple[str, float, str], ...] = (
    ("ROBOT_RADIUS", ROBOT_RADIUS, "Radius of the simulated robot, which is a disc, metres."),
    ("WALL_THICKNESS", WALL_THICKNESS, "Thickness of a wall that is drawn into a world, metres."),
    ("LIVE_RANGE_MAX", _LIVE.range_max, "Longest range that a live world's map begins with, metres."),
    ("LIVE_WINDOW", _LIVE.window, "Window of a hit that a live world's map begins with, metres."),
    ("LATTICE_TOLERANCE", LATTICE_TOLERANCE, "How far two lattices may lie apart and still be the same, in cells."),
    ("OCCUPIED_THRESHOLD", OCCUPIED_THRESHOLD, "p_occ above which a cell is occupied, as in map_server."),
    ("FREE_THRESHOLD", FREE_THRESHOLD, "p_occ below which a cell is free, as in map_server."),
    ("DOCTOR_LEAST_SCANS", LEAST_SCANS, "Scans of a sensor below which the doctor refuses to judge a log."),
)


def constants(command: str) -> str:
    """Return ``static/src/wire/constants.ts``, which says that ``command`` writes it."""
    lines = [f"// Written by `{command}` from constants of mapper/: change those."]
    for name, value, meaning in CONSTANTS:
        lines += ["", f"/** {meaning} */", f"export const {name} = {value!r};"]
    initial = [f"  {row.name}: {json.dumps(row.initial)}," for row in _SHOWN]
    bounds = [
        f"  {row.name}: {{ low: {row.low!r}, high: {row.high!r}, step: {row.step!r} }},"
        for row in _SHOWN
        if row.kind == "number"
    ]
    lines += ["", "/** Initial values of the parameters of the sensor model. */"]
    lines += ["export const SENSOR_MODEL_INITIAL = {", *initial, "} as const;"]
    lines += ["", "/** Bounds and steps of their numbers. */"]
    lines += ["export const SENSOR_MODEL_BOUNDS = {", *bounds, "} as const;"]
    return "\n".join([*lines, ""])
