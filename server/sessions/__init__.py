"""Sessions: a host (clients, clock, queue of commands, budget) and a model (what is computed and shown)."""

from typing import TYPE_CHECKING

from mapper.core.lazy_imports import imported_later
from server.sessions.kind import Kind, Plan
from server.sessions.registry import SessionBudgetError, SessionNotFoundError, SessionRegistry
from server.sessions.view import LogView

if TYPE_CHECKING:
    from server.sessions.host import SessionHost
    from server.sessions.model import SessionModel

__all__ = [
    "Kind",
    "LogView",
    "Plan",
    "SessionBudgetError",
    "SessionHost",
    "SessionModel",
    "SessionNotFoundError",
    "SessionRegistry",
]

# The stream and the arrays of the layers are imported when the first session is created.
__getattr__ = imported_later(__name__, __file__)
