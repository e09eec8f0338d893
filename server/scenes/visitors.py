"""The browser behind a connection to viser. The proxy sends it in headers, which are read here."""

from __future__ import annotations

from contextvars import ContextVar
from typing import NamedTuple

VISITOR_HEADER = "X-Gridbloom-Visitor"
PAGE_HEADER = "X-Gridbloom-Page"


class Viewer(NamedTuple):
    """Viewer of a scene: the visitor, and the page of the view, by the name that it chose."""

    visitor: str = ""
    page: str = ""  #: empty for none


viewer_of_connection: ContextVar[Viewer] = ContextVar("viewer_of_connection", default=Viewer())  # noqa: B039 - immutable
"""The viewer of the connection whose messages the current task handles."""
