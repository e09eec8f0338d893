"""The puzzles of one server: those ready to solve, and the attempts at them by session."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import asdict
from typing import TYPE_CHECKING

from mapper.core.errors import ConfigError, WorkCancelledError
from mapper.core.limits import Limits
from mapper.puzzles import CAUSES, RECIPES, Puzzle
from server.puzzles.answers import NamedCause, OfferedPuzzle
from server.puzzles.game import Game
from server.puzzles.making import MAPPING, PuzzleSource, RecipeSource, Tell
from server.sessions import Plan
from server.sessions.view import LogView
from server.sources.log import LogModel
from server.sources.log_recording import first_replay

if TYPE_CHECKING:
    from server.sessions import SessionHost
    from server.sessions.hosting import ModelHost
    from server.sessions.making import Making
    from server.sessions.model import SessionModel

LOOK_S = 0.02  #: interval at which a thread that waits for another puzzle yields to sessions
KEPT = 16  #: number of puzzles kept ready; each has at most :data:`mapper.puzzles.puzzle.MAX_READINGS` readings


class Puzzles:
    """Attempts, and ready puzzles, each created once for all visitors. Puzzles are created on worker threads."""

    def __init__(self) -> None:
        self._ready: OrderedDict[str, Puzzle] = OrderedDict()
        self._lock = threading.Lock()  #: protects the ready puzzles
        self._making = threading.Lock()  #: held while one is created
        self._games: dict[str, Game] = {}  #: by session

    @staticmethod
    def offered() -> list[OfferedPuzzle]:
        """Return the included puzzles, without information about their causes."""
        return [OfferedPuzzle(recipe.name, recipe.level, recipe.title, recipe.story) for recipe in RECIPES.values()]

    @staticmethod
    def faults() -> list[NamedCause]:
        """Return the faults that can be added to a map."""
        return [NamedCause(cause.name, cause.label) for cause in CAUSES.values() if cause.of_log]

    @staticmethod
    def recipe(name: str) -> PuzzleSource:
        """Return the source of an included puzzle. Raises :class:`ConfigError` for an unknown one."""
        if name not in RECIPES:
            raise ConfigError("puzzle.unknown", f"There is no puzzle {name!r:.80}.")
        return RecipeSource(name)

    def _puzzle(
        self, key: str, source: PuzzleSource, limits: Callable[[], Limits], may_continue: Callable[[], bool], tell: Tell
    ) -> Puzzle:
        with self._lock:
            known = self._ready.get(key)
            if known is not None:
                self._ready.move_to_end(key)
                return known
        while not self._making.acquire(timeout=LOOK_S):
            if not may_continue():  # this also lets sessions compute that wait for this thread
                raise WorkCancelledError("puzzle.unwanted", "The making of the puzzle was cancelled.")
        try:
            with self._lock:
                known = self._ready.get(key)
            puzzle = known or source.make(limits, may_continue, tell)
        finally:
            self._making.release()
        with self._lock:
            self._ready[key] = puzzle
            while len(self._ready) > KEPT:
                self._ready.popitem(last=False)
        return puzzle

    def plan(self, key: str, source: PuzzleSource, title: str, name: str | None) -> Plan:
        """Return the plan of a session that shows a puzzle: the whole map, paused."""

        def make(host: ModelHost, making: Making) -> SessionModel:
            now: tuple[str, float | None] = ("Another puzzle is being made", None)

            def tell(what: str, done: float | None) -> None:
                nonlocal now
                now = (what, done)

            making.watched = lambda: now
            puzzle = self._puzzle(key, source, host.limits, making.may_continue, tell)
            tell(MAPPING, None)
            log = puzzle.shown
            view = LogView(None, puzzle.trajectory, asdict(puzzle.start), log.n_scans)
            replay = first_replay(log, view, host.limits(), making.may_continue)
            return LogModel(host, replay, view, title=title, first=puzzle.start)

        return Plan(make, name=name, interactive=False)

    def begin(self, session: SessionHost, key: str, title: str, story: str, level: int) -> Game:
        """Return the attempt of a session that was begun by :meth:`plan` with the same key."""
        with self._lock:
            puzzle = self._ready[key]
        choices = RECIPES[key].choices if key in RECIPES else ()
        game = self._games[session.id] = Game(title, story, level, puzzle, choices or tuple(CAUSES))
        session.on_close.append(lambda: self._end(session.id))
        return game

    def _end(self, session_id: str) -> None:
        self._games.pop(session_id, None)

    def game(self, session_id: str) -> Game:
        """Return the attempt of a session. Raises :class:`ConfigError` for a session without a puzzle."""
        game = self._games.get(session_id)
        if game is None:
            raise ConfigError("puzzle.no_game", "This session has no puzzle.")
        return game

    def forget(self, key: str) -> None:
        """Remove a deleted puzzle. Attempts at it continue."""
        with self._lock:
            self._ready.pop(key, None)
