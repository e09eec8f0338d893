"""The answers to requests that fail unexpectedly, by the error, with a small application behind the middleware."""

from __future__ import annotations

import httpx
import pytest
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route

from server.http.errors import CatchAll, EnoughMemory
from server.work.memory import LEAST_BYTES, MemoryReserve


def client_of(app: Starlette) -> httpx.AsyncClient:
    return httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://service")


@pytest.mark.parametrize(
    ("error", "status", "code"),
    [
        (MemoryError(), 503, "service.memory"),
        (RuntimeError("can't start new thread"), 503, "service.memory"),
        (RuntimeError("a defect"), 500, "internal"),
    ],
)
async def test_a_request_that_fails_for_want_of_memory_is_no_defect(error: Exception, status: int, code: str) -> None:
    async def failing(_: Request) -> Response:
        raise error

    app = Starlette(routes=[Route("/", failing)])
    app.add_middleware(CatchAll)
    async with client_of(app) as client:
        answer = await client.get("/")
    assert (answer.status_code, answer.json()["code"]) == (status, code)
    assert answer.headers.get("retry-after") == ("30" if status == 503 else None)


async def test_what_begins_something_is_refused_while_memory_is_short() -> None:
    async def fine(_: Request) -> Response:
        return PlainTextResponse("fine")

    free = float("inf")
    app = Starlette(routes=[Route("/", fine, methods=["GET", "PUT", "POST", "DELETE"])])
    app.add_middleware(EnoughMemory, reserve=MemoryReserve(lambda: free))
    async with client_of(app) as client:
        assert (await client.put("/")).status_code == 200
        free = LEAST_BYTES - 1.0
        answers = {
            method: (await client.request(method, "/")).status_code for method in ("GET", "PUT", "POST", "DELETE")
        }
    assert answers == {"GET": 200, "PUT": 503, "POST": 503, "DELETE": 200}
