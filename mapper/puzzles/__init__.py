"""Puzzles: maps with a hidden fault to be identified and repaired.

Each name is imported from its module on first use, because the map measures do not need the simulator.
"""

from typing import TYPE_CHECKING

from mapper.core.lazy_imports import imported_later

if TYPE_CHECKING:
    from mapper.puzzles.causes import CAUSES, Cause
    from mapper.puzzles.puzzle import Puzzle, puzzle_of, shortened
    from mapper.puzzles.recipes import RECIPES, Recipe
    from mapper.puzzles.scoring import points, repair_share
    from mapper.puzzles.spoiling import Spoiled, spoil

__all__ = [
    "CAUSES",
    "RECIPES",
    "Cause",
    "Puzzle",
    "Recipe",
    "Spoiled",
    "points",
    "puzzle_of",
    "repair_share",
    "shortened",
    "spoil",
]

__getattr__ = imported_later(__name__, __file__)
