"""A link to a view of a log."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from mapper.core.errors import MapperError


class LinkGoneError(MapperError):
    """There is no such link: never was, or it was revoked."""


@dataclass(frozen=True, slots=True)
class Link:
    """A link of ``owner`` to a log. Who knows the ``token`` may look."""

    token: str
    owner: str
    log_id: str
    created_s: float
    view: dict[str, Any]
