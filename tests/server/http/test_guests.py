"""Rights of guests on each route, against a table that is written out here."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from fastapi import APIRouter
from fastapi.routing import iter_route_contexts
from starlette.types import Scope

from server.app import create_app
from server.http.guests import GuestRight, guest_right, guests_may, right_of_request
from server.settings import Settings

ALWAYS = {
    ("GET", "/livez"),
    ("GET", "/readyz"),
    ("GET", "/assets/{name:path}"),
    ("HEAD", "/assets/{name:path}"),
    ("GET", "/shared/{token}"),
    ("HEAD", "/shared/{token}"),
    ("GET", "/api/shared/{token}"),
    ("POST", "/api/shared/{token}/sessions"),
    ("GET", "/api/sessions/making/{name}"),
    ("GET", "/api/classes/{code}"),
    ("SOCKET", "/api/classes/{code}/stream"),
    ("SOCKET", "/api/classes/{code}/session"),
    ("POST", "/api/classes/{code}/sessions"),
    ("POST", "/api/classes/{code}/puzzle/sessions"),
    ("GET", "/api/shared-puzzles/{token}"),
    ("POST", "/api/shared-puzzles/{token}/sessions"),
    ("GET", "/puzzle/{token}"),
    ("HEAD", "/puzzle/{token}"),
    ("GET", "/join"),
    ("HEAD", "/join"),
    ("GET", "/class/{code}"),
    ("GET", "/class/{code}/{name}"),
    ("HEAD", "/class/{code}/{name}"),
}
LINKED_SESSION = {
    ("GET", "/api/sessions/{session_id}"),
    ("SOCKET", "/api/sessions/{session_id}/stream"),
    ("GET", "/api/sessions/{session_id}/doctor"),
    ("GET", "/api/sessions/{session_id}/contents"),
    ("DELETE", "/api/sessions/{session_id}/contents"),
    ("GET", "/api/sessions/{session_id}/contents/series"),
    ("GET", "/api/sessions/{session_id}/contents/camera"),
    ("GET", "/api/sessions/{session_id}/contents/frames"),
    ("GET", "/api/sessions/{session_id}/contents/frame_age"),
    ("GET", "/api/sessions/{session_id}/contents/message"),
    ("GET", "/api/sessions/{session_id}/contents/lines"),
    ("GET", "/api/sessions/{session_id}/contents/fields"),
    ("GET", "/api/sessions/{session_id}/contents/field"),
    ("GET", "/api/sessions/{session_id}/contents/picture"),
    ("GET", "/api/sessions/{session_id}/notes"),
    ("GET", "/api/sessions/{session_id}/notes.csv"),
    ("GET", "/api/sessions/{session_id}/notes.geojson"),
    ("GET", "/api/sessions/{session_id}/trajectory-errors"),
    ("GET", "/api/sessions/{session_id}/scan-series"),
    ("GET", "/api/sessions/{session_id}/compare"),
    ("PUT", "/api/sessions/{session_id}/compare"),
    ("GET", "/api/sessions/{session_id}/costmap/footprint"),
    ("PUT", "/api/sessions/{session_id}/costmap/footprint"),
    ("DELETE", "/api/sessions/{session_id}/compare"),
    ("GET", "/api/sessions/{session_id}/compare.png"),
    ("GET", "/api/sessions/{session_id}/graph"),
    ("POST", "/api/sessions/{session_id}/graph"),
    ("GET", "/api/sessions/{session_id}/graph/edges/{edge}"),
    ("GET", "/api/sessions/{session_id}/graph/edges/{edge}/landscape"),
    ("GET", "/api/sessions/{session_id}/graph/scans/{scan}"),
    ("GET", "/api/sessions/{session_id}/graph/candidates"),
    ("GET", "/api/sessions/{session_id}/graph/candidates/{candidate}"),
    ("GET", "/api/sessions/{session_id}/localization/course"),
    ("GET", "/api/sessions/{session_id}/costmap/{name}"),
    ("GET", "/api/sessions/{session_id}/puzzle"),
    ("POST", "/api/sessions/{session_id}/puzzle/answer"),
    ("POST", "/api/sessions/{session_id}/puzzle/hint"),
    ("POST", "/api/sessions/{session_id}/puzzle/solution"),
    ("POST", "/api/sessions/{session_id}/puzzle/check"),
    ("GET", "/api/sessions/{session_id}/map.pgm"),
    ("GET", "/api/sessions/{session_id}/map.yaml"),
    ("GET", "/api/sessions/{session_id}/map.png"),
    ("GET", "/api/sessions/{session_id}/volume.{kind}"),
    ("GET", "/api/sessions/{session_id}/surface.{kind}"),
    ("GET", "/api/sessions/{session_id}/selection.ply"),
    ("GET", "/api/sessions/{session_id}/depth.png"),
    ("GET", "/api/sessions/{session_id}/above.{kind}"),
    ("GET", "/scenes/{session_id}/plain/"),
    ("HEAD", "/scenes/{session_id}/plain/"),
    ("GET", "/scenes/{session_id}/plain/{_page}/"),
    ("HEAD", "/scenes/{session_id}/plain/{_page}/"),
    ("GET", "/scenes/{session_id}/settings"),
    ("POST", "/scenes/{session_id}/settings"),
    ("SOCKET", "/scenes/{session_id}/plain/{page}"),
    ("SOCKET", "/scenes/{session_id}/plain/{page}/"),
}
NEVER = {
    ("GET", "/"),
    ("HEAD", "/"),
    ("GET", "/{name}"),
    ("HEAD", "/{name}"),
    ("GET", "/sign-out"),
    ("POST", "/sign-out"),
    ("GET", "/metrics"),
    ("GET", "/api/docs"),
    ("GET", "/api/openapi.json"),
    ("HEAD", "/api/openapi.json"),
    ("GET", "/api/worlds"),
    ("GET", "/api/parameters"),
    ("GET", "/api/slam/parameters"),
    ("GET", "/api/localization/parameters"),
    ("PUT", "/api/localization/parameters"),
    ("POST", "/api/localization/amcl.yaml"),
    ("GET", "/api/sessions/{session_id}/localization"),
    ("POST", "/api/sessions/{session_id}/localization"),
    ("DELETE", "/api/sessions/{session_id}/localization"),
    ("GET", "/api/sessions/{session_id}/localization/map"),
    ("PUT", "/api/sessions/{session_id}/localization/map"),
    ("PUT", "/api/sessions/{session_id}/localization/map-files"),
    ("PUT", "/api/sessions/{session_id}/costmap/terrain"),
    ("GET", "/api/sessions"),
    ("POST", "/api/sessions"),
    ("DELETE", "/api/sessions/{session_id}"),
    ("POST", "/api/sessions/{session_id}/notes"),
    ("PUT", "/api/sessions/{session_id}/notes/{note_id}"),
    ("DELETE", "/api/sessions/{session_id}/notes/{note_id}"),
    ("POST", "/api/sessions/{session_id}/kept-map"),
    ("POST", "/api/sessions/{session_id}/edited-map"),
    ("GET", "/api/sessions/{session_id}/edited-map/{name}"),
    ("GET", "/api/sessions/{session_id}/story"),
    ("GET", "/api/sessions/{session_id}/report"),
    ("GET", "/api/sessions/{session_id}/report.pdf"),
    ("GET", "/api/sessions/{session_id}/run.mcap"),
    ("GET", "/api/sessions/{session_id}/trajectory.tum"),
    ("GET", "/api/sessions/{session_id}/links"),
    ("POST", "/api/sessions/{session_id}/links"),
    ("POST", "/api/sessions/{session_id}/puzzles"),
    ("DELETE", "/api/sessions/{session_id}/links/{token}"),
    ("PUT", "/api/sessions/{session_id}/relations"),
    ("POST", "/api/sessions/{session_id}/merge"),
    ("GET", "/api/sessions/{session_id}/merge"),
    ("DELETE", "/api/sessions/{session_id}/merge"),
    ("PUT", "/api/sessions/{session_id}/sensor"),
    ("PUT", "/api/sessions/{session_id}/trajectories/{name}"),
    ("GET", "/api/sessions/{session_id}/trajectories/{name}"),
    ("DELETE", "/api/sessions/{session_id}/trajectories/{name}"),
    ("GET", "/api/classes"),
    ("POST", "/api/classes"),
    ("DELETE", "/api/classes/{code}"),
    ("GET", "/api/classes/{code}/results.csv"),
    ("GET", "/api/classes/{code}/qr.svg"),
    ("PUT", "/api/classes/{code}/puzzle"),
    ("DELETE", "/api/classes/{code}/puzzle"),
    ("GET", "/api/puzzles"),
    ("GET", "/api/puzzles/{puzzle}/map.png"),
    ("DELETE", "/api/puzzles/{token}"),
    ("POST", "/api/puzzles/{puzzle}/sessions"),
    ("GET", "/api/fleet"),
    ("POST", "/api/fleet"),
    ("DELETE", "/api/fleet"),
    ("GET", "/api/links"),
    ("DELETE", "/api/links/{token}"),
    ("GET", "/api/logs"),
    ("PUT", "/api/logs"),
    ("POST", "/api/logs/examples/{name}"),
    ("GET", "/api/logs/uploads/{key}"),
    ("DELETE", "/api/logs/uploads/{key}"),
    ("GET", "/api/logs/{log_id}"),
    ("DELETE", "/api/logs/{log_id}"),
    ("GET", "/api/logs/{log_id}/trajectories/{name}"),
    ("PUT", "/api/logs/{log_id}/trajectories/{name}"),
    ("DELETE", "/api/logs/{log_id}/trajectories/{name}"),
    ("GET", "/api/logs/{log_id}/map.png"),
    ("PUT", "/api/logs/{log_id}/tags"),
    ("POST", "/api/logs/{log_id}/cancel"),
    ("POST", "/api/logs/{log_id}/read"),
    ("GET", "/api/logs/{log_id}/slam"),
    ("POST", "/api/logs/{log_id}/slam"),
    ("DELETE", "/api/logs/{log_id}/slam"),
    ("GET", "/api/sessions/{session_id}/heal"),
    ("POST", "/api/sessions/{session_id}/heal"),
    ("DELETE", "/api/sessions/{session_id}/heal"),
    ("POST", "/api/sessions/{session_id}/graph/keep"),
    ("GET", "/scenes/{session_id}"),
    ("GET", "/scenes/{session_id}/"),
    ("HEAD", "/scenes/{session_id}/"),
    ("SOCKET", "/scenes/{session_id}/plain"),
    ("SOCKET", "/scenes/{session_id}/plain/"),
    ("SOCKET", "/scenes/{session_id}"),
    ("SOCKET", "/scenes/{session_id}/"),
}


def rights() -> Iterator[tuple[tuple[str, str], GuestRight]]:
    """Yield (method, path) and the right of every route of the application."""
    for route in iter_route_contexts(create_app(Settings()).routes):
        assert route.endpoint is not None
        assert route.path is not None
        for method in route.methods or ("SOCKET",):
            yield (method, route.path), guest_right(route.endpoint)


def test_guests_have_the_rights_of_the_table_on_every_route() -> None:
    expected = (
        dict.fromkeys(ALWAYS, GuestRight.ALWAYS)
        | dict.fromkeys(LINKED_SESSION, GuestRight.LINKED_SESSION)
        | dict.fromkeys(NEVER, GuestRight.NEVER)
    )
    assert dict(rights()) == expected


def scope(method: str, path: str) -> Scope:
    if method == "SOCKET":
        return {"type": "websocket", "path": path, "headers": []}
    return {"type": "http", "method": method, "path": path, "headers": []}


@pytest.fixture
def router() -> APIRouter:
    made = APIRouter(prefix="/api")

    @made.get("/open/{session_id}")
    @guests_may(GuestRight.LINKED_SESSION)
    async def marked(session_id: str) -> str:
        return session_id

    @made.delete("/open/{session_id}")
    async def unmarked(session_id: str) -> str:
        return session_id

    @made.websocket("/open/{session_id}")
    async def unmarked_socket(session_id: str) -> None: ...

    return made


@pytest.mark.parametrize(
    ("method", "path", "right"),
    [
        ("GET", "/api/open/7", GuestRight.LINKED_SESSION),
        ("DELETE", "/api/open/7", GuestRight.NEVER),
        ("PUT", "/api/open/7", GuestRight.NEVER),
        ("SOCKET", "/api/open/7", GuestRight.NEVER),
        ("GET", "/api/open/7/8", GuestRight.NEVER),
        ("GET", "/api/nowhere", GuestRight.NEVER),
    ],
)
def test_a_route_without_a_mark_is_refused(router: APIRouter, method: str, path: str, right: GuestRight) -> None:
    found, parameters = right_of_request(router.routes, scope(method, path))
    assert found is right
    if right is not GuestRight.NEVER:
        assert parameters == {"session_id": "7"}
