"""A service for hostile visitors, a second visitor beside them, and a log that must show no defects."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager

import pytest
import structlog

from server.logging import configure_logging
from tests.server.service import PATIENCE_S, Service, Watcher, running, settings_for, until


@pytest.fixture(scope="session")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """One service for all of them."""
    folder = tmp_path_factory.mktemp("hostile")
    with running(settings_for(folder, max_sessions=200, max_sessions_per_visitor=200)) as service:
        until(lambda: service.http.get("/readyz").status_code == 200)
        yield service


class _Collector(logging.Handler):
    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.lines: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        if record.levelno >= logging.ERROR or record.exc_info:
            self.lines.append(self.format(record))


@pytest.fixture(autouse=True)
def no_defects() -> Iterator[None]:
    """Whatever a visitor sends is no error of the service's: none may be logged."""
    root = logging.getLogger()
    kept = (root.handlers, root.level)
    configure_logging("console", "info")
    collector = _Collector()
    root.handlers = [collector]
    try:
        yield
    finally:
        root.handlers, level = kept
        root.setLevel(level)
        structlog.reset_defaults()
    assert collector.lines == []


@pytest.fixture(autouse=True)
def nothing_left(request: pytest.FixtureRequest) -> Iterator[None]:
    """End all that one test began or sent before the next one."""
    yield
    if "service" in request.fixturenames:
        http = request.getfixturevalue("service").http
        for kind in ("sessions", "logs"):
            for entry in http.get(f"/api/{kind}").json()[kind]:
                http.delete(f"/api/{kind}/{entry['id']}")


@pytest.fixture
def undisturbed() -> Callable[[Service], AbstractAsyncContextManager[Watcher]]:
    """A context in which somebody else's session has to go on, and after which the service has to answer."""

    @asynccontextmanager
    async def watching(service: Service) -> AsyncIterator[Watcher]:
        session_id = await asyncio.to_thread(service.begin)
        async with service.connect(session_id) as socket:
            watcher = Watcher(socket)
            await watcher.until(lambda: watcher.frames > 2)
            reading = asyncio.create_task(watcher.until(lambda: False))
            try:
                yield watcher
                frames = watcher.frames
                async with asyncio.timeout(PATIENCE_S):
                    while watcher.frames < frames + 3:
                        assert not reading.done(), reading.exception()
                        await asyncio.sleep(0.01)
            finally:
                reading.cancel()
                await asyncio.gather(reading, return_exceptions=True)
        assert (await asyncio.to_thread(service.http.get, "/livez")).status_code == 200
        await asyncio.to_thread(service.http.delete, f"/api/sessions/{session_id}")

    return watching
