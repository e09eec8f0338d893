"""Causes of defects in a map, used in puzzles, with explanations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType


@dataclass(frozen=True, slots=True)
class Cause:
    """One cause.

    ``label`` is the answer to select, ``section`` the lecture section about it, ``hints`` are one sentence each, from
    where to look to what to do, ``explanation`` is shown at the end, with ``lesson``, a sentence of the section.
    ``of_log`` means that any log can have this fault, ``amount`` is the minimum and maximum size of the fault
    (``unit``), (0, 0) if it has none.
    """

    name: str
    label: str
    section: str
    hints: tuple[str, str, str]
    explanation: str
    lesson: str
    of_log: bool = True
    amount: tuple[float, float] = (0.0, 0.0)
    unit: str = ""


_ROWS = (
    Cause(
        "resolution",
        "The cells are too large",
        "resolution",
        (
            "Compare the size of a cell with the width of a door.",
            "Ask Why about one cell: it holds hits of one surface and misses of the free space beside it.",
            "Look at the parameter Resolution.",
        ),
        "A cell has one state. A large cell holds a surface and free space at once, and a door of two cells may close. "
        "Small cells cost memory and time: halving the side takes four times the cells.",
        lesson="Cells of 1 cm show the noise of the sensor; in cells of 10 cm a door of 80 cm may lose a quarter of "
        "its width.",
        amount=(0.3, 0.5),
        unit="m",
    ),
    Cause(
        "window",
        "The hit window is too wide",
        "window",
        (
            "Look at the thickness of the walls, and compare it in narrow and in wide places.",
            "Ask Why about a cell well in front of a wall: it got hits of beams that ended farther away.",
            "Look at the parameter Hit window.",
        ),
        "The window around a reading allows for the noise of the range and the size of a cell. A wider window makes "
        "walls thick and closes narrow passages.",
        lesson="With no window the wall is broken; with a wide one it is thick and narrows the doors.",
        amount=(0.6, 1.0),
        unit="m",
    ),
    Cause(
        "max_range",
        "Beams without a return are counted as hits",
        "no-return",
        (
            "There are walls in free space. How far are they from the robot?",
            "Ask Why about such a wall: all its hits have the same range.",
            "Compare that range with the parameter Max range.",
        ),
        "Some drivers report the max range where nothing came back. Taken as a reading, each such beam draws an "
        "obstacle there: arcs in free space. A reading at or beyond the max range is no hit.",
        lesson="Counting no return as a hit is always wrong; it happens when a driver reports the max range "
        "where there was no echo.",
    ),
    Cause(
        "mount_yaw",
        "The sensor is mounted at a different angle than stated",
        "mount",
        (
            "Watch what a turn of the robot does, and what a straight drive does.",
            "Play the log slowly: a straight wall is drawn turned against the direction of the drive.",
            "Look at the parameter Mount yaw, both signs.",
        ),
        "A wrong mount yaw turns each scan about the sensor. While the robot drives straight on, walls ahead slide "
        "sideways from scan to scan, so that they are smeared; a turn on the spot alone does not show it.",
        lesson="A rotated sensor rotates each scan about itself, so a wall appears in a different place from "
        "every pose.",
        amount=(0.08, 0.2),
        unit="rad",
    ),
    Cause(
        "mount_x",
        "The sensor is mounted at a different place than stated",
        "mount",
        (
            "Compare a wall that was seen from one heading only with one that was seen from many.",
            "Ask Why about both copies of a doubled wall: the robot’s heading differs.",
            "Look at the parameter Mount forward, both signs.",
        ),
        "A wrong position of the sensor shifts each scan along the robot’s heading. While the heading is constant, the "
        "map is only shifted; after a turn the same wall is drawn a second time beside the first.",
        lesson="The offset of a shifted sensor rotates with the heading: walls appear twice where the robot turned, "
        "and a straight drive hides the error.",
        amount=(0.25, 0.45),
        unit="m",
    ),
    Cause(
        "beam_order",
        "The beams are read in the wrong order",
        "mount",
        (
            "Is there anything in the map that looks like one scan of a room?",
            "Play the first scans, and let the robot turn: what turns the other way?",
            "A sensor that hangs upside down sweeps clockwise.",
        ),
        "With the order of the beams reversed each scan is a mirror image: what is on the left is drawn on the right. "
        "As the robot turns, the image turns the opposite way, and nothing agrees.",
        lesson="A sensor upside down mirrors each scan.",
    ),
    Cause(
        "drift",
        "The poses come from odometry, which drifts",
        "odometry",
        (
            "Compare what the robot saw at the beginning with what it saw at the end.",
            "Ask Why about both copies of a wall: the numbers of their scans are far apart.",
            "The log has more than one trajectory, or its poses can be corrected by SLAM.",
        ),
        "Errors of odometry add up. Each scan is right by itself, but a wall that is seen again later is drawn in "
        "a second place. Poses from localization or SLAM repair it; parameters of the sensor model do not.",
        lesson="Wheels slip, and the errors of odometry add up: after one lap the same wall is in several places.",
        amount=(1.0, 2.0),
        unit="× worn wheels",
    ),
    Cause(
        "grid_origin",
        "The origin of the grid changed during the log",
        "endpoint",
        (
            "Compare the two copies of several walls: by how much, and in which direction, do they differ?",
            "Ask Why about both copies: all scans of one come before a certain scan, all of the other after it.",
            "The displacement is the same everywhere, so nothing drifts. Choose other poses.",
        ),
        "Positions and cells count from the origin of the grid, which map.yaml states. When a map is saved, cut and "
        "loaded with its old origin, everything found in it afterwards is displaced by the same distance. A wrong "
        "origin alone only shifts the map; two origins in one map draw each wall twice.",
        lesson="Column and row are the distances from the origin, counted in cells and rounded down.",
        amount=(0.4, 0.8),
        unit="m",
    ),
    Cause(
        "truncation",
        "Coordinates below zero are truncated instead of rounded down",
        "endpoint",
        (
            "Which part of the map is right, and where does the other part begin? Read the coordinates of the cells.",
            "Ask Why about both copies of a wall: the robot saw them from different sides of x = 0 or y = 0.",
            "In C++ and Python int(−0.3) is 0, and floor(−0.3) is −1. Choose poses that were not converted.",
        ),
        "A cell is floor((p − origin) / resolution). A conversion to an integer truncates: above zero it is the same, "
        "below zero it is one cell too high, and the two cells beside zero become one. Here positions were stored as "
        "a cell and a remainder, so that all scans taken at negative x or y are displaced by one cell.",
        lesson="Converting to an integer is wrong below zero: −0.3 becomes 0, not −1, and two columns become one.",
        amount=(0.3, 0.5),
        unit="m",
    ),
    Cause(
        "time_offset",
        "The clocks of the scans and of the poses differ",
        "mount",
        (
            "Compare walls that were seen while the robot stood or drove straight on with those seen in a turn.",
            "Step through a turn scan by scan: the scan lags behind the heading, or runs ahead of it.",
            "Look at the parameter Time offset, both signs.",
        ),
        "With a time offset each scan is placed where the robot was a moment before or after. In a turn the error is "
        "the angular velocity times the offset: walls fan out there, and stay thin on straight drives.",
        lesson="The pose must be that of the moment of the reading: where clocks differ, walls fan out in every turn.",
        amount=(0.3, 0.6),
        unit="s",
    ),
    Cause(
        "sweep",
        "All beams of a scan are placed at one pose",
        "mount",
        (
            "Look at single scans that were taken in a turn.",
            "Where a full turn of the sensor begins and ends, straight walls are torn apart.",
            "Look at the parameter Deskew.",
        ),
        "A scan takes time, and the robot moves meanwhile. Each beam has a pose of its own, which is interpolated "
        "between the poses of the trajectory. Without that, walls are torn at the seam of the scan while the robot "
        "turns.",
        lesson="A scan takes time: in a turn each beam needs its own pose, or walls tear where the scan begins and "
        "ends.",
        of_log=False,
    ),
    Cause(
        "clamp",
        "Something was moved, and the cells cannot forget it",
        "forgetting",
        (
            "Some obstacles are no longer there at the end of the log. Play the log to find them.",
            "Ask Why about one of them: many hits first, then misses only.",
            "Look at the parameter Clamp.",
        ),
        "Without a clamp a cell that was hit for minutes needs as much evidence again before it becomes free. The "
        "clamp limits the log-odds, so that a few scans are enough.",
        lesson="The clamp limits the certainty of a cell, and with it the number of misses needed.",
        of_log=False,
    ),
    Cause(
        "people",
        "Somebody walked through the scans",
        "people",
        (
            "There are marks in the free space that no furniture makes. Play the log to see how they appear.",
            "Ask Why about one of them: hits of a few scans in a row, and misses before and after.",
            "Make misses count more, or let a cell become more certainly free: Miss increment, Lower clamp.",
        ),
        "The map assumes that the world does not move. A person leaves a row of occupied cells, which stay where the "
        "robot does not look again. Evidence of more misses removes some; what moves belongs in another layer.",
        lesson="A trail stays where no later beams pass.",
    ),
    Cause(
        "polished",
        "Polished walls reflect the beams away",
        "polished",
        (
            "Some long straight walls are missing in part. From where were they seen?",
            "Ask Why about a cell where a wall should be: beams at a slant passed, and none came back.",
            "A beam that was reflected away does not say that its way was free: look at the parameter No return.",
        ),
        "A beam that meets a polished wall or glass at a slant does not return. If no return counts as free space up "
        "to the max range, the wall is erased and the map shows free space outside the building.",
        lesson="A polished wall is a mirror: unless the beam meets it almost at a right angle, "
        "usually nothing comes back.",
        of_log=False,
    ),
    Cause(
        "sonar",
        "A cone is treated as a thin beam",
        "sonar",
        (
            "Look at how many readings a scan has, and in which directions.",
            "Ask Why about a cell in front of a wall: the echo may have come from anywhere in a wide angle.",
            "Look at the parameter Inverse sensor model.",
        ),
        "A sonar tells the distance of the nearest object within its cone, and not its bearing. Drawn as a thin beam, "
        "the echo stands at one wrong place, and most of the free space stays unknown.",
        lesson="A laser beam is thin; the beam of a sonar is a cone.",
        of_log=False,
    ),
    Cause(
        "low_table",
        "An obstacle is not at the height of the laser",
        "low-table",
        (
            "The walls are right. Compare the path of the robot with the free space.",
            "The robot drives around a place that is free in the map.",
            "No parameter of the map repairs this: the laser cannot see it.",
        ),
        "A planar laser maps one height. What is lower or higher, a low table or the top of one, is free space in the "
        "map, and the robot runs into it. A 3D sensor, or a second sensor at another height, is needed.",
        lesson="A cell has no height: the height of the laser decides which obstacles are in the map.",
        of_log=False,
    ),
)  # fmt: skip

CAUSES: Mapping[str, Cause] = MappingProxyType({row.name: row for row in _ROWS})
