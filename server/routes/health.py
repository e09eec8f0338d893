"""``/livez``, ``/readyz`` and ``/metrics``: what machines ask."""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import JSONResponse, Response

from server.metrics import CONTENT_TYPE
from server.routes.errors import error_response

router = APIRouter(tags=["health"])


@router.get("/livez")
async def livez() -> dict[str, str]:
    """Return 200 while the process runs."""
    return {"status": "alive"}


@router.get("/readyz")
async def readyz(request: Request) -> Response:
    """Tell whether the kernels are compiled, so that a first session starts at once."""
    if not request.app.state.warm.done():
        return error_response(
            503, "service.starting", "The kernels are being compiled: ready in a moment.", headers={"Retry-After": "1"}
        )
    if request.app.state.warm.exception() is not None:
        return error_response(503, "service.broken", "The kernels cannot be compiled; the service's log says why.")
    return JSONResponse({"status": "ready"})


@router.get("/metrics", response_class=Response)
async def metrics(request: Request) -> Response:
    """Return the metrics of the service for Prometheus."""
    return Response(request.app.state.metrics.text(), media_type=CONTENT_TYPE)
