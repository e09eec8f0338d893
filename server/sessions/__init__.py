"""Sessions: a host (clients, clock, queue of commands, budget) and a model (what is computed and shown)."""

from typing import TYPE_CHECKING

from mapper.core.lazy_imports import attributes_from
from server.sessions.kind import Kind, Plan
from server.sessions.kinds import KINDS
from server.sessions.models.log_kind import costmaps_plan, log_plan
from server.sessions.registry import SessionBudgetError, SessionNotFoundError, SessionRegistry
from server.sessions.view import LogView

if TYPE_CHECKING:
    from server.sessions.host import SessionHost
    from server.sessions.model import SessionModel

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
    "costmaps_plan",
    "log_plan",
]

# The stream and the arrays of layers are imported with the first session.
__getattr__ = attributes_from(
    __name__, {"SessionHost": "server.sessions.host", "SessionModel": "server.sessions.model"}
)
