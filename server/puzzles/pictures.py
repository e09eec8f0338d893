"""Small pictures of the maps of the puzzles that come with the program, as they are when an attempt begins."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from functools import partial
from typing import Protocol

import numpy as np

from mapper.core.array_types import UInt8Array
from mapper.core.errors import ConfigError
from mapper.grid.occupancy_grid import FREE, OCCUPIED, OccupancyGrid
from mapper.puzzles import RECIPES
from mapper.puzzles.puzzle import mapped
from mapper.replay.overview import SIDE, cells_overview
from server.library.log_picture import png_of
from server.sessions.models.log_recording import first_config

Check = Callable[[], None]


class Run(Protocol):
    """Computes ``work(check)`` on a worker thread; see :meth:`server.downloads.Downloads.run`."""

    def __call__(self, work: Callable[[Check], UInt8Array]) -> Awaitable[UInt8Array]:
        """Return what ``work`` returns."""


class PuzzlePictures:
    """Pictures by puzzle, each drawn once, one at a time. Used on the event loop only."""

    def __init__(self) -> None:
        self._codes: dict[str, UInt8Array] = {}
        self._turn = asyncio.Lock()

    async def png(self, name: str, run: Run, *, dark: bool) -> bytes:
        """Return the picture of a puzzle as PNG, in the colours of a light or a dark page.

        Raises :class:`ConfigError` for an unknown puzzle.
        """
        if name not in RECIPES:
            raise ConfigError("puzzle.unknown", f"There is no puzzle {name!r:.80}.")
        async with self._turn:
            if name not in self._codes:
                self._codes[name] = await run(partial(_codes, name))
        return png_of(self._codes[name], dark=dark)


def _codes(name: str, check: Check) -> UInt8Array:
    """Return the codes of the picture of a puzzle's map."""
    spoiled = RECIPES[name].make(lambda _: check())
    config = first_config(spoiled.reference).with_values(spoiled.start)
    return picture_codes(mapped(spoiled.log, config, spoiled.trajectory), config.log_odds_min)


def picture_codes(grid: OccupancyGrid, log_odds_min: float) -> UInt8Array:
    """Return the codes of the picture of a map (rows, cols), row 0 at the greatest y, cut to the observed cells.

    A cell is a square of pixels, so that large cells have sharp borders when the picture is enlarged. A cell at
    the lower clamp ``log_odds_min`` is free, as the page of the attempt shows it: a high clamp keeps all cells from
    being so certain that they are classified as free.
    """
    rows, cols = (np.flatnonzero(np.any(grid.observed, axis=axis)) for axis in (1, 0))
    seen = np.s_[rows[0] : rows[-1] + 1, cols[0] : cols[-1] + 1]
    state = grid.classify()[seen]
    occupied, free = state == OCCUPIED, (state == FREE) | (grid.observed & (grid.log_odds <= log_odds_min))[seen]
    pixels = np.ones(2 * (max(1, SIDE // max(free.shape)),), dtype=np.bool_)
    return cells_overview(np.kron(free, pixels), np.kron(occupied, pixels))
