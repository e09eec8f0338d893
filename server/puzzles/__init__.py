"""Puzzles: sessions of logs with a hidden fault, and how far each visitor is. Answers are checked here only."""

from server.puzzles.game import Game
from server.puzzles.making import LogSource, PuzzleSource, StorySource
from server.puzzles.puzzles import Puzzles
from server.puzzles.spec import AS_IT_IS, spec_of_log, spec_of_story

__all__ = [
    "AS_IT_IS",
    "Game",
    "LogSource",
    "PuzzleSource",
    "Puzzles",
    "StorySource",
    "spec_of_log",
    "spec_of_story",
]
