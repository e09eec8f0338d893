"""The kinds of sessions: what each shows and computes, and the request and the plan of each."""

from server.sources.kinds import KINDS
from server.sources.log_kind import costmaps_plan, log_plan

__all__ = ["KINDS", "costmaps_plan", "log_plan"]
