"""Rights of guests: visitors without the service's token who follow a link.

Each route declares its right with :func:`guests_may`; a route without a declaration refuses guests.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import Enum
from typing import Any, TypeVar

from starlette.routing import BaseRoute, Match
from starlette.types import Scope

_MARK = "__guest_right__"

Endpoint = TypeVar("Endpoint", bound=Callable[..., Any])


class GuestRight(Enum):
    """Which guests may call a route."""

    NEVER = "never"  #: no visitor without the token
    ALWAYS = "always"  #: anyone, because the address holds no data, or its path contains the secret of a link
    LINKED_SESSION = "linked session"  #: anyone with the ``session_id`` of a session that was begun with a link


def guests_may(right: GuestRight) -> Callable[[Endpoint], Endpoint]:
    """Return a decorator that declares who may call an endpoint without the token. Place it below the route's own."""

    def mark(endpoint: Endpoint) -> Endpoint:
        setattr(endpoint, _MARK, right)
        return endpoint

    return mark


def guest_right(endpoint: Callable[..., Any]) -> GuestRight:
    """Return the declared right of an endpoint, ``NEVER`` if none is declared."""
    right: GuestRight = getattr(endpoint, _MARK, GuestRight.NEVER)
    return right


def right_of_request(routes: Sequence[BaseRoute], scope: Scope) -> tuple[GuestRight, dict[str, Any]]:
    """Return the right of the route that serves a request or a socket, and the parameters in its path.

    ``routes`` are in the order in which the application tries them. If no route matches the path and the method, the
    right is ``NEVER``.
    """
    for route in routes:
        match, child_scope = route.matches(scope)
        if match is Match.FULL:
            return guest_right(child_scope["endpoint"]), child_scope["path_params"]
    return GuestRight.NEVER, {}
