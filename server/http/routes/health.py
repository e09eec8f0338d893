"""``/livez``, ``/readyz`` and ``/metrics``: liveness, readiness and metrics."""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import Response

from server.http.guests import GuestRight, guests_may
from server.http.metrics import CONTENT_TYPE, summed
from server.http.services import Logs, ServiceMetrics, services_of

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
async def metrics(request: Request, figures: ServiceMetrics) -> Response:
    """Return the metrics of the service for Prometheus: with several workers, their sums."""
    worker = services_of(request.app).worker
    text = figures.text()
    if worker is not None:
        text = summed([text, *await worker.handover.figures_of_others()])
    return Response(text, media_type=CONTENT_TYPE)
