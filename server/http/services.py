"""The services that the routes use, as typed FastAPI dependencies."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any

from fastapi import Depends
from starlette.applications import Starlette
from starlette.requests import HTTPConnection

from server.classes import Classes
from server.downloads import Downloads
from server.http.brake import Brake, CodeGuesses
from server.http.metrics import Metrics
from server.http.sign_ins import SignIns
from server.imports import imported
from server.library.library import Library
from server.scenes import Scenes
from server.sessions import SessionRegistry
from server.settings import Settings
from server.work.fair_lock import FairLock
from server.workers.worker import Worker

if TYPE_CHECKING:
    from server.puzzles.puzzles import Puzzles


@dataclass(frozen=True, slots=True)
class Services:
    """All services of a running application. Created once, at start-up, and stored with :func:`install`."""

    settings: Settings
    metrics: Metrics
    sessions: SessionRegistry
    library: Library
    downloads: Downloads
    scenes: Scenes
    classes: Classes
    sign_ins: SignIns
    worker: Worker | None = None  #: this worker, if there are several
    request_work: FairLock = field(default_factory=FairLock)  #: computations of requests: one at a time, in rotation
    code_brake: CodeGuesses = field(default_factory=CodeGuesses)
    #: Copies of a lecturer's world by one follower: each replays its whole history.
    copy_brake: Brake = field(default_factory=lambda: Brake(burst=6, per_minute=6.0))


def install(app: Starlette, services: Services) -> None:
    """Store the services of an application."""
    app.state.services = services


def services_of(app: Starlette) -> Services:
    """Return the services of an application that has started."""
    services: Services = app.state.services
    return services


# Dependencies are coroutines, because FastAPI would run plain functions on a thread.


async def get_settings(connection: HTTPConnection) -> Settings:
    """Return the settings."""
    return services_of(connection.app).settings


async def get_metrics(connection: HTTPConnection) -> Metrics:
    """Return the metrics."""
    return services_of(connection.app).metrics


async def get_sessions(connection: HTTPConnection) -> SessionRegistry:
    """Return the session registry."""
    return services_of(connection.app).sessions


async def get_library(connection: HTTPConnection) -> Library:
    """Return the log library."""
    return services_of(connection.app).library


async def get_downloads(connection: HTTPConnection) -> Downloads:
    """Return the downloads."""
    return services_of(connection.app).downloads


async def get_scenes(connection: HTTPConnection) -> Scenes:
    """Return the 3D scenes."""
    return services_of(connection.app).scenes


async def get_classes(connection: HTTPConnection) -> Classes:
    """Return the classes."""
    return services_of(connection.app).classes


async def get_code_brake(connection: HTTPConnection) -> CodeGuesses:
    """Return the brake on guessing class codes."""
    return services_of(connection.app).code_brake


async def get_copy_brake(connection: HTTPConnection) -> Brake:
    """Return the brake on copies of lecturers' worlds, by visitor."""
    return services_of(connection.app).copy_brake


async def get_puzzles(connection: HTTPConnection) -> Any:  # noqa: ANN401 - FastAPI reads annotations at run time
    """Return the puzzles."""
    state = connection.app.state
    if not hasattr(state, "puzzles"):
        await imported("server.puzzles.puzzles")
        from server.puzzles.puzzles import Puzzles  # noqa: PLC0415 - the simulator and the maps, imported with the first use

        if not hasattr(state, "puzzles"):  # created by another request in the meantime
            state.puzzles = Puzzles()
    puzzles: Puzzles = state.puzzles
    return puzzles


async def get_request_work(connection: HTTPConnection) -> FairLock:
    """Return the lock that a request holds while it computes on a thread."""
    return services_of(connection.app).request_work


async def get_visitor(connection: HTTPConnection) -> str:
    """Return the id of the visitor who sent the request, from the cookie (:mod:`server.http.security`)."""
    visitor: str = connection.state.visitor
    return visitor


async def get_is_signed_in(connection: HTTPConnection) -> bool:
    """Return whether the request proves the service's token; True without one."""
    is_signed_in: bool = connection.state.is_signed_in
    return is_signed_in


ServiceSettings = Annotated[Settings, Depends(get_settings)]
ServiceMetrics = Annotated[Metrics, Depends(get_metrics)]
Sessions = Annotated[SessionRegistry, Depends(get_sessions)]
Logs = Annotated[Library, Depends(get_library)]
FileDownloads = Annotated[Downloads, Depends(get_downloads)]
OpenClasses = Annotated[Classes, Depends(get_classes)]
CodeBrake = Annotated[CodeGuesses, Depends(get_code_brake)]
CopyBrake = Annotated[Brake, Depends(get_copy_brake)]
OpenScenes = Annotated[Scenes, Depends(get_scenes)]
RequestWork = Annotated[FairLock, Depends(get_request_work)]
if TYPE_CHECKING:
    AllPuzzles = Puzzles
else:
    AllPuzzles = Annotated[Any, Depends(get_puzzles)]
Visitor = Annotated[str, Depends(get_visitor)]
IsSignedIn = Annotated[bool, Depends(get_is_signed_in)]
