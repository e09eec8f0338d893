"""Sessions: each owns one grid, its parameters and its clock."""

from server.sessions.log_session import LogSession, first_config
from server.sessions.registry import SessionBudgetError, SessionNotFoundError, SessionRegistry
from server.sessions.session import Session
from server.sessions.view import LogView, SessionView
from server.sessions.world_mapper import WorldMapper
from server.sessions.world_session import WorldSession

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
