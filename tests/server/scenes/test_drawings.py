"""The general drawings, as viser's client receives them through the proxy."""

from __future__ import annotations

import io
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import PIL.Image
import pytest
from structlog.testing import capture_logs
from websockets.exceptions import ConnectionClosed

from mapper.grid import GridGeometry
from mapper.simulation import WORLDS
from server.scenes.drawer import Drawer
from server.scenes.drawers import DRAWERS
from server.sessions import SessionHost
from server.sessions.drawings import (
    MAX_DRAWING_BYTES,
    Drawing,
    Gizmo,
    GridColumns,
    Image,
    Mesh,
    Points,
    Segments,
)
from server.stream.commands import TeleportCommand
from tests.server.begin import new_simulation
from tests.server.scenes.conftest import Service
from tests.server.scenes.viser_client import Client, viser_client
from tests.server.service import eventually
from tests.server.view import view_of

HALF_TURN = (0.0, 0.0, 0.0, 1.0)


class Shown:
    """A paused session that shows ``drawings`` instead of its own."""

    def __init__(self, session: SessionHost, *drawings: Drawing) -> None:
        self.session = session
        self.drawings = [*drawings]
        self._markers = 0

    def show(self, *drawings: Drawing) -> None:
        self.drawings = [*drawings]
        for listener in self.session.listeners:
            listener()

    async def drawn(self, client: Client) -> list[dict[str, Any]]:
        """Wait until a further drawing, the last, has arrived; return what the client has seen except that."""
        self._markers += 1
        marker = f"marker_{self._markers}"
        drawings = self.drawings
        self.show(*drawings, Segments(name=marker, points=np.zeros((1, 2, 3), np.float32)))
        await client.until(named("LineSegmentsMessage", f"/{marker}/lines"))
        self.drawings = drawings
        return [message for message in client.seen if not message.get("name", "").startswith("/marker")]


@asynccontextmanager
async def showing(
    service: Service, patch: pytest.MonkeyPatch, *drawings: Drawing
) -> AsyncIterator[tuple[Shown, Client]]:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    session.model.playback.playing = False
    shown = Shown(session, *drawings)
    patch.setattr(session.model, "drawings", lambda: shown.drawings)
    async with viser_client(service.port, session.id) as client:
        await client.aimed()
        await shown.drawn(client)
        yield shown, client


def named(kind: str, name: str) -> Callable[[dict[str, Any]], bool]:
    return lambda message: message["type"] == kind and message["name"] == name


def triangle(name: str = "wedge", **fields: Any) -> Mesh:
    vertices = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0.5)], np.float32)
    return Mesh(name=name, vertices=vertices, faces=np.array([(0, 1, 2)], np.uint32), **fields)


