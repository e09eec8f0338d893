"""``/livez``, ``/readyz`` and ``/metrics``: liveness, readiness and metrics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from fastapi import APIRouter
from fastapi.responses import Response

from server.http.file_answer import file_answer
from server.http.guests import GuestRight, guests_may
from server.http.metrics import CONTENT_TYPE
from server.http.services import Logs, ServiceMetrics

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
    """Return 200 once requests can be served: the stores are open, and still there; 503 if they are not any more.

    Kernels are compiled when they are first used.
    """
    library.check_stores()
    return Health("ready")


@router.get("/metrics", **file_answer("text/plain"))
async def metrics(figures: ServiceMetrics) -> Response:
    """Return the metrics of the service for Prometheus."""
    return Response(figures.text(), media_type=CONTENT_TYPE)
