"""Whose browser a connection to viser is: the proxy says it in a header, callbacks of the connection read it here."""

from __future__ import annotations

from contextvars import ContextVar

VISITOR_HEADER = "X-Gridbloom-Visitor"

visitor_of_connection: ContextVar[str] = ContextVar("visitor_of_connection", default="")
"""The visitor of the connection whose messages the present task handles."""