async def test_a_mesh_arrives_and_only_its_changes_follow(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = triangle(color=(1, 2, 3), opacity=0.5, position=(4.0, 5.0, 6.0), wxyz=HALF_TURN)
    async with showing(service, monkeypatch, mesh) as (shown, client):
        made = await client.until(named("MeshMessage", "/wedge/mesh"))
        np.testing.assert_array_equal(made["props"]["vertices"], mesh.vertices.ravel())
        np.testing.assert_array_equal(made["props"]["faces"], mesh.faces.ravel())
        assert (made["props"]["color"], made["props"]["opacity"]) == ([1, 2, 3], 0.5)
        assert (await client.until(named("SetPositionMessage", "/wedge")))["position"] == [4.0, 5.0, 6.0]
        assert (await client.until(named("SetOrientationMessage", "/wedge")))["wxyz"] == [0.0, 0.0, 0.0, 1.0]

        client.forget()
        shown.show(replace(mesh, vertices=mesh.vertices.copy(), faces=mesh.faces.copy()))  # equal, in other arrays
        assert await shown.drawn(client) == []

        shown.show(replace(mesh, position=(4.0, 5.0, 7.0)))
        await client.until(named("SetPositionMessage", "/wedge"))
        assert [message["type"] for message in await shown.drawn(client)] == ["SetPositionMessage"]

        client.forget()
        shown.show(replace(mesh, vertices=mesh.vertices + np.float32(1.0)))
        made = await client.until(named("MeshMessage", "/wedge/mesh"))
        np.testing.assert_array_equal(made["props"]["vertices"], mesh.vertices.ravel() + 1.0)

        shown.show(replace(mesh, faces=mesh.faces[:0]))
        await client.until(named("RemoveSceneNodeMessage", "/wedge/mesh"))
        shown.show()
        await client.until(named("RemoveSceneNodeMessage", "/wedge"))
        shown.show(mesh)
        await client.until(lambda m: client.seen.count(m) and named("MeshMessage", "/wedge/mesh")(m))


async def test_one_of_many_chunks_changes(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    chunks = [triangle(f"chunk_{i}", label="Volume") for i in range(300)]
    async with showing(service, monkeypatch, *chunks) as (shown, client):
        assert len(client.of_type("MeshMessage")) == 300
        client.forget()
        chunks[7] = replace(chunks[7], vertices=chunks[7].vertices * np.float32(2.0))
        shown.show(*chunks)
        await client.until(named("MeshMessage", "/chunk_7/mesh"))
        await shown.drawn(client)
        assert [message["name"] for message in client.of_type("MeshMessage")] == ["/chunk_7/mesh"]
        assert client.received < 4000


async def test_another_clip_box_is_sent_without_the_points(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    points = np.random.default_rng(0).normal(size=(50_000, 3)).astype(np.float32)
    cloud = Points(name="cloud", points=points, clip=((-9.0, -9.0, -9.0), (9.0, 9.0, 9.0)))
    async with showing(service, monkeypatch, cloud) as (shown, client):
        made = await client.until(named("PointCloudMessage", "/cloud/points"))
        np.testing.assert_array_equal(made["props"]["points"], points.ravel())
        assert (await client.until(named("SetPositionMessage", "/cloud/clip_high")))["position"] == [9.0, 9.0, 9.0]
        client.forget()
        shown.show(replace(cloud, clip=((-9.0, -9.0, -9.0), (9.0, 9.0, 1.5))))
        moved = await client.until(named("SetPositionMessage", "/cloud/clip_high"))
        assert moved["position"] == [9.0, 9.0, 1.5]
        assert [message["type"] for message in await shown.drawn(client)] == ["SetPositionMessage"]
        assert client.received < 1000


async def test_points_arrive_exactly(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(5)
    points = rng.uniform(-300, 300, (1000, 3)).astype(np.float32)
    colors = rng.integers(0, 256, (1000, 3)).astype(np.uint8)
    cloud = Points(name="scan", points=points, colors=colors, size=0.02)
    async with showing(service, monkeypatch, cloud) as (shown, client):
        props = (await client.until(named("PointCloudMessage", "/scan/points")))["props"]
        assert props["points"].dtype == np.float32
        np.testing.assert_array_equal(props["points"], points.ravel())
        np.testing.assert_array_equal(props["colors"], colors.ravel())
        assert props["point_size"] == 0.02
        client.forget()
        shown.show(replace(cloud, points=points[:10], colors=(9, 8, 7), wxyz=HALF_TURN))
        props = (await client.until(named("PointCloudMessage", "/scan/points")))["props"]
        np.testing.assert_array_equal(props["points"], points[:10].ravel())
        np.testing.assert_array_equal(props["colors"], (9, 8, 7))


async def test_segments_arrive(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    lines = Segments(name="graph", points=np.arange(12, dtype=np.float32).reshape(2, 2, 3), width=0.1, unit="world")
    async with showing(service, monkeypatch, lines) as (shown, client):
        props = (await client.until(named("LineSegmentsMessage", "/graph/lines")))["props"]
        np.testing.assert_array_equal(props["points"], np.arange(12))
        assert (props["thickness"], props["thickness_units"]) == (0.1, "world")
        client.forget()
        shown.show(replace(lines, points=lines.points[:1], colors=np.full((1, 2, 3), 200, np.uint8)))
        props = (await client.until(named("LineSegmentsMessage", "/graph/lines")))["props"]
        np.testing.assert_array_equal(props["colors"], 6 * [200])


async def test_an_image_arrives_and_its_pixels_change(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    pixels = np.random.default_rng(1).integers(0, 256, (20, 30, 3)).astype(np.uint8)
    image = Image(name="camera", pixels=pixels, width=3.0, height=2.0)
    async with showing(service, monkeypatch, image) as (shown, client):
        props = (await client.until(named("ImageMessage", "/camera/image")))["props"]
        np.testing.assert_array_equal(PIL.Image.open(io.BytesIO(props["_data"])), pixels)
        assert (props["render_width"], props["render_height"]) == (3.0, 2.0)
        client.forget()
        shown.show(replace(image, pixels=255 - pixels))
        update = await client.until(lambda m: m["type"] == "SceneNodeUpdateMessage" and "_data" in m["updates"])
        np.testing.assert_array_equal(PIL.Image.open(io.BytesIO(update["updates"]["_data"])), 255 - pixels)


async def test_a_switch_hides_all_of_its_label(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    drawings = [triangle("a", label="Volume"), triangle("b", label="Volume"), triangle("c", label="Rest")]
    async with showing(service, monkeypatch, *drawings) as (shown, client):
        switch = await client.control("Volume")
        client.forget()
        await client.send(type="GuiUpdateMessage", uuid=switch["uuid"], updates={"value": False})
        shown.show(*drawings, triangle("d", label="Volume"))
        hidden = {"/a", "/b", "/d"}
        for name in hidden:
            await client.until(
                lambda m, name=name: named("SetSceneNodeVisibilityMessage", name)(m) and not m["visible"]
            )
        await shown.drawn(client)
        off = {m["name"] for m in client.of_type("SetSceneNodeVisibilityMessage") if not m["visible"]}
        assert off == hidden
        shown.show(drawings[2])
        await client.until(lambda m: m["type"] == "GuiRemoveMessage" and m["uuid"] == switch["uuid"])


class Ball(Drawing):
    """A type of drawing that only this test knows."""


class BallDrawer(Drawer[Ball, Ball]):
    def show(self, content: Ball) -> None:
        self.scene.add_icosphere(f"{self.path}/ball", radius=0.5)


async def test_a_new_type_of_drawing_needs_one_drawer(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(service.scenes, "_drawers", {**DRAWERS, Ball: BallDrawer})
    async with showing(service, monkeypatch, Ball(name="ball", label="Ball")) as (_, client):
        await client.until(named("IcosphereMessage", "/ball/ball"))
        await client.control("Ball")


async def test_a_small_change_of_a_map_sends_little(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    geometry = GridGeometry(0.05, 1000, 1000)
    log_odds = np.full(geometry.shape, -2.0, np.float32)
    log_odds[::20] = 3.0
    grid = GridColumns(
        name="map", label="Map", geometry=geometry, log_odds=log_odds, observed=np.ones(geometry.shape, np.bool_)
    )
    async with showing(service, monkeypatch, grid) as (shown, client):
        tiles, whole = len(client.of_type("MeshMessage")), client.received
        assert tiles == 16 * 16
        client.forget()
        log_odds[70, 130] = 3.0  # a session's own array, written between two ticks
        shown.show(grid)
        await client.until(named("MeshMessage", "/map/1_2"))
        await shown.drawn(client)
        assert len(client.of_type("MeshMessage")) == 1
        assert client.received < 0.05 * whole


# -- gizmos --------------------------------------------------------------------------------------------------------


async def move(client: Client, position: tuple[float, float, float], name: str = "/goal/handles") -> None:
    await client.send(
        type="TransformControlsUpdateMessage", name=name, wxyz=(1.0, 0.0, 0.0, 0.0), position=position, owner=""
    )


async def test_a_moved_gizmo_becomes_a_command(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    gizmo = Gizmo(name="goal", label="Goal", position=(1.0, 1.0, 0.0), axes=(True, True, False), turns=False)
    async with showing(service, monkeypatch, gizmo) as (shown, client):
        session = shown.session
        monkeypatch.setattr(
            session.model,
            "on_gizmo_moved",
            lambda name, position, wxyz: TeleportCommand(position[0], position[1]),
        )
        props = (await client.until(named("TransformControlsMessage", "/goal/handles")))["props"]
        assert (props["active_axes"], props["disable_rotations"], props["disable_axes"]) == (
            [True, True, False],
            True,
            False,
        )
        target = next((x, y) for x, y in ((5.0, 4.0), (2.0, 2.0), (8.0, 2.0)) if WORLDS["room"].is_free((x, y), 0.5))
        await client.send(type="TransformControlsDragStartMessage", name="/goal/handles", owner="")
        await move(client, (*target, 0.0))
        await client.send(type="TransformControlsDragEndMessage", name="/goal/handles", owner="")
        await eventually(lambda: view_of(session).pose[:2] == pytest.approx(target, abs=1e-3))
        # What the model confirms is not sent back.
        client.forget()
        shown.show(replace(gizmo, position=(*target, 0.0)))
        scene = await service.scenes.get(session)
        await eventually(lambda: not scene._contents.unsettled)
        assert await shown.drawn(client) == []


async def test_a_gizmo_may_have_a_constant_size_on_the_screen(
    service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with showing(service, monkeypatch, Gizmo(name="goal", scale=64.0, unit="screen")) as (shown, client):
        props = (await client.until(named("TransformControlsMessage", "/goal/handles")))["props"]
        assert (props["scale"], props["fixed"]) == (64.0, True)
        wide = props["line_width"]
        client.forget()
        shown.show(Gizmo(name="goal", scale=2.0))
        props = (await client.until(named("TransformControlsMessage", "/goal/handles")))["props"]
        assert (props["scale"], props["fixed"]) == (2.0, False)
        assert props["line_width"] < wide


async def test_a_gizmo_whose_move_is_refused_returns(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    gizmo = Gizmo(name="goal", position=(1.0, 1.0, 0.0))
    async with showing(service, monkeypatch, gizmo) as (_, client):
        client.forget()
        await move(client, (3.0, 1.0, 0.0))
        back = await client.until(named("SetPositionMessage", "/goal/handles"))
        assert back["position"] == [1.0, 1.0, 0.0]


async def test_of_many_moves_the_last_counts(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    async with showing(service, monkeypatch, Gizmo(name="goal")) as (shown, client):
        moves: list[float] = []
        monkeypatch.setattr(
            shown.session.model, "on_gizmo_moved", lambda name, position, wxyz: moves.append(position[0])
        )
        for i in range(400):
            await move(client, (float(i), 0.0, 0.0))
        await eventually(lambda: bool(moves) and moves[-1] == 399.0)
        assert len(moves) < 200
        assert moves == sorted(moves)


async def test_a_gizmo_that_is_not_there_moves_nothing(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    async with showing(service, monkeypatch, Gizmo(name="goal"), triangle("wedge")) as (shown, client):
        moves: list[str] = []
        monkeypatch.setattr(shown.session.model, "on_gizmo_moved", lambda name, position, wxyz: moves.append(name))
        for name in ("/goal", "/wedge", "/wedge/mesh", "/goal/handles/x", "/nothing"):
            await move(client, (1.0, 2.0, 3.0), name)
        await move(client, (float("nan"), 0.0, 0.0))
        await move(client, (1.0, 2.0, 3.0))
        await eventually(lambda: bool(moves))
        assert moves == ["goal"]


# -- large meshes --------------------------------------------------------------------------------------------------


def large(rows: int) -> Mesh:
    """A mesh of so many rows of 12 bytes, half of them vertices."""
    vertices = np.arange(3 * (rows // 2), dtype=np.float32).reshape(-1, 3)
    faces = np.arange(3 * (rows - rows // 2), dtype=np.uint32).reshape(-1, 3) % np.uint32(len(vertices))
    return Mesh(name="large", vertices=vertices, faces=faces)


async def test_a_mesh_of_64_mib_passes_and_a_larger_one_is_left_out(
    service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = (64 << 20) // 12  # a row has 12 bytes: this is 4 bytes less than 64 MiB, and one more row is too much
    largest = large(rows)
    assert MAX_DRAWING_BYTES == 64 << 20
    assert largest.nbytes <= MAX_DRAWING_BYTES < largest.nbytes + 12
    async with showing(service, monkeypatch, triangle()) as (shown, client):
        shown.show(triangle(), largest)
        made = await client.until(named("MeshMessage", "/large/mesh"))
        np.testing.assert_array_equal(made["props"]["vertices"], largest.vertices.ravel())
        np.testing.assert_array_equal(made["props"]["faces"], largest.faces.ravel())
        client.forget()
        with capture_logs() as told:
            shown.show(large(rows + 1), triangle(position=(1.0, 0.0, 0.0)))
            await client.until(named("RemoveSceneNodeMessage", "/large"))
            await client.until(named("SetPositionMessage", "/wedge"))  # the rest of the scene is shown
            shown.show(large(rows + 1), triangle(position=(2.0, 0.0, 0.0)))
            await client.until(lambda m: named("SetPositionMessage", "/wedge")(m) and m["position"][0] == 2.0)
        assert client.of_type("MeshMessage") == []
        (line,) = (line for line in told if line["log_level"] == "warning")
        assert line["event"] == "drawing too large for the 3D view"
        assert (line["drawing"], line["bytes"], line["limit"]) == ("large", 12 * (rows + 1), 64 << 20)


async def test_two_large_meshes_are_sent_in_two_messages(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = (40 << 20) // 12
    meshes = [replace(large(rows), name=name) for name in ("one", "two")]
    async with showing(service, monkeypatch, *meshes) as (_, client):  # both wait for a client that connects
        assert {message["name"] for message in client.of_type("MeshMessage")} == {"/one/mesh", "/two/mesh"}


async def test_a_message_that_is_too_large_ends_its_scene_only(
    service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = await new_simulation(service.sessions, "ann", "room", seed=1)
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    async with viser_client(service.port, other.id) as unharmed:
        await unharmed.control("Hit increment")
        monkeypatch.setattr("server.scenes.proxy.MAX_FROM_SCENE", 1000)  # for views that open from now on
        with capture_logs() as told:
            async with viser_client(service.port, session.id) as client:
                with pytest.raises(ConnectionClosed) as caught:
                    await client.until(lambda _: False)
            assert caught.value.rcvd is not None
            assert caught.value.rcvd.code == 1009
        assert [line["limit"] for line in told if line["event"] == "message of a 3D view too large"] == [1000]
        unharmed.forget()
        await unharmed.until(lambda m: m["type"] == "SetPositionMessage")


# -- validation ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "make",
    [
        lambda: triangle("no spaces"),
        lambda: triangle(""),
        lambda: triangle("a/b"),
        lambda: Mesh(name="a", vertices=np.zeros((2, 2), np.float32), faces=np.zeros((0, 3), np.uint32)),
        lambda: Mesh(name="a", vertices=np.zeros((2, 3)), faces=np.zeros((0, 3), np.uint32)),  # type: ignore[arg-type]
        lambda: Points(name="a", points=np.zeros((4, 3), np.float32), colors=np.zeros((3, 3), np.uint8)),
        lambda: Points(name="a", points=np.zeros(3, np.float32)),
        lambda: Segments(name="a", points=np.zeros((4, 3), np.float32)),
        lambda: Image(name="a", pixels=np.zeros((4, 4, 2), np.uint8), width=1.0, height=1.0),
        lambda: Image(name="a", pixels=np.zeros((4, 4), np.uint8), width=1.0, height=1.0),
    ],
)
def test_drawings_that_cannot_be_drawn_are_refused(make: Callable[[], Drawing]) -> None:
    with pytest.raises(ValueError, match=r"must be|named|channels"):
        make()
