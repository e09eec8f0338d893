"""The page's own controls of a 3D view: cameras, the height of the columns, layers; the view without viser's panel."""

from __future__ import annotations

import itertools
import json
from typing import Any

import httpx
import numpy as np
import pytest

from server.scenes.cameras import ASPECT, CAMERAS, FOV, ROBOT_CAMERAS, camera_at
from server.scenes.scene import VISERS_FIRST
from server.stream.message_parts import CameraName
from tests.server.begin import new_simulation
from tests.server.scenes.conftest import Service
from tests.server.scenes.viser_client import CAMERA, Client, viser_client
from tests.server.service import eventually


def cameras_set(client: Client) -> list[Any]:
    """Places where the camera was moved; the scene's initial camera, which may come after the map, moves nobody."""
    messages = client.of_type("SetCameraPositionMessage")
    return [message["position"] for message in messages if not message["initial"]]


async def test_cameras_height_and_layers_are_set(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    base, address = f"http://127.0.0.1:{service.port}", f"/scenes/{session.id}/settings"
    async with httpx.AsyncClient(base_url=base, cookies={"visitor": "ann"}) as ann:
        assert (await ann.get(address)).json()["cameras"] == [*CAMERAS, *ROBOT_CAMERAS]
        async with (
            viser_client(service.port, session.id, "visitor=ann") as of_ann,
            viser_client(service.port, session.id, "visitor=bob") as of_bob,
        ):
            column = await of_ann.until(lambda m: m["type"] == "MeshMessage" and m["name"].startswith("/map/"))
            await of_bob.until(lambda m: m["type"] == "MeshMessage" and m["name"].startswith("/map/"))
            assert column["props"]["scale"] in (1.0, [1.0, 1.0, 1.0])

            # Only the cameras of the visitor who asked go there.
            of_bob.forget()
            wanted, _ = camera_at("above", session.model.controls().bounds or (0.0, 0.0, 1.0, 1.0), 800 / 600)
            assert (await ann.post(address, json={"camera": "above"})).status_code == 200
            await of_ann.until(
                lambda m: m["type"] == "SetCameraPositionMessage" and m["position"] == pytest.approx(wanted)
            )
            settings = (await ann.post(address, json={"height": 2.5})).json()
            assert settings["height"] == 2.5
            assert json.loads(session.hub.slots["scene"]) == {"type": "scene", **settings}
            await of_bob.until(
                lambda m: m["type"] == "SceneNodeUpdateMessage" and m["updates"].get("scale") == [1.0, 1.0, 2.5]
            )
            assert cameras_set(of_bob) == []

            assert settings["layers"]["Beams"] is True
            settings = (await ann.post(address, json={"layers": {"Beams": False, "no such": False}})).json()
            assert (settings["layers"]["Beams"], "no such" in settings["layers"]) == (False, False)
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
    bounds = session.model.controls().bounds
    assert bounds is not None
    initial, middle = camera_at("overview", bounds, ASPECT)
    moved, aim, height = (1.0, -2.0, 3.0), (1.0, 1.0, 0.5), CAMERA["image_height"]
    assert isinstance(height, int)

    async def told(page: str, then: Any = None, *, begins: Any = initial, is_told: bool = True) -> list[Any]:
        """Where a view is told to look from and to: its camera is at ``begins``, and at ``then`` before it leaves."""
        async with viser_client(
            service.port, session.id, "visitor=ann", page * 32, position=begins, look_at=middle, image_width=width
        ) as client:
            if is_told:
                await client.until(lambda m: m["type"] == "SetCameraLookAtMessage" and not m["initial"])
            if then is not None:
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
            return [*cameras_set(client), *aims[-1:]]

    is_narrow = width < height
    overview = [pytest.approx(place) for place in camera_at("overview", bounds, width / height)] if is_narrow else []
    assert await told("a", then=moved, is_told=is_narrow) == overview
    assert await told("a") == [pytest.approx(moved), pytest.approx(aim)]
    assert await told("b", is_told=is_narrow) == overview  # another page
    assert await told("c", begins=VISERS_FIRST, is_told=is_narrow) == overview  # which has not read the first camera
    assert await told("d", begins=moved, is_told=False) == []  # a tab that has kept its camera


async def test_the_plain_view_has_no_panel(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    async with httpx.AsyncClient(base_url=f"http://127.0.0.1:{service.port}") as http:
        page, plain = [await http.get(f"/scenes/{session.id}/{part}") for part in ("", "plain/")]
    assert "visibility: hidden !important" in plain.text
    assert "visibility: hidden !important" not in page.text
    assert plain.headers["content-security-policy"] == page.headers["content-security-policy"]


async def test_a_camera_goes_back_when_its_picture_becomes_narrow_until_somebody_moves_it(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    bounds = session.model.controls().bounds
    assert bounds is not None
    address = f"http://127.0.0.1:{service.port}/scenes/{session.id}/settings"
    async with (
        httpx.AsyncClient(cookies={"visitor": "ann"}) as ann,
        viser_client(service.port, session.id, "visitor=ann") as client,
    ):

        async def is_aimed(aspect: float) -> tuple[float, float, float]:
            wanted, _ = camera_at("above", bounds, aspect)
            await client.until(
                lambda m: m["type"] == "SetCameraPositionMessage" and m["position"] == pytest.approx(wanted)
            )
            return wanted

        # The pane of the panel comes when the client has connected, so that its camera is known.
        beams = await client.until(lambda m: m["type"] == "GuiCheckboxMessage" and m["props"]["label"] == "Beams")
        assert (await ann.post(address, json={"camera": "above"})).status_code == 200
        there = await is_aimed(800 / 600)
        await client.send(**CAMERA | {"position": there, "image_width": 300})
        x, y, z = await is_aimed(0.5)
        # Moved a little, it stays where it is: what is switched behind it is carried out behind it.
        await client.send(**CAMERA | {"position": (x, y, z - 0.1), "image_width": 200})
        await client.send(type="GuiUpdateMessage", uuid=beams["uuid"], updates={"value": False})
        await client.until(lambda m: m["type"] == "SetSceneNodeVisibilityMessage" and not m["visible"])
        assert cameras_set(client)[-1] == pytest.approx((x, y, z))


@pytest.mark.parametrize("is_late", [False, True])
async def test_the_first_camera_fits_a_picture_that_becomes_narrow_or_that_comes_to_it_late(
    service: Service, *, is_late: bool
) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    bounds = session.model.controls().bounds
    assert bounds is not None
    first, _ = camera_at("overview", bounds, ASPECT)
    wanted, _ = camera_at("overview", bounds, 0.5)

    def is_aimed(message: dict[str, Any]) -> bool:
        is_camera = message["type"] == "SetCameraPositionMessage"
        return bool(is_camera and message["position"] == pytest.approx(wanted))

    begins = {"position": VISERS_FIRST, "image_width": 300} if is_late else {"position": first}
    async with viser_client(service.port, session.id, "visitor=ann", **begins) as client:
        # The pane of the panel comes when the client has connected, so that its camera is known.
        await client.control("Beams")
        if is_late:
            await client.until(is_aimed)
        client.forget()
        await client.send(**CAMERA | {"position": first, "image_width": 300})
        await client.until(is_aimed)


async def test_a_view_of_another_shape_is_aimed_again_where_its_tab_has_kept_the_camera(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    bounds = session.model.controls().bounds
    assert bounds is not None
    kept, _ = camera_at("overview", bounds, 1.0)
    wanted, _ = camera_at("overview", bounds, 0.5)

    def is_aimed(message: dict[str, Any]) -> bool:
        return message["type"] == "SetCameraPositionMessage" and bool(message["position"] == pytest.approx(wanted))

    view = service.port, session.id, "visitor=ann", "a" * 32
    async with viser_client(*view, position=VISERS_FIRST, image_width=600) as client:
        await client.until(lambda m: m["type"] == "SetCameraPositionMessage" and m["position"] == pytest.approx(kept))
    async with viser_client(*view, position=VISERS_FIRST, image_width=300) as client:
        await client.until(is_aimed)
        client.forget()
        await client.send(**CAMERA | {"position": kept, "image_width": 300})  # once the page has read it
        await client.until(is_aimed)


@pytest.mark.parametrize("name", CAMERAS)
def test_cameras_look_at_the_middle_and_go_back_in_narrow_pictures(name: CameraName) -> None:
    bounds = (2.0, 1.0, 12.0, 7.0)
    (x, y, z), look_at = camera_at(name, bounds, 1.6)
    assert look_at == (7.0, 4.0, 0.0)
    (far_x, far_y, far_z), _ = camera_at(name, bounds, 0.65)
    near, far = (((x - 7) ** 2 + (y - 4) ** 2 + z**2) ** 0.5, ((far_x - 7) ** 2 + (far_y - 4) ** 2 + far_z**2) ** 0.5)
    assert far == pytest.approx(2.0 * near)
    assert z > 0


@pytest.mark.parametrize("name", CAMERAS)
@pytest.mark.parametrize("aspect", [0.6, 1.0, 1.3, 3.4])
@pytest.mark.parametrize("box", [(204.0, 264.0, 37.0), (2.0, 60.0, 1.0), (1.0, 1.0, 8.0)])
def test_the_whole_box_is_in_the_picture(name: CameraName, aspect: float, box: tuple[float, float, float]) -> None:
    x, y, z = box
    place, look_at = camera_at(name, (-x / 2, -y / 2, x / 2, y / 2), aspect, (0.0, z))
    forward = np.subtract(look_at, place)
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    for corner in itertools.product((-x / 2, x / 2), (-y / 2, y / 2), (0.0, z)):
        seen = np.subtract(corner, place)
        height = (seen @ forward) * np.tan(FOV / 2)  # half of what the picture shows at this depth
        assert height > 0
        assert abs(seen @ up) < height
        assert abs(seen @ right) < aspect * height
