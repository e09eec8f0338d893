"""Access to logs by session: anyone with the address of a log's session acts for the visitor who opened it.

A session that was begun with a shared link is read-only, even through its own address.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

from mapper.core.errors import MapperError
from server.sessions import SessionRegistry
from server.sessions.parts import Recording, Viewed

if TYPE_CHECKING:
    from server.library.library import Library
    from server.sessions import SessionHost

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class SessionOfLog:
    """A session of a log."""

    session: SessionHost
    recording: Recording

    @property
    def owner(self) -> str:
        """The visitor who began it, and whose library contains the log."""
        return self.session.owner

    @property
    def log_id(self) -> str:
        """Id of the log."""
        return self.recording.log_id


def log_owner(session: SessionHost, library: Library) -> str:
    """Return whose log a session shows: for a guest that of the link's owner."""
    return session.owner if session.link is None else library.links.get(session.link).owner


def part_of_log(
    session: SessionHost, kind: type[T], problem: str = "This is possible with a log only, not with a simulation."
) -> T:
    """Return the implementation of an interface in a session of a log.

    Raises :class:`MapperError` with the message ``problem`` for another session.
    """
    part = session.model.find(kind)
    if part is None:
        raise MapperError("session.not_a_log", problem)
    return part


def session_of_log(sessions: SessionRegistry, session_id: str) -> SessionOfLog:
    """Return a session of a log. Raises :class:`MapperError` for a session of another kind."""
    session = sessions.get(session_id)
    return SessionOfLog(session, part_of_log(session, Recording))


def shareable_session(sessions: SessionRegistry, session_id: str) -> tuple[SessionHost, Viewed]:
    """Return a session that a link can share, and its view.

    Raises :class:`MapperError` for a session of another kind, and for one that was begun with a link.
    """
    session = sessions.get(session_id)
    viewed = part_of_log(session, Viewed)
    _refuse_guests(session)
    return session, viewed


def _refuse_guests(session: SessionHost) -> None:
    if session.link is not None:
        raise MapperError("link.read_only", "This link shares a view of a log; the log itself cannot be changed.")


def writable_session(sessions: SessionRegistry, session_id: str) -> SessionOfLog:
    """Return the same as :func:`session_of_log`. Raises :class:`MapperError` also if it was begun with a link."""
    of_log = session_of_log(sessions, session_id)
    _refuse_guests(of_log.session)
    return of_log
