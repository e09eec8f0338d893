"""Sessions: a host (clients, clock, queue of commands, budget) and a model (what is computed and shown)."""

from server.sessions.host import SessionHost
from server.sessions.kind import Kind, Plan
from server.sessions.kinds import KINDS
from server.sessions.model import SessionModel
from server.sessions.models.log_kind import log_plan
from server.sessions.registry import SessionBudgetError, SessionNotFoundError, SessionRegistry
from server.sessions.view import LogView

__all__ = [
    "KINDS",
    "Kind",
    "LogView",
    "Plan",
    "SessionBudgetError",
    "SessionHost",
    "SessionModel",
    "SessionNotFoundError",
    "SessionRegistry",
    "log_plan",
]
