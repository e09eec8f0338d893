"""A kind of session: what a request for one says, and how its model is made."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from mapper.sensors.scan import ScanLog
from server.library import Library
from server.sessions.hosting import ModelHost
from server.sessions.making import Making
from server.sessions.model import SessionModel


class SessionRequest(BaseModel):
    """The body of ``POST /api/sessions``. Each kind derives its own, in which ``kind`` is a literal: its name."""

    model_config = ConfigDict(extra="forbid")

    kind: str
    playing: bool = Field(True, description="Whether time passes from the start.")


@dataclass(frozen=True, slots=True)
class Plan:
    """How the model of one session is made, within the budgets of the registry."""

    make: Callable[[ModelHost, Making], SessionModel]
    """Makes the model (worker thread); asks :meth:`Making.may_continue` meanwhile, and raises
    :class:`mapper.core.errors.WorkCancelledError` where that is False."""
    logs: tuple[ScanLog, ...] = ()  #: logs that the model will hold in memory
    name: str | None = None  #: under which the visitor's page asks how far it is
    waited_for: bool = True  #: False for work that takes so long that others' short work goes first
    playing: bool = True  #: False: time stands still at first, whatever the model says


@dataclass(frozen=True, slots=True)
class Resources:
    """What a plan may use: the visitor's logs, and the computing time that replaying a story may take, seconds."""

    visitor: str
    library: Library
    max_story_s: float


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of session."""

    request: type[SessionRequest]
    plan: Callable[[Any, Resources], Awaitable[Plan]]
    """Returns the plan for such a request. Raises :class:`mapper.core.errors.MapperError` for one that is refused."""
