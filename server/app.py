"""The application: everything put together. Importing this file does nothing; :func:`create_app` makes one service."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AsyncExitStack, asynccontextmanager

import structlog
from fastapi import FastAPI
from starlette.middleware.gzip import GZipMiddleware

from server.downloads import Downloads
from server.http.errors import CatchAll, Ending, install_error_handlers
from server.http.metrics import Metrics
from server.http.routes import compare as comparing
from server.http.routes import docs, doctor, health, links, logs, maps, pages, scenes, sessions, stream
from server.http.routes import downloads as taking
from server.http.security import Security
from server.library import Library
from server.scenes import Scenes
from server.sessions import SessionRegistry
from server.settings import Settings
from server.version import package_version

END_S = 2.0  #: seconds that the end of the service waits for sessions that compute, or whose kernels compile

_log = structlog.get_logger(__name__)


@asynccontextmanager
async def _lifespan(app: FastAPI) -> AsyncIterator[None]:
    state = app.state
    settings: Settings = state.settings
    async with AsyncExitStack() as stack:
        state.sessions = SessionRegistry(
            settings, remake_seconds=state.metrics.remake_seconds.observe, traffic=state.metrics.traffic
        )
        state.metrics.watch(state.sessions)
        await state.sessions.start()
        stack.push_async_callback(_within, END_S, state.sessions.shutdown)
        state.library = await asyncio.to_thread(Library, settings)
        await state.library.start()
        stack.push_async_callback(state.library.close)
        state.downloads = Downloads(settings.data_dir)
        stack.push_async_callback(state.downloads.close)
        state.scenes = Scenes()
        stack.push_async_callback(state.scenes.close)
        yield


async def _within(seconds: float, end: Callable[[], Awaitable[None]]) -> None:
    """Call ``end``, and give it up after so many seconds."""
    try:
        async with asyncio.timeout(seconds):
            await end()
    except TimeoutError:
        _log.warning("sessions still compute and are left behind", seconds=seconds)


def create_app(settings: Settings | None = None) -> FastAPI:
    """Return the service for these settings (None: those of the environment)."""
    settings = (Settings() if settings is None else settings).with_token()
    app = FastAPI(
        title="Gridbloom",
        description="Occupancy grid maps that fill in: live worlds and robot logs.",
        version=package_version(),
        openapi_url="/api/openapi.json",
        docs_url=None,  # FastAPI's own page loads its scripts from another host
        redoc_url=None,
        lifespan=_lifespan,
    )
    app.state.settings = settings
    app.state.metrics = Metrics()
    install_error_handlers(app)
    for part in (
        health,
        sessions,
        doctor,
        comparing,
        maps,
        taking,
        stream,
        logs,
        links,
        scenes,
        docs,
        pages,
    ):  # pages last: they take any other name
        app.include_router(part.router)
    # The last one added is the outermost.
    app.add_middleware(CatchAll)
    app.add_middleware(GZipMiddleware, minimum_size=1024, compresslevel=6)
    app.add_middleware(Security, settings=settings)
    app.add_middleware(Ending)
    return app
