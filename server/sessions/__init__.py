"""Sessions: each owns one grid, its parameters and its clock."""

from mapper.simulation.live_map import WorldMapper
from server.sessions.log_session import LogSession, first_config
from server.sessions.registry import SessionBudgetError, SessionNotFoundError, SessionRegistry
from server.sessions.session import Session
from server.sessions.simulation_session import WorldSession
from server.sessions.view import LogView, SessionView

__all__ = [
    "LogSession",
    "LogView",
    "Session",
    "SessionBudgetError",
    "SessionNotFoundError",
    "SessionRegistry",
    "SessionView",
    "WorldMapper",
    "WorldSession",
    "first_config",
]
