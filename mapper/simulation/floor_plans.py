"""The worlds: an office floor, a cluttered room, a corridor loop, a hall, a maze, two equal rooms and one with levels.

Metres, map frame.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from mapper.simulation.blocks import Block, lintels, ramp, slab, stairs, table_top
from mapper.simulation.shapes import Point, Polygon, box, disc, legs, outer_walls, rect, star, wall
from mapper.simulation.worlds import World

OUTER, INNER = 0.2, 0.12  # thickness of walls
TABLE, LOW_TABLE = 0.75, 0.25  # heights of tables


def _walled(
    solids: list[Polygon], blocks: list[Block], a: Point, b: Point, doors: Sequence[tuple[float, float]] = ()
) -> None:
    """Add an inner wall, with a lintel over each of its doors."""
    solids += wall(a, b, INNER, doors)
    blocks += lintels(a, b, INNER, doors)


def _office() -> World:
    """Eight rooms on both sides of a corridor 2 m wide; doors of 0.95 m, two of them between rooms."""
    solids = outer_walls(0.0, 0.0, 20.0, 14.0, OUTER)
    blocks: list[Block] = []
    # The corridor's two walls, and the partitions between the rooms.
    south, north = [(3.2, 4.15), (5.4, 6.35), (12.2, 13.15), (14.4, 15.35)], [(4.2, 5.15), (6.7, 7.65), (9.4, 10.35)]
    _walled(solids, blocks, (0.2, 5.94), (19.8, 5.94), south)
    _walled(solids, blocks, (0.2, 8.06), (19.8, 8.06), [*north, (18.0, 18.95)])
    _walled(solids, blocks, (5.0, 0.2), (5.0, 5.94), [(2.6, 3.55)])
    _walled(solids, blocks, (10.0, 0.2), (10.0, 5.94))
    _walled(solids, blocks, (14.0, 0.2), (14.0, 5.94))
    _walled(solids, blocks, (6.0, 8.06), (6.0, 13.8))
    _walled(solids, blocks, (9.0, 8.06), (9.0, 13.8))
    _walled(solids, blocks, (15.0, 8.06), (15.0, 13.8), [(2.2, 3.15)])
    # Corridor: a cabinet, a column, a plant and an extinguisher.
    solids += [rect(8.1, 7.65, 9.3, 8.0), rect(1.0, 6.0, 2.4, 6.4), disc(11.4, 7.72, 0.28)]
    solids += [disc(19.5, 7.7, 0.22, 12), rect(16.9, 6.0, 17.1, 6.14)]
    # South 1: two desks at the window, their chairs, a shelf along the west wall.
    solids += [rect(0.5, 0.2, 2.1, 1.0), disc(1.3, 1.35, 0.24, 10), rect(2.9, 0.2, 4.5, 1.0), disc(3.7, 1.35, 0.24, 10)]
    solids += [rect(0.2, 2.6, 0.6, 4.8)]
    # South 2: an island of four desks, a cabinet.
    solids += [
        rect(6.7, 2.0, 8.3, 3.6),
        disc(7.5, 1.65, 0.24, 10),
        disc(7.5, 3.95, 0.24, 10),
        rect(9.54, 0.2, 9.94, 2.0),
    ]
    # South 3: one desk across the corner, an armchair, a low shelf.
    solids += [box(12.9, 1.2, 1.8, 0.8, -0.6), disc(13.32, 1.82, 0.24, 10), rect(10.06, 3.0, 10.46, 5.0)]
    solids += [rect(10.06, 0.2, 10.96, 1.0)]
    # South 4: the meeting room; only the legs of the table are in the laser's plane.
    solids += legs(17.0, 2.9, 2.6, 1.4)
    blocks.append(table_top(17.0, 2.9, 2.6, 1.4, 0.0, TABLE))
    solids += [disc(x, y, 0.22, 10) for x in (16.2, 17.0, 17.8) for y in (1.9, 3.9)]
    solids += [rect(18.4, 0.2, 19.8, 0.65)]
    # North 1: desks back to back, a shelf as a screen.
    solids += [
        rect(0.2, 10.6, 1.0, 12.4),
        disc(1.35, 11.5, 0.24, 10),
        rect(2.6, 13.0, 4.2, 13.8),
        disc(3.4, 12.65, 0.24, 10),
    ]
    solids += [rect(2.6, 9.6, 2.95, 11.2)]
    # North 2: the kitchen: a counter in an L, a round table with stools.
    solids += [np.array([(6.06, 13.2), (8.34, 13.2), (8.34, 11.9), (8.94, 11.9), (8.94, 13.8), (6.06, 13.8)])]
    solids += [disc(7.1, 11.3, 0.4), disc(7.1, 10.65, 0.17, 10), disc(6.6, 11.85, 0.17, 10)]
    # North 3: the laboratory: a round column, two benches, a rack.
    solids += [
        disc(12.0, 10.9, 0.3),
        rect(10.2, 13.0, 13.8, 13.8),
        rect(11.6, 8.12, 14.2, 8.72),
        rect(9.06, 11.2, 9.5, 12.6),
    ]
    # North 4: a sofa, a low table, bookshelves.
    sofa = [(17.2, 13.8), (17.2, 13.0), (19.0, 13.0), (19.0, 11.4), (19.8, 11.4), (19.8, 13.8)]
    solids += [
        np.array(sofa),
        box(17.8, 11.9, 0.9, 0.5, 0.3),
        rect(15.06, 12.0, 15.4, 13.8),
        rect(15.8, 8.12, 17.6, 8.5),
    ]
    return World("office", "Office floor", (0.0, 0.0, 20.0, 14.0), tuple(solids), (6.2, 7.0, 0.0), tuple(blocks))


def _room() -> World:
    """One cluttered room: furniture at all angles, legs, things left on the floor."""
    solids = outer_walls(0.0, 0.0, 10.0, 8.0, OUTER)
    solids += [np.array([(0.2, 5.4), (1.1, 5.4), (1.1, 6.9), (3.0, 6.9), (3.0, 7.8), (0.2, 7.8)])]  # a corner sofa
    solids += [box(2.25, 5.75, 1.0, 0.55, 0.25)]  # the low table before it
    solids += [rect(4.2, 7.45, 7.2, 7.8), rect(9.4, 5.6, 9.8, 7.8)]  # bookshelves
    solids += legs(6.9, 3.9, 1.9, 1.1, 0.5)
    solids += [
        disc(6.55, 3.05, 0.22, 10),
        disc(7.55, 3.35, 0.22, 10),
        disc(6.2, 4.35, 0.22, 10),
        disc(7.35, 4.85, 0.22, 10),
    ]
    solids += [rect(8.9, 0.2, 9.8, 2.0), box(9.3, 3.6, 0.7, 0.9, 0.15)]  # a chest, an armchair
    solids += [rect(3.4, 0.2, 5.4, 0.95), disc(4.4, 1.35, 0.25, 10)]  # a desk and its chair
    solids += [disc(0.6, 0.6, 0.3, 12), disc(8.6, 6.9, 0.25, 12)]  # plants
    solids += [box(1.9, 2.9, 0.55, 0.4, 0.7), box(2.6, 2.15, 0.35, 0.35, -0.3), box(4.5, 4.3, 0.45, 0.3, 1.1)]  # boxes
    solids += wall((0.2, 4.2), (1.6, 4.2), INNER)  # a screen
    solids += [disc(5.3, 5.9, 0.2)]  # a pole
    boards = (table_top(6.9, 3.9, 1.9, 1.1, 0.5, TABLE),)
    return World("room", "Cluttered room", (0.0, 0.0, 10.0, 8.0), tuple(solids), (3.4, 3.6, 0.6), boards)


def _loop() -> World:
    """A corridor 2 m wide around a solid core: few features, and a loop to close."""
    solids = outer_walls(0.0, 0.0, 24.0, 16.0, OUTER)
    core = [
        (2.2, 2.2), (8.0, 2.2), (8.0, 2.6), (9.2, 2.6), (9.2, 2.2), (21.8, 2.2),  # a shallow niche in the south
        (21.8, 9.0), (21.4, 9.0), (21.4, 10.2), (21.8, 10.2), (21.8, 13.8),  # one in the east
        (14.0, 13.8), (14.0, 13.5), (12.8, 13.5), (12.8, 13.8), (2.2, 13.8),  # and in the north; the west wall is plain
    ]  # fmt: skip
    solids += [np.array(core), disc(17.5, 15.4, 0.25), rect(5.0, 0.2, 6.6, 0.5), rect(23.55, 4.4, 23.8, 5.6)]
    return World("loop", "Corridor loop", (0.0, 0.0, 24.0, 16.0), tuple(solids), (3.2, 1.25, 0.0))


def _hall() -> World:
    """A hall with cut corners, pillars, a star with sixteen edges and walls at 30° and 60°: lines in every octant."""
    solids = outer_walls(0.0, 0.0, 22.0, 16.0, OUTER)
    for x, y, dx, dy in (
        (0.0, 0.0, 4.0, 4.0),
        (22.0, 0.0, -5.2, 3.0),
        (22.0, 16.0, -3.0, -5.2),
        (0.0, 16.0, 4.0, -4.0),
    ):
        solids.append(np.array([(x, y), (x + dx, y), (x, y + dy)]))
    solids.append(star(11.0, 8.0, 1.5, 0.75, 8))
    solids += [disc(x, y, 0.35) for x in (6.0, 16.0) for y in (4.4, 11.6)]
    solids += [box(11.0, y, 0.7, 0.7, np.pi / 4) for y in (3.4, 12.6)]
    for x, y, degrees in ((3.4, 8.6, 60.0), (18.8, 7.4, 120.0), (7.8, 13.2, 30.0), (14.4, 2.9, 150.0)):
        solids.append(box(x, y, 2.2, 0.2, np.radians(degrees)))
    return World("hall", "Pillared hall", (0.0, 0.0, 22.0, 16.0), tuple(solids), (8.0, 6.0, 0.8))


MAZE = (
    "+--+--+--+--+--+--+--+--+",
    "|     |        |        |",
    "+  +  +  +--+  +  +--+  +",
    "|  |     |     |  |     |",
    "+  +--+--+  +--+  +  +--+",
    "|  |     |     |  |     |",
    "+  +  +  +--+  +  +--+  +",
    "|     |     |           |",
    "+--+  +--+  +--+--+--+  +",
    "|     |        |     |  |",
    "+  +--+  +--+  +  +  +  +",
    "|        |        |     |",
    "+--+--+--+--+--+--+--+--+",
)  # the first line is the north wall


def _maze() -> World:
    """A maze with loops, defined as text: passages of 1.5 m between thin walls."""
    cell = 1.65
    cols, rows = (len(MAZE[0]) - 1) // 3, (len(MAZE) - 1) // 2
    solids: list[Polygon] = []
    edge = OUTER / 2  # the outer faces of the outer walls are the bounds
    for line, text in enumerate(MAZE):
        y = (rows - line / 2) * cell + edge
        if line % 2 == 0:
            for run in _runs([text[3 * col + 1] == "-" for col in range(cols)]):
                solids += wall((run[0] * cell, y), (run[1] * cell + 2 * edge, y), OUTER)
    for place in range(cols + 1):
        x = place * cell + edge
        for run in _runs([MAZE[2 * row + 1][3 * place] == "|" for row in reversed(range(rows))]):
            solids += wall((x, run[0] * cell), (x, run[1] * cell + 2 * edge), OUTER)
    bounds = (0.0, 0.0, cols * cell + 2 * edge, rows * cell + 2 * edge)
    return World("maze", "Maze", bounds, tuple(solids), (0.5 * cell + edge, 0.5 * cell + edge, 0.0))


def _twins() -> World:
    """Two equal rooms with the same furniture, on a corridor with different ends."""
    apart = 7.86  # metres between corresponding places of the two rooms
    solids = outer_walls(0.0, 0.0, 16.0, 9.0, OUTER)
    solids += wall((0.2, 2.26), (15.8, 2.26), INNER, [(2.8, 3.75), (2.8 + apart, 3.75 + apart)])
    solids += wall((8.0, 2.26), (8.0, 8.8), INNER)
    for x in (0.0, apart):
        solids += [rect(x + 0.2, 7.0, x + 1.0, 8.8), rect(x + 4.4, 8.2, x + 6.2, 8.8), disc(x + 5.3, 7.8, 0.24, 10)]
        solids += [box(x + 3.4, 5.4, 1.4, 0.8, 0.2), rect(x + 7.3, 3.4, x + 7.94, 4.6), disc(x + 1.2, 3.4, 0.3, 12)]
    solids += [rect(14.2, 0.2, 15.8, 0.7), disc(13.0, 1.9, 0.25, 12), rect(0.2, 1.2, 0.5, 2.2)]
    return World("twins", "Two equal rooms", (0.0, 0.0, 16.0, 9.0), tuple(solids), (5.6, 4.4, 1.0))


def _levels() -> World:
    """Two rooms with objects that a planar lidar misses: a low table, a bench, a sill, a ramp, stairs, a shelf."""
    solids = outer_walls(0.0, 0.0, 14.0, 10.0, OUTER)
    blocks: list[Block] = []
    _walled(solids, blocks, (0.2, 6.0), (13.8, 6.0), [(2.6, 3.6), (9.4, 10.4)])
    # The low table: its board and its legs are below the plane of the lidar.
    blocks += [slab(leg, 0.0, 0.2) for leg in legs(4.0, 3.0, 1.4, 0.8)]
    blocks.append(table_top(4.0, 3.0, 1.4, 0.8, 0.0, LOW_TABLE))
    # A table of usual height; the lidar sees its legs.
    solids += legs(7.8, 3.4, 1.6, 0.9, 0.3)
    blocks.append(table_top(7.8, 3.4, 1.6, 0.9, 0.3, TABLE))
    blocks.append(slab(rect(0.2, 1.0, 0.6, 3.4), 1.1, 1.14))  # a shelf on the wall
    # A platform with stairs and a ramp.
    blocks.append(slab(rect(12.0, 0.2, 13.8, 3.2), 0.0, 0.64))
    blocks += stairs(10.8, 0.2, 12.0, 1.6, 0.64, 4)
    blocks.append(ramp(9.8, 1.6, 12.0, 3.2, 0.64))
    # Beyond the wall: a bench with its seat above the plane of the lidar and thin supports, and a sill below the plane.
    solids += [box(6.1, 8.6, 0.06, 0.06), box(7.7, 8.6, 0.06, 0.06)]
    blocks.append(slab(rect(5.9, 8.3, 7.9, 8.9), 0.42, 0.48))
    blocks.append(slab(rect(10.2, 7.6, 11.8, 7.8), 0.0, 0.12))
    solids += [disc(1.2, 8.4, 0.3), rect(12.6, 9.2, 13.8, 9.8)]
    return World("levels", "Room with steps", (0.0, 0.0, 14.0, 10.0), tuple(solids), (6.0, 4.8, 0.0), tuple(blocks))


def _runs(present: list[bool]) -> list[tuple[int, int]]:
    """Return the (first, last + 1) of each run of true values."""
    edges = np.flatnonzero(np.diff([False, *present, False]))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


WORLDS: Mapping[str, World] = MappingProxyType(
    {world.name: world for world in (_office(), _room(), _loop(), _hall(), _maze(), _twins(), _levels())}
)


def another_world(name: str) -> World:
    """Return the world after ``name``; an unknown name is followed by the first."""
    names = list(WORLDS)
    return WORLDS[names[(names.index(name) + 1) % len(names) if name in names else 0]]
