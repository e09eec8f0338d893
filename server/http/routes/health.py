"""``/livez``, ``/readyz`` and ``/metrics``: liveness, readiness and metrics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from fastapi import APIRouter, Request
from fastapi.responses import Response

from server.http.file_answer import file_answer
from server.http.guests import GuestRight, guests_may
from server.http.metrics import CONTENT_TYPE, summed
from server.http.services import Logs, ServiceMetrics, services_of

router = APIRouter(tags=["health"])


@dataclass(frozen=True, slots=True)
class Health:
    """State of the service."""

    status: Literal["alive", "ready"]


@router.get("/livez")
@guests_may(GuestRight.ALWAYS)
async def livez() -> Health:
    """Return 200 while the process runs."""
    return Health("alive")


@router.get("/readyz")
@guests_may(GuestRight.ALWAYS)
async def readyz(library: Logs) -> Health:
    """Return 200 once the stores are open and requests can be served; 503 if the stores are no longer available.

    Kernels are compiled when they are first used.
    """
    library.check_stores()
    return Health("ready")


@router.get("/metrics", **file_answer("text/plain"))
async def metrics(request: Request, figures: ServiceMetrics) -> Response:
    """Return the metrics of the service for Prometheus: with several workers, their sums."""
    worker = services_of(request.app).worker
    text = figures.text()
    if worker is not None:
        text = summed([text, *await worker.handover.figures_of_others()])
    return Response(text, media_type=CONTENT_TYPE)
