"""A link to a view of a log."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from mapper.core.errors import MapperError


class LinkGoneError(MapperError):
    """There is no such link: it never existed, or was revoked."""


@dataclass(frozen=True, slots=True)
class Link:
    """A link of ``owner`` to a log. Knowing the ``token`` permits to open it."""

    token: str
    owner: str
    log_id: str
    created_s: float
    view: dict[str, Any]
