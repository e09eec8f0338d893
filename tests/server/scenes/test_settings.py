"""The page's own controls of a 3D view: cameras, the height of the columns, layers; the view without viser's panel."""

from __future__ import annotations

import itertools
import json
from typing import Any

import httpx
import numpy as np
import pytest

from server.scenes.cameras import CAMERAS, FOV, ROBOT_CAMERAS, camera_at
from server.sessions import SessionHost
from server.sessions.drawings import COLUMN_M
from server.sources.simulation import SimulationModel
from server.stream.commands import WorldCommand
from server.stream.message_parts import CameraName
from tests.server.begin import new_simulation
from tests.server.scenes.conftest import Service
from tests.server.scenes.viser_client import CAMERA, Client, viser_client
from tests.server.service import eventually

VISERS_FIRST = (3.0, 3.0, 3.0)  #: where a browser's camera is until it has read the first one of the scene, metres


def place_of(name: CameraName, session: SessionHost, aspect: float) -> tuple[float, float, float]:
    """Where a camera is to be that shows all of the session's world."""
    assert isinstance(session.model, SimulationModel)
    return camera_at(name, session.model.world.bounds, aspect, (0.0, COLUMN_M))[0]


def cameras_set(client: Client) -> list[Any]:
    """Places where the camera was moved; the scene's initial camera, which may come after the map, moves nobody."""
    messages = client.of_type("SetCameraPositionMessage")
    return [message["position"] for message in messages if not message["initial"]]


