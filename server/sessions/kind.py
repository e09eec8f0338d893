"""A kind of session: its request, and the plan that creates its model."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

from pydantic import BaseModel, Field, SkipValidation

from mapper.core.parameter import Value
from mapper.sensors.scan import ScanLog
from server.library.library import Library
from server.sessions.making import Making

if TYPE_CHECKING:
    from server.sessions.hosting import ModelHost
    from server.sessions.model import SessionModel


GivenValues: TypeAlias = dict[str, Annotated[Value, SkipValidation]]
"""Parameters by name in a request: their table checks them, and names the one that is wrong."""


class SessionRequest(BaseModel, extra="forbid"):
    """The body of ``POST /api/sessions``. Each kind derives a class whose ``kind`` is a literal, its name."""

    kind: str
    playing: bool = Field(True, description="Whether the session plays from the start.")
    name: str | None = Field(
        None,
        max_length=100,
        description="A name under which /api/sessions/making/{name} returns the progress until the session is there.",
    )


@dataclass(frozen=True, slots=True)
class Plan:
    """Plan for creating the model of one session, within the budgets of the registry."""

    make: Callable[[ModelHost, Making], SessionModel]
    """Creates the model (worker thread). It calls :meth:`Making.may_continue` and raises
    :class:`mapper.core.errors.WorkCancelledError` if that returns False."""
    logs: tuple[ScanLog, ...] = ()  #: logs that the model will hold in memory
    name: str | None = None  #: name under which the page requests the progress
    interactive: bool = True  #: False for long work, which is deferred while short work waits
    playing: bool = True  #: False: initially paused, whatever the model's default


@dataclass(frozen=True, slots=True)
class Resources:
    """Resources that a plan may use.

    They are the visitor's logs, the longest computing time for replaying a story in seconds, and the object to which
    progress is reported.
    """

    visitor: str
    library: Library
    max_story_s: float
    making: Making


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of session."""

    request: type[SessionRequest]
    plan: Callable[[Any, Resources], Awaitable[Plan]]
    """Returns the plan for a request. Raises :class:`mapper.core.errors.MapperError` if the request is refused."""
