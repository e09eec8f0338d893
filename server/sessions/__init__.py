"""Sessions: each owns one grid, its parameters and its clock."""

from mapper.simulation.live_map import LiveMap
from server.sessions.log_session import LogSession, first_config
from server.sessions.registry import SessionBudgetError, SessionNotFoundError, SessionRegistry
from server.sessions.session import Session
from server.sessions.simulation_session import SimulationSession
from server.sessions.view import LogView, SessionView

__all__ = [
    "LiveMap",
    "LogSession",
    "LogView",
    "Session",
    "SessionBudgetError",
    "SessionNotFoundError",
    "SessionRegistry",
    "SessionView",
    "SimulationSession",
    "first_config",
]
