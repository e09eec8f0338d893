"""Small pictures of the initial maps of the included puzzles.

They are stored as files, because driving and mapping for all of them takes several seconds of an idle processor.
``python -m server.puzzles.pictures`` writes them. Run it after a change of a puzzle, of the simulation or of the
mapping; until then the test of ``codes_of`` fails.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np

from mapper.core.array_types import UInt8Array
from mapper.core.errors import ConfigError
from mapper.grid.occupancy_grid import FREE, OCCUPIED, OccupancyGrid
from mapper.puzzles import RECIPES
from mapper.puzzles.puzzle import mapped
from mapper.replay.overview import SIDE, cells_overview
from server.library.packs.picture import read_picture, write_codes
from server.puzzles.making import puzzle_config

FOLDER = Path(__file__).parent / "map_pictures"  #: of the files, in the colours of a light page


@lru_cache(maxsize=2 * len(RECIPES))
def picture_of(name: str, *, dark: bool) -> bytes:
    """Return the picture of a puzzle as PNG, in the colours of a light or a dark page.

    Raises :class:`ConfigError` for an unknown puzzle.
    """
    if name not in RECIPES:
        raise ConfigError("puzzle.unknown", f"There is no puzzle {name!r:.80}.")
    return read_picture(FOLDER / f"{name}.png", dark=dark)


def codes_of(name: str) -> UInt8Array:
    """Return the codes of a puzzle's picture (rows, cols), by simulating and mapping its drive."""
    spoiled = RECIPES[name].make(lambda _: None)
    config = puzzle_config(spoiled.reference).with_values(spoiled.start)
    return picture_codes(mapped(spoiled.log, config, spoiled.trajectory), config.log_odds_min)


def picture_codes(grid: OccupancyGrid, log_odds_min: float) -> UInt8Array:
    """Return the codes of a map's picture (rows, cols), row 0 at the greatest y, cropped to the observed cells.

    A cell is a square of pixels, so that large cells have sharp borders when the picture is enlarged. A cell at the
    lower clamp ``log_odds_min`` is drawn as free, as on the page of the attempt, because a high clamp keeps all cells
    from being certain enough to be classified as free.
    """
    rows, cols = (np.flatnonzero(np.any(grid.observed, axis=axis)) for axis in (1, 0))
    seen = np.s_[rows[0] : rows[-1] + 1, cols[0] : cols[-1] + 1]
    state = grid.classify()[seen]
    occupied, free = state == OCCUPIED, (state == FREE) | (grid.observed & (grid.log_odds <= log_odds_min))[seen]
    pixels = np.ones(2 * (max(1, SIDE // max(free.shape)),), dtype=np.bool_)
    return cells_overview(np.kron(free, pixels), np.kron(occupied, pixels))


def main() -> None:
    """Write a file for each puzzle, and remove the files of other puzzles."""
    FOLDER.mkdir(exist_ok=True)
    for file in FOLDER.glob("*.png"):
        if file.stem not in RECIPES:
            file.unlink()
    for name in RECIPES:
        write_codes(codes_of(name), FOLDER / f"{name}.png")


if __name__ == "__main__":
    main()
