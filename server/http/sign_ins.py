"""Cookies by which browsers prove that they have sent the service's token, and their expiry.

A cookie contains its creation time, a random name, and a keyed digest of both (HMAC-SHA-256, the key is derived from
the token). It does not contain the token, and cannot be created without it. It is valid for :data:`VALID_S`, until its
browser signs out, until all are signed out, or until the service has another token.
"""

from __future__ import annotations

import asyncio
import hashlib
import hmac
import json
import secrets
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

import structlog

from mapper.core.atomic_file import atomic_write

TOKEN_COOKIE = "gridbloom_token"  # noqa: S105 - the cookie's name
SIGNED_IN_COOKIE = "gridbloom_signed_in"  #: tells the pages that the other cookie exists, which they cannot read
VALID_S = 30 * 24 * 3600  #: validity of a cookie
MAX_ENDED = 4096  #: number of recorded cookies that ended early; beyond it, all up to the oldest one's time end

ALL = "*"  #: instead of a name
_log = structlog.get_logger(__name__)


class SignIns:
    """Creates, checks and ends cookies. Ended ones are stored in ``file``, so that they remain ended after a restart.

    Any thread may end cookies, because writing the file can take long.
    """

    def __init__(self, token: str | None, file: Path, clock: Callable[[], float] = time.time) -> None:
        self._key = None if token is None else hmac.digest(token.encode(), b"sign-in", hashlib.sha256)
        self._file = file
        self._clock = clock
        self._ended: dict[str, int] = {}  #: creation time by name
        self._ended_until = 0  #: all cookies created up to this time have ended
        self._ending = threading.Lock()
        self._watches: dict[object, Callable[[], None]] = {}
        self._read()

    def cookie(self) -> str:
        """Return the cookie for a browser that has sent the token."""
        issued, name = max(int(self._clock()), self._ended_until + 1), secrets.token_hex(12)
        return f"{issued:x}.{name}.{self._digest(issued, name)}"

    def is_valid(self, cookie: str) -> bool:
        """Return whether a cookie proves the token."""
        parsed = self._parsed(cookie)
        if parsed is None:
            return False
        issued, name = parsed
        return self._ended_until < issued and name not in self._ended and self._clock() - issued < VALID_S

    def end(self, cookie: str) -> None:
        """End one cookie. Raises :class:`OSError` if that cannot be recorded; it has ended nevertheless."""
        parsed = self._parsed(cookie)
        if parsed is None:
            return
        issued, name = parsed
        with self._ending:
            self._end({name: issued})
            self._look()
            self._write()

    def end_all(self) -> None:
        """End all cookies created so far. Raises like :meth:`end`."""
        with self._ending:
            # A cookie created in the second of an earlier end has the next second as its time.
            self._ended_until = max(int(self._clock()), self._ended_until + 1)
            self._ended = {}
            self._look()
            self._write()

    @property
    def ended(self) -> Mapping[str, int]:
        """Cookies that ended early: creation times by name; ``*`` stands for all up to its time."""
        return {**self._ended, ALL: self._ended_until}

    def take_over(self, ended: Mapping[str, int]) -> None:
        """End cookies that other services on the same database have ended."""
        with self._ending:
            self._ended_until = max(self._ended_until, ended.get(ALL, 0))
            self._end({name: issued for name, issued in ended.items() if name != ALL})
            self._look()

    @contextmanager
    def watching(self, cookie: str) -> Iterator[asyncio.Event]:
        """Yield an event that is set once ``cookie`` is no longer valid, because it was ended or expired.

        The event belongs to the caller's event loop; other threads may end cookies.
        """
        loop, over = asyncio.get_running_loop(), asyncio.Event()

        def look() -> None:
            if not self.is_valid(cookie):
                over.set()

        def look_soon() -> None:
            with suppress(RuntimeError):  # the loop is closed
                loop.call_soon_threadsafe(look)

        parsed, watch = self._parsed(cookie), object()
        left_s = 0.0 if parsed is None else parsed[0] + VALID_S - self._clock()
        timer = loop.call_later(max(0.0, left_s), look)
        self._watches[watch] = look_soon
        try:
            look()
            yield over
        finally:
            del self._watches[watch]
            timer.cancel()

    def _look(self) -> None:
        for look in [*self._watches.values()]:
            look()

    def _end(self, names: Mapping[str, int]) -> None:
        oldest = max(self._clock() - VALID_S, self._ended_until)
        ended = {key_: at for key_, at in {**self._ended, **names}.items() if at > oldest}
        while len(ended) > MAX_ENDED:
            first = min(ended, key=ended.__getitem__)
            self._ended_until = max(self._ended_until, ended.pop(first))
        self._ended = ended

    def _digest(self, issued: int, name: str) -> str:
        return hmac.digest(self._key or b"", f"{issued:x}.{name}".encode(), hashlib.sha256).hex()

    def _parsed(self, cookie: str) -> tuple[int, str] | None:
        """Return the creation time and the name of a cookie of this service; None for any other text."""
        parts = cookie.split(".")
        if self._key is None or len(parts) != 3 or len(cookie) > 200:
            return None
        try:
            issued = int(parts[0], 16)
        except ValueError:
            return None
        expected = self._digest(issued, parts[1])
        return (issued, parts[1]) if hmac.compare_digest(parts[2].encode(), expected.encode()) else None

    def _read(self) -> None:
        try:
            entries = json.loads(self._file.read_text(encoding="utf-8"))
            self._ended_until = int(entries["ended_until"])
            self._ended = {str(name): int(at) for name, at in entries["ended"].items()}
        except FileNotFoundError:
            return
        except (OSError, ValueError, TypeError, KeyError, AttributeError):
            # The ended cookies are unknown, so everyone must send the token again.
            _log.warning("the record of ended sign-ins cannot be read; all have ended", file=self._file.name)
            self._ended_until = int(self._clock())

    def _write(self) -> None:
        text = json.dumps({"ended_until": self._ended_until, "ended": self._ended})
        with atomic_write(self._file) as file:
            file.write(text.encode())
