"""The worker to which a request belongs, by its path and its visitor: the rules of ``deploy/haproxy.cfg``."""

from __future__ import annotations

import re
import zlib
from collections.abc import Mapping
from types import MappingProxyType
from urllib.parse import unquote

from server.classes.classes import normalised

PLACE_HEADER = "X-Gridbloom-Place"
VISITOR_COOKIE = "gridbloom_visitor"

_LINE = re.compile(rb"[A-Z]+ (?:[a-z]+://[^/ ]+)?(/[^ ?]*)")
_SESSION = re.compile(rb"/(?:api/sessions|scenes)/([0-9a-z]{1,32})[.]")
_CLASS = re.compile(rb"/(?:api/classes|class)/([A-Za-z][^/]*)")
_COOKIE = re.compile(rb"\r\ncookie:(?:[^\r\n]*?[ ;])?" + VISITOR_COOKIE.encode() + rb"=([^;\r\n ]*)", re.IGNORECASE)
_PLACE = re.compile(rb"\r\n" + PLACE_HEADER.encode() + rb": *([0-9a-z]{1,32}) *\r\n", re.IGNORECASE)
_NONE: Mapping[str, int] = MappingProxyType({})
#: Requests that every worker answers alike: the files of the pages, and liveness.
_ANYWHERE = re.compile(rb"/(?:assets/.*|livez|readyz)")


def worker_of_place(place: str, workers: int) -> int:
    """Return the worker of a place, which is the beginning of a session's id; a number is used as is."""
    return (int(place) if place.isascii() and place.isdigit() else zlib.crc32(place.encode())) % workers


def worker_of_class(code: str, workers: int) -> int:
    """Return the worker of the class with this code, in the form returned by :func:`normalised`."""
    return zlib.crc32(code.encode()) % workers


def worker_of(head: bytes, address: str, workers: int, classes: Mapping[str, int] = _NONE) -> int | None:
    """Return the worker to which a request belongs; None if each of them may answer it.

    ``head`` is the request at least up to the end of its headers, ``address`` that of the client, which is used for
    visitors without a cookie. ``classes`` contains the workers of classes whose codes do not determine them.
    """
    head = head[: head.find(b"\r\n\r\n") + 2]
    line = _LINE.match(head)
    if line is None:  # not HTTP; any worker refuses it
        return None
    path = line[1]
    if _ANYWHERE.fullmatch(path):
        return None
    if session := _SESSION.match(path):
        return worker_of_place(session[1].decode(), workers)
    if room := _CLASS.match(path):
        code = normalised(unquote(room[1].decode("latin-1")))
        return classes[code] if code in classes else worker_of_class(code, workers)
    if place := _PLACE.search(head):  # a reverse proxy has chosen this service by it
        return worker_of_place(place[1].decode(), workers)
    cookie = _COOKIE.search(head)
    return zlib.crc32(cookie[1] if cookie and cookie[1] else address.encode()) % workers
