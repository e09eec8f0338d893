"""Whose browser a connection to viser is: the proxy says it in headers, callbacks of the connection read it here."""

from __future__ import annotations

from contextvars import ContextVar
from typing import NamedTuple

VISITOR_HEADER = "X-Gridbloom-Visitor"
PAGE_HEADER = "X-Gridbloom-Page"


class Viewer(NamedTuple):
    """Who looks at a scene: the visitor, and the page that the view is in, by the name that it gave itself."""

    visitor: str = ""
    page: str = ""  #: empty for none


viewer_of_connection: ContextVar[Viewer] = ContextVar("viewer_of_connection", default=Viewer())  # noqa: B039 - immutable
"""The viewer of the connection whose messages the present task handles."""
