"""``/livez``, ``/readyz`` and ``/metrics``: what machines ask."""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import Response

from server.http.metrics import CONTENT_TYPE

router = APIRouter(tags=["health"])


@router.get("/livez")
async def livez() -> dict[str, str]:
    """Return 200 while the process runs."""
    return {"status": "alive"}


@router.get("/readyz")
async def readyz() -> dict[str, str]:
    """Tell that visitors may come: the stores are open. Kernels compile when they are first needed."""
    return {"status": "ready"}


@router.get("/metrics", response_class=Response)
async def metrics(request: Request) -> Response:
    """Return the metrics of the service for Prometheus."""
    return Response(request.app.state.metrics.text(), media_type=CONTENT_TYPE)
