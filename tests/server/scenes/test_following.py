"""Cameras that move with the robot: from behind and above, and from its own eye."""

from __future__ import annotations

import json
import math

import httpx
import numpy as np
import pytest
from numpy.typing import NDArray

from mapper.simulation import WORLDS
from mapper.volume.scans.scan_sequence import ScanSequence
from server.parts.volume.sight import sensor_sight
from server.parts.wire import command_of
from server.scenes.cameras import CAMERAS
from server.scenes.following import Following
from server.sessions.scene_controls import Sight
from tests.server.begin import new_simulation
from tests.server.scenes.conftest import Service
from tests.server.scenes.viser_client import CAMERA, Client, viser_client
from tests.server.view import view_of

NORTH = Sight((2.0, 3.0, 0.5), (0.0, 1.0, 0.0))
WEST = Sight((7.0, 1.0, 0.5), (-1.0, 0.0, 0.0))


def camera_of(following: Following, sight: Sight) -> NDArray[np.float64]:
    """Where the camera is told to be and what it is to look at (2, 3)."""
    return np.array(following.follow(sight))


def test_a_camera_stays_behind_and_above_the_robot_and_looks_where_it_goes() -> None:
    following = Following("follow")
    np.testing.assert_allclose(camera_of(following, NORTH), [(2.0, -1.0, 3.0), (2.0, 4.0, 0.5)])
    assert following.follow(NORTH) is None
    np.testing.assert_allclose(camera_of(following, WEST), [(11.0, 1.0, 3.0), (6.0, 1.0, 0.5)])


def test_the_camera_of_the_robot_looks_down_with_it() -> None:
    down = Sight((2.0, 3.0, 0.5), (0.0, math.sqrt(0.5), -math.sqrt(0.5)))
    place, look_at = camera_of(Following("first person"), down)
    np.testing.assert_allclose(place, down.place)
    ahead = np.subtract(look_at, place)
    np.testing.assert_allclose(ahead / np.linalg.norm(ahead), down.ahead)


def test_a_camera_that_was_moved_keeps_its_place_relative_to_the_robot() -> None:
    following = Following("follow")
    # Reports of places that it was told, also old ones, are no moves.
    for place, look_at in [camera_of(following, sight) for sight in (NORTH, WEST)]:
        following.reported(place, look_at)
    following.follow(NORTH)
    # The browser shows what it was told before: one metre to the right of the robot, which goes west, is north of it.
    following.reported((7.0, 2.0, 0.5), (7.0, 1.0, 0.5))
    east = Sight((0.0, 0.0, 0.5), (1.0, 0.0, 0.0))
    np.testing.assert_allclose(camera_of(following, east), [(0.0, -1.0, 0.5), (0.0, 0.0, 0.5)], atol=1e-9)


def cloud(origins: list[tuple[float, float, float]]) -> ScanSequence:
    n = len(origins)
    points, stamps = np.zeros((n, 3), np.float32), np.zeros(n, np.int64)
    return ScanSequence("pcd", points, np.arange(n + 1), np.array(origins), stamps, np.zeros(3))


def test_a_sensor_looks_where_it_goes() -> None:
    scans = cloud([(0.0, 0.0, 1.0), (0.0, 3.0, 1.0), (0.0, 3.01, 1.0), (4.0, 3.01, 1.0)])
    assert sensor_sight(scans, 0) is None
    ways = [sensor_sight(scans, index) for index in range(1, 5)]
    assert all(sight is not None for sight in ways)
    assert [sight.place for sight in ways if sight] == [tuple(place) for place in scans.origins.tolist()]
    wanted = [(0.0, 1.0, 0.0), (0.0, 1.0, 0.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)]
    np.testing.assert_allclose([sight.ahead for sight in ways if sight], wanted, atol=1e-3)


def test_a_cloud_without_a_place_or_a_way_is_not_looked_at_from_its_sensor() -> None:
    unknown = (math.nan, math.nan, math.nan)
    assert sensor_sight(cloud([unknown, unknown]), 1) is None
    assert sensor_sight(cloud([(0.0, 0.0, 1.0)]), 1) is None
    assert sensor_sight(cloud([unknown, (0.0, 0.0, 1.0)]), 1) is None


async def told(client: Client) -> tuple[list[float], list[float]]:
    """Where the camera is told to be, and what it is to look at."""
    place = await client.until(lambda m: m["type"] == "SetCameraPositionMessage" and not m["initial"])
    await client.aimed()
    looks = [message["look_at"] for message in client.of_type("SetCameraLookAtMessage") if not message["initial"]]
    return place["position"], looks[-1]


async def test_a_view_follows_the_robot_until_another_camera_is_chosen(service: Service) -> None:
    session = await new_simulation(service.sessions, "ann", "room", seed=1)
    session.model.playback.playing = False
    free = [tuple(WORLDS["room"].nearest_free(near, 0.5).tolist()) for near in ((8.0, 2.0), (2.0, 6.0))]
    address = f"http://127.0.0.1:{service.port}/scenes/{session.id}/settings"
    async with (
        httpx.AsyncClient(cookies={"visitor": "ann"}) as ann,
        viser_client(service.port, session.id, "visitor=ann") as client,
    ):
        await client.aimed()
        client.forget()
        cameras = (await ann.get(address)).json()["cameras"]
        assert cameras == [*CAMERAS, "follow", "first person"]
        assert json.loads(session.hub.slots["scene"])["cameras"] == cameras
        assert (await ann.post(address, json={"camera": "first person"})).status_code == 200
        for x, y in ((None, None), *free):
            if x is not None:
                client.forget()
                session.post(command_of({"type": "teleport", "x": x, "y": y}))
            place, look_at = await told(client)
            robot_x, robot_y, yaw = view_of(session).pose
            if x is not None:
                assert (robot_x, robot_y) == pytest.approx((x, y), abs=1e-3)
            assert place[:2] == pytest.approx((robot_x, robot_y), abs=1e-6)
            assert 0.2 < place[2] < 0.6
            assert math.atan2(look_at[1] - place[1], look_at[0] - place[0]) == pytest.approx(yaw)
            assert look_at[2] == pytest.approx(place[2])
            await client.send(**CAMERA | {"position": place, "look_at": look_at})
        client.forget()
        assert (await ann.post(address, json={"camera": "above"})).status_code == 200
        await told(client)
        client.forget()
        session.post(command_of({"type": "teleport", "x": free[0][0], "y": free[0][1]}))
        await client.until(lambda m: m["type"] == "SetPositionMessage" and m["name"] == "/robot")
        assert client.of_type("SetCameraPositionMessage") == []
