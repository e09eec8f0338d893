"""The application. Importing this module starts nothing; :func:`create_app` returns one service."""

from __future__ import annotations

import asyncio
import inspect
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial

import structlog
from fastapi import FastAPI
from fastapi.exceptions import EndpointContext
from fastapi.routing import APIRoute, APIWebSocketRoute, _endpoint_context_cache
from starlette.middleware.gzip import GZipMiddleware
from starlette.routing import BaseRoute

from server.classes import Classes
from server.classes.classes import Prepared, PreparedHere
from server.downloads import Downloads
from server.http.brake import CodeGuesses, RequestPace
from server.http.errors import CatchAll, Ending, EnoughMemory, install_error_handlers
from server.http.metrics import Metrics
from server.http.routes import (
    class_puzzles,
    classes,
    contents,
    docs,
    fields,
    fleet,
    health,
    links,
    logs,
    maps,
    pages,
    puzzles,
    reports,
    scan_series,
    scenes,
    sensor,
    sessions,
    sign_out,
    trajectories,
    trajectory_errors,
)
from server.http.routes import downloads as download_files
from server.http.security import Security
from server.http.services import Services, install
from server.http.sign_ins import SignIns
from server.library.library import Library
from server.parts import stated
from server.scenes import Scenes
from server.sessions import Kind, SessionRegistry
from server.settings import Settings
from server.sources import KINDS
from server.version import package_version
from server.work.memory import MemoryReserve
from server.workers.worker import Worker

END_S = 2.0  #: seconds that the shutdown waits for sessions that compute or whose kernels are being compiled

_log = structlog.get_logger(__name__)


@asynccontextmanager
async def _lifespan(
    settings: Settings,
    kinds: Mapping[str, Kind],
    sign_ins: SignIns,
    reserve: MemoryReserve,
    worker: Worker | None,
    app: FastAPI,
) -> AsyncIterator[None]:
    metrics = Metrics()
    async with AsyncExitStack() as stack:
        guarding = asyncio.create_task(reserve.watch(), name="memory")
        stack.callback(guarding.cancel)
        registry = SessionRegistry(
            settings,
            remake_seconds=metrics.remake_seconds.observe,
            traffic=metrics.traffic,
            elsewhere=None if worker is None else worker.use,
        )
        metrics.watch(registry, kinds)
        await registry.start()
        stack.push_async_callback(_within, END_S, registry.shutdown)
        library = await asyncio.to_thread(Library, settings)
        library.sign_in_ends.take_over = sign_ins.take_over
        library.links.ended = registry.end_linked
        await library.start()
        stack.push_async_callback(library.close)
        downloads = Downloads(settings.data_dir)
        stack.push_async_callback(downloads.close)
        open_scenes = Scenes()
        stack.push_async_callback(open_scenes.close)
        is_own = (lambda _: True) if worker is None else worker.has_class
        opened = Classes(settings.max_class_followers, _prepared(settings, worker), is_own=is_own)
        for watch in (opened.watch, opened.watch_prepared) if worker else (opened.watch,):
            stack.callback(asyncio.create_task(watch(), name="classes").cancel)
        install(
            app,
            Services(
                settings=settings,
                metrics=metrics,
                sessions=registry,
                library=library,
                downloads=downloads,
                scenes=open_scenes,
                sign_ins=sign_ins,
                classes=opened,
                worker=worker,
                code_brake=_code_brake(worker),
            ),
        )
        yield


def _prepared(settings: Settings, worker: Worker | None) -> Prepared | None:
    """Return the class that is open from the start, None without one."""
    if worker is not None:
        return worker.prepared
    return None if settings.class_code is None else PreparedHere(settings.class_code)


def _code_brake(worker: Worker | None) -> CodeGuesses:
    if worker is None:
        return CodeGuesses()
    return CodeGuesses(of_visitor=worker.guesses.codes_of_visitor, of_network=worker.guesses.codes_of_network)


async def _within(seconds: float, end: Callable[[], Awaitable[None]]) -> None:
    """Await ``end()``, but no longer than ``seconds``."""
    try:
        async with asyncio.timeout(seconds):
            await end()
    except TimeoutError:
        _log.warning("sessions were still computing at shutdown", seconds=seconds)


def _state_places(routes: Iterable[BaseRoute]) -> None:
    """Pass the source location of each route's function to FastAPI, for its errors.

    Otherwise the first request of a route would read the source file and search for the end of the function: up to 60
    ms.
    """
    for route in routes:
        if isinstance(route, APIRoute | APIWebSocketRoute):
            code = inspect.unwrap(route.endpoint).__code__
            place = EndpointContext(file=code.co_filename, line=code.co_firstlineno, function=route.endpoint.__name__)
            _endpoint_context_cache[id(route.endpoint)] = place


def create_app(
    settings: Settings | None = None, kinds: Mapping[str, Kind] = KINDS, worker: Worker | None = None
) -> FastAPI:
    """Return the service for these settings (None: those of the environment), with sessions of these kinds.

    ``worker`` is the worker to which the settings belong, if there are several.
    """
    settings = (Settings() if settings is None else settings).with_token()
    token = None if settings.token is None else settings.token.get_secret_value()
    sign_ins = SignIns(token, settings.data_dir / "sign-ins.json")
    reserve = MemoryReserve()
    app = FastAPI(
        title="Gridbloom",
        description="Occupancy grid maps that fill in: live worlds and robot logs.",
        version=package_version(),
        openapi_url="/api/openapi.json",
        docs_url=None,  # FastAPI's own page loads its scripts from another host
        redoc_url=None,
        lifespan=partial(_lifespan, settings, kinds, sign_ins, reserve, worker),
    )
    install_error_handlers(app)
    routers = (
        health.router,
        sessions.creating(kinds),
        sessions.router,
        contents.router,
        reports.router,
        fields.router,
        scan_series.router,
        trajectory_errors.router,
        maps.router,
        download_files.router,
        logs.router,
        fleet.router,
        sensor.router,
        trajectories.router,
        links.router,
        puzzles.router,
        scenes.router,
        classes.router,
        class_puzzles.router,
        *stated("routes", "router"),
        docs.router,
        sign_out.router,
        pages.router,  # last, because it has a route for any other name
    )
    # The routes themselves, because FastAPI creates all models of an included router again, at its first request.
    routes = [route for router in routers for route in router.routes]
    app.router.routes += routes
    _state_places(routes)
    # The last one added is the outermost.
    app.add_middleware(CatchAll)
    app.add_middleware(EnoughMemory, reserve=reserve)
    # More than 16 KiB, which take 0.4 ms, are compressed on a thread.
    app.add_middleware(GZipMiddleware, minimum_size=1024, compresslevel=6, thread_minimum_size=1 << 14)
    app.add_middleware(RequestPace)
    wrong_tokens = None if worker is None else worker.guesses.tokens
    app.add_middleware(Security, settings=settings, routes=routes, sign_ins=sign_ins, wrong_tokens=wrong_tokens)
    app.add_middleware(Ending)
    return app
