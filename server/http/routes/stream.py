"""``/api/sessions/{id}/stream``: the WebSocket between one browser and a session."""

from __future__ import annotations

from fastapi import APIRouter, WebSocket

from server.http.guests import GuestRight, guests_may
from server.http.services import ServiceSettings, Sessions

router = APIRouter()


@router.websocket("/api/sessions/{session_id}/stream")
@guests_may(GuestRight.LINKED_SESSION)
async def stream(websocket: WebSocket, sessions: Sessions, settings: ServiceSettings, session_id: str) -> None:
    """Exchange messages with a session."""
    session = sessions.get(session_id)
    from server.http.stream_connection import exchange  # noqa: PLC0415 - what it imports came with the first session

    await exchange(websocket, session, settings.max_clients_per_session)