async def test_cameras_height_and_layers_are_set(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    base, address = f"http://127.0.0.1:{service.port}", f"/scenes/{session.id}/settings"
    async with httpx.AsyncClient(base_url=base, cookies={"visitor": "ann"}) as ann:
        found = (await ann.get(address)).json()
        assert (found["cameras"], found["camera"]) == ([*CAMERAS, *ROBOT_CAMERAS], None)
        async with (
            viser_client(service.port, session.id, "visitor=ann") as of_ann,
            viser_client(service.port, session.id, "visitor=bob") as of_bob,
        ):
            column = await of_ann.until(lambda m: m["type"] == "MeshMessage" and m["name"].startswith("/map/"))
            await of_bob.until(lambda m: m["type"] == "MeshMessage" and m["name"].startswith("/map/"))
            assert column["props"]["scale"] in (1.0, [1.0, 1.0, 1.0])

            # Only the cameras of the visitor who asked go there.
            of_bob.forget()
            wanted = place_of("above", session, 800 / 600)
            assert (await ann.post(address, json={"camera": "above"})).status_code == 200
            await of_ann.until(
                lambda m: m["type"] == "SetCameraPositionMessage" and m["position"] == pytest.approx(wanted)
            )
            settings = (await ann.post(address, json={"height": 2.5})).json()
            assert (settings["height"], settings.pop("camera")) == (2.5, "above")
            assert json.loads(session.hub.slots["scene"]) == {"type": "scene", **settings}
            async with httpx.AsyncClient(base_url=base, cookies={"visitor": "bob"}) as bob:
                assert (await bob.get(address)).json()["camera"] is None
            await of_bob.until(
                lambda m: m["type"] == "SceneNodeUpdateMessage" and m["updates"].get("scale") == [1.0, 1.0, 2.5]
            )
            overview = pytest.approx(place_of("overview", session, 800 / 600))
            assert all(place == overview for place in cameras_set(of_bob))
            # A page that is loaded again has the camera that its visitor has chosen.
            async with viser_client(service.port, session.id, "visitor=ann") as again:
                await again.until(
                    lambda m: m["type"] == "SetCameraPositionMessage" and m["position"] == pytest.approx(wanted)
                )

            assert settings["layers"]["Beams"] is True
            settings = (await ann.post(address, json={"layers": {"Beams": False, "no such": False}})).json()
            assert (settings["layers"]["Beams"], "no such" in settings["layers"]) == (False, False)
            del settings["camera"]
            assert json.loads(session.hub.slots["scene"]) == {"type": "scene", **settings}
            # What is switched in the view itself is told as well.
            beams = await of_ann.until(lambda m: m["type"] == "GuiCheckboxMessage" and m["props"]["label"] == "Beams")
            await of_bob.send(type="GuiUpdateMessage", uuid=beams["uuid"], updates={"value": True})
            await eventually(lambda: json.loads(session.hub.slots["scene"])["layers"]["Beams"])
            await ann.post(address, json={"layers": {"Beams": False}})
            await of_bob.until(
                lambda m: (
                    m["type"] == "SetSceneNodeVisibilityMessage" and m["name"] == "/robot/beams" and not m["visible"]
                )
            )

        assert (await ann.post(address, json={"camera": "below"})).status_code == 422
        assert (await ann.post(address, json={"height": 99})).status_code == 422


@pytest.mark.parametrize("width", [300, 800])
async def test_a_view_that_connects_again_has_the_camera_that_it_had(service: Service, width: int) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    moved, aim, height = (1.0, -2.0, 3.0), (1.0, 1.0, 0.5), CAMERA["image_height"]
    assert isinstance(height, int)

    async def told(page: str, then: Any = None, *, begins: Any = VISERS_FIRST, is_moved: bool = False) -> list[Any]:
        """Where a view is told to look from and to: its camera is at ``begins``, and at ``then`` before it leaves."""
        async with viser_client(
            service.port, session.id, "visitor=ann", page * 32, is_moved, position=begins, image_width=width
        ) as client:
            if not is_moved:
                await client.aimed()
            if then is not None:
                await client.send(type="CameraMovedMessage")
                await client.send(**CAMERA | {"position": then, "look_at": aim, "image_width": width})
            # What is switched behind the camera is carried out behind it.
            beams = await client.until(lambda m: m["type"] == "GuiCheckboxMessage" and m["props"]["label"] == "Beams")
            is_on = not beams["value"]
            await client.send(type="GuiUpdateMessage", uuid=beams["uuid"], updates={"value": is_on})
            await client.until(
                lambda m: (
                    m["type"] == "SetSceneNodeVisibilityMessage"
                    and m["name"] == "/robot/beams"
                    and m["visible"] == is_on
                )
            )
            aims = [one["look_at"] for one in client.of_type("SetCameraLookAtMessage") if not one["initial"]]
            return [*cameras_set(client), *aims[-1:]] if aims[-1:] == [pytest.approx(aim)] else cameras_set(client)

    overview = [pytest.approx(place_of("overview", session, width / height))]
    assert await told("a", then=moved) == overview
    assert await told("a") == [pytest.approx(moved), pytest.approx(aim)]
    assert await told("b") == overview  # another page
    assert await told("c", begins=moved, is_moved=True) == []  # a tab that has kept its camera, or a link has it


async def test_the_plain_view_has_no_panel(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    async with httpx.AsyncClient(base_url=f"http://127.0.0.1:{service.port}") as http:
        page, plain = [await http.get(f"/scenes/{session.id}/{part}") for part in ("", "plain/")]
    assert "body *:not(canvas):not(:has(canvas)) { visibility: hidden !important" in plain.text
    assert "body *:not(canvas)" not in page.text
    assert plain.headers["content-security-policy"] == page.headers["content-security-policy"]


async def test_a_camera_is_aimed_for_each_shape_of_its_picture_until_a_person_moves_it(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    address = f"http://127.0.0.1:{service.port}/scenes/{session.id}/settings"
    async with (
        httpx.AsyncClient(cookies={"visitor": "ann"}) as ann,
        viser_client(service.port, session.id, "visitor=ann") as client,
    ):

        async def is_aimed(aspect: float) -> tuple[float, float, float]:
            wanted = place_of("above", session, aspect)
            await client.until(
                lambda m: m["type"] == "SetCameraPositionMessage" and m["position"] == pytest.approx(wanted)
            )
            return wanted

        # The pane of the panel comes when the client has connected, so that its camera is known.
        beams = await client.until(lambda m: m["type"] == "GuiCheckboxMessage" and m["props"]["label"] == "Beams")
        assert (await ann.post(address, json={"camera": "above"})).status_code == 200
        there = await is_aimed(800 / 600)
        await client.send(**CAMERA | {"position": there, "image_width": 300})
        there = await is_aimed(0.5)
        # viser's client goes to a place that it had before, or that nobody has chosen.
        for late in (VISERS_FIRST, place_of("overview", session, 1.3)):
            client.forget()
            await client.send(**CAMERA | {"position": late, "image_width": 300})
            await is_aimed(0.5)
        # Moved a little, it stays where it is: what is switched behind it is carried out behind it.
        x, y, z = there
        client.forget()
        await client.send(type="CameraMovedMessage")
        await client.send(**CAMERA | {"position": (x, y, z - 0.1), "image_width": 200})
        await client.send(type="GuiUpdateMessage", uuid=beams["uuid"], updates={"value": False})
        await client.until(lambda m: m["type"] == "SetSceneNodeVisibilityMessage" and not m["visible"])
        assert cameras_set(client) == []


async def test_a_camera_is_aimed_at_another_world_unless_it_was_moved_or_follows_the_robot(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    address = f"http://127.0.0.1:{service.port}/scenes/{session.id}/settings"
    async with (
        httpx.AsyncClient(cookies={"visitor": "carol"}) as carol,
        viser_client(service.port, session.id, "visitor=ann") as client,
        viser_client(service.port, session.id, "visitor=bob", is_moved=True) as moved,
        viser_client(service.port, session.id, "visitor=carol") as following,
    ):
        first = place_of("overview", session, 800 / 600)
        await following.aimed()
        assert (await carol.post(address, json={"camera": "follow"})).status_code == 200
        await client.until(lambda m: m["type"] == "SetCameraPositionMessage" and m["position"] == pytest.approx(first))
        session.post(WorldCommand("office"))
        await eventually(lambda: place_of("overview", session, 800 / 600) != first)
        wanted = place_of("overview", session, 800 / 600)
        await client.until(
            lambda m: (
                m["type"] == "SetCameraPositionMessage" and not m["initial"] and m["position"] == pytest.approx(wanted)
            )
        )
        # What is switched after that is carried out after it.
        beams = await moved.control("Beams")
        await moved.send(type="GuiUpdateMessage", uuid=beams["uuid"], updates={"value": False})
        for one in (moved, following):
            await one.until(lambda m: m["type"] == "SetSceneNodeVisibilityMessage" and not m["visible"])
        assert cameras_set(moved) == []
        assert cameras_set(following)[0] == pytest.approx(first)
        assert pytest.approx(wanted) not in cameras_set(following)


@pytest.mark.parametrize("name", CAMERAS)
@pytest.mark.parametrize("aspect", [0.46, 1.0, 1.3, 3.4])
@pytest.mark.parametrize("box", [(204.0, 264.0, 37.0), (2.0, 60.0, 1.0), (1.0, 1.0, 8.0), (3.0, 3.0, 0.5)])
def test_the_whole_box_is_in_the_picture_and_fills_it(
    name: CameraName, aspect: float, box: tuple[float, float, float]
) -> None:
    x, y, z = box
    place, look_at = camera_at(name, (-x / 2, -y / 2, x / 2, y / 2), aspect, (0.0, z))
    forward = np.subtract(look_at, place)
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    corners = np.array(list(itertools.product((-x / 2, x / 2), (-y / 2, y / 2), (0.0, z)))) - place
    half = (corners @ forward) * np.tan(FOV / 2)  # of the height that the picture shows at the depth of each corner
    assert (half > 0).all()
    # Where it is seen in the picture, whose edges are at -1 and 1.
    across, along = corners @ right / (aspect * half), corners @ up / half
    spans = [(one.min(), one.max()) for one in (across, along)]
    for low, high in spans:
        assert low > -1.0
        assert high < 1.0
    assert max(high - low for low, high in spans) > 1.9
    assert any(low == pytest.approx(-high, abs=1e-9) for low, high in spans)  # in the middle of it
