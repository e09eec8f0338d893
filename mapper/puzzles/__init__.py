"""Puzzles: maps with a hidden fault, whose cause is to be named and repaired.

Each name is imported from its module with its first use: the measures of a map do without the simulator.
"""

from typing import TYPE_CHECKING

from mapper.core.lazy_imports import attributes_from

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

__getattr__ = attributes_from(
    __name__,
    {
        "CAUSES": "mapper.puzzles.causes",
        "RECIPES": "mapper.puzzles.recipes",
        "Cause": "mapper.puzzles.causes",
        "Puzzle": "mapper.puzzles.puzzle",
        "Recipe": "mapper.puzzles.recipes",
        "Spoiled": "mapper.puzzles.spoiling",
        "points": "mapper.puzzles.scoring",
        "puzzle_of": "mapper.puzzles.puzzle",
        "repair_share": "mapper.puzzles.scoring",
        "shortened": "mapper.puzzles.puzzle",
        "spoil": "mapper.puzzles.spoiling",
    },
)
