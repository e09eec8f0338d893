"""Compile the kernels before the first visitor needs them."""

from __future__ import annotations

from dataclasses import replace

from mapper.integrate import CellBox
from mapper.world import WORLDS
from server.sessions import WorldMapper
from server.stream.tiles import TilePicture, picture_range


def warm_up() -> None:
    """Run everything that a session computes, once and small. Seconds where nothing is cached, else milliseconds."""
    mapper = WorldMapper(next(iter(WORLDS.values())), seed=0)
    mapper.look()
    for update in ("per_scan", "per_beam"):
        mapper.remake(replace(mapper.config, update=update))
    geometry = mapper.grid.geometry
    picture = TilePicture(geometry, *picture_range(mapper.config), epoch=1)
    picture.update(mapper.grid, CellBox(0, geometry.rows, 0, geometry.cols))
