"""Built-in puzzles, each a simulated drive with one fault."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from mapper.puzzles.drives import LIDAR, SHORT_LIDAR, SONARS, TRUE, Step, drive, polished, swept
from mapper.puzzles.spoiling import Spoiled, spoil
from mapper.simulation.edits import Drawn

#: Crates in the room that are removed later.
CRATES = tuple(Drawn("box", *corners) for corners in ((560, 140, 680, 220), (360, 560, 470, 650), (720, 600, 810, 680)))


@dataclass(frozen=True, slots=True)
class Recipe:
    """A puzzle: ``level`` 1 to 3, the visitor's ``title`` and ``story``, its cause, and how it is made.

    Title and story do not reveal the cause. ``make`` reports the progress of its drive. ``choices`` are the causes to
    choose from, the same in every attempt; all of them if empty.
    """

    name: str
    level: int
    title: str
    story: str
    cause: str
    make: Callable[[Step], Spoiled]
    choices: tuple[str, ...] = ()


def _spoiled(world: str, seed: int, n_scans: int, cause: str, *, short: bool = False) -> Callable[[Step], Spoiled]:
    sensor = SHORT_LIDAR if short else LIDAR
    return lambda step: spoil(drive(world, seed, n_scans, sensor, step=step), cause, seed, TRUE)


def _clamp(step: Step) -> Spoiled:
    log = drive("room", 11, 500, LIDAR, CRATES, step)
    return Spoiled(log, TRUE, log, TRUE, {"clamp": False})


def _polished(step: Step) -> Spoiled:
    clean = drive("loop", 6, 300, step=step)
    return Spoiled(polished(clean, "loop"), TRUE, clean, TRUE, {"no_return": "free"}, {"no_return": "ignore"})


def _sweep(step: Step) -> Spoiled:
    log = swept(drive("room", 7, 250, step=step), "room")
    return Spoiled(log, TRUE, log, TRUE, {"deskew": "off"}, {"deskew": "on"}, {"deskew": "on"})


def _sonar(step: Step) -> Spoiled:
    log = drive("room", 8, 500, SONARS, step=step)
    return Spoiled(log, TRUE, log, TRUE, {"model": "fixed_increments", "window": 0.0})


def _low_table(step: Step) -> Spoiled:
    log = drive("levels", 9, 400, step=step)
    return Spoiled(log, TRUE, log, TRUE)


_ROWS = (
    Recipe("doorway", 1, "The closed doors", "A robot in an office. Its planner finds no way through any door.",
           "resolution", _spoiled("office", 1, 250, "resolution"), ("resolution", "window", "mount_yaw", "people")),
    Recipe("thick", 1, "The thick walls", "A hall with pillars. The map has less free space than the hall.",
           "window", _spoiled("hall", 2, 250, "window"), ("resolution", "window", "time_offset", "polished")),
    Recipe("arcs", 1, "Walls in the open", "A cheap laser in a hall. There are obstacles where none were placed.",
           "max_range", _spoiled("hall", 3, 300, "max_range", short=True),
           ("window", "max_range", "people", "clamp")),
    Recipe("mirror", 1, "A room that turns", "A robot was rebuilt last week. Since then its map has been useless.",
           "beam_order", _spoiled("office", 4, 250, "beam_order"),
           ("mount_yaw", "beam_order", "drift", "time_offset")),
    Recipe("worn", 2, "The second building", "A lap and a half around a corridor. On the map it does not close.",
           "drift", _spoiled("loop", 5, 400, "drift")),
    Recipe("bumped", 2, "Blurred straight ahead", "The robot hit a door frame. The map has been blurred since.",
           "mount_yaw", _spoiled("hall", 10, 250, "mount_yaw")),
    Recipe("ghost", 2, "Detours", "A store room before and after a delivery. The planner avoids empty floor.",
           "clamp", _clamp),
    Recipe("lunch", 2, "After lunch", "A robot mapped a hall, was switched off at noon, and went on in the afternoon.",
           "grid_origin", _spoiled("hall", 15, 300, "grid_origin")),
    Recipe("visitors", 2, "Open day", "The robot was shown to guests while it mapped the office.",
           "people", _spoiled("office", 12, 400, "people")),
    Recipe("leak", 2, "Free space outside", "A corridor with a new floor. On the map its walls have gaps.",
           "polished", _polished),
    Recipe("offset", 3, "Two of each corner", "The sensor was moved for cleaning, and put back by eye.",
           "mount_x", _spoiled("room", 13, 250, "mount_x")),
    Recipe("lag", 3, "Fans in the turns", "The laser got a computer of its own. Straight drives look right.",
           "time_offset", _spoiled("office", 14, 400, "time_offset")),
    Recipe("integers", 3, "Right in one corner", "A new program keeps the poses in less memory.",
           "truncation", _spoiled("loop", 16, 350, "truncation")),
    Recipe("torn", 3, "Torn at one side", "A slow laser on a quick robot.", "sweep", _sweep),
    Recipe("cones", 3, "Sixteen numbers", "A robot without a laser. Sensors like these do not see as a laser does.",
           "sonar", _sonar),
    Recipe("collision", 3, "A perfect map", "The map agrees with the plan of the building. The robot still collides.",
           "low_table", _low_table),
)  # fmt: skip

RECIPES: Mapping[str, Recipe] = MappingProxyType({row.name: row for row in _ROWS})
