"""A small application with sessions and scenes on a loopback port, and a stand-in for viser's client."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest
import uvicorn
from fastapi import FastAPI
from starlette.requests import HTTPConnection

from server.http.routes.scenes import router
from server.http.services import get_scenes, get_sessions, get_visitor
from server.scenes import Scenes
from server.sessions import SessionRegistry
from server.settings import Settings
from tests.server.service import PATIENCE_S


async def _visitor(connection: HTTPConnection) -> str:
    return connection.cookies.get("visitor", "")


class Service:
    """The running application: its port, its sessions and its scenes."""

    def __init__(self, registry: SessionRegistry, scenes: Scenes) -> None:
        self.sessions = registry
        self.scenes = scenes
        self.port = 0


@pytest.fixture
def settings(tmp_path: Path) -> Settings:
    values: dict[str, Any] = {"data_dir": tmp_path / "data"}
    return Settings(**values)


@pytest.fixture
async def sessions(settings: Settings) -> AsyncIterator[SessionRegistry]:
    registry = SessionRegistry(settings)
    await registry.start()
    yield registry
    await registry.shutdown()


@pytest.fixture
async def service(sessions: SessionRegistry) -> AsyncIterator[Service]:
    scenes = Scenes()
    running = Service(sessions, scenes)

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        yield
        await scenes.close()

    app = FastAPI(lifespan=lifespan)
    app.include_router(router)
    app.dependency_overrides = {
        get_sessions: lambda: sessions,
        get_scenes: lambda: scenes,
        get_visitor: _visitor,
    }
    config = uvicorn.Config(app, host="127.0.0.1", port=0, log_level="warning", ws="websockets-sansio")
    server = uvicorn.Server(config)
    task = asyncio.create_task(server.serve())
    async with asyncio.timeout(PATIENCE_S):
        while not server.started:  # noqa: ASYNC110 - uvicorn offers no event
            await asyncio.sleep(0.01)
    running.port = server.servers[0].sockets[0].getsockname()[1]
    yield running
    server.should_exit = True
    await task
