"""``/livez``, ``/readyz`` and ``/metrics``: liveness, readiness and metrics."""

from __future__ import annotations

from fastapi import APIRouter
from fastapi.responses import Response

from server.http.guests import GuestRight, guests_may
from server.http.metrics import CONTENT_TYPE
from server.http.services import Logs, ServiceMetrics

router = APIRouter(tags=["health"])


@router.get("/livez")
@guests_may(GuestRight.ALWAYS)
async def livez() -> dict[str, str]:
    """Return 200 while the process runs."""
    return {"status": "alive"}


@router.get("/readyz")
@guests_may(GuestRight.ALWAYS)
async def readyz(library: Logs) -> dict[str, str]:
    """Return 200 once requests can be served: the stores are open, and still there; 503 if they are not any more.

    Kernels are compiled when they are first used.
    """
    library.check_stores()
    return {"status": "ready"}


@router.get("/metrics", response_class=Response)
async def metrics(figures: ServiceMetrics) -> Response:
    """Return the metrics of the service for Prometheus."""
    return Response(figures.text(), media_type=CONTENT_TYPE)
