"""Puzzles over HTTP: solved from start to end, made of a world and of a log, and by a class."""

from __future__ import annotations

import asyncio
import csv
import io
import json
from collections.abc import Iterator
from typing import Any

import httpx
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.puzzles import CAUSES, RECIPES
from mapper.replay.overview import FREE, OCCUPIED, UNOBSERVED
from server.library.packs.picture import DARK, LIGHT
from server.puzzles.pictures import FOLDER, codes_of, picture_codes
from tests.marks import also_long
from tests.server.service import PATIENCE_S, Service, Watcher, running, settings_for

TOKEN = "long enough"


def person(service: Service, *, knows_token: bool) -> httpx.Client:
    headers = {"Authorization": f"Bearer {TOKEN}"} if knows_token else {}
    return httpx.Client(base_url=service.http.base_url, timeout=PATIENCE_S, headers=headers)


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with running(settings_for(tmp_path_factory.mktemp("puzzles"), token=TOKEN)) as service:
        yield service


@pytest.fixture(scope="module")
def owner(service: Service) -> Iterator[httpx.Client]:
    with person(service, knows_token=True) as client:
        yield client


@pytest.fixture
def guest(service: Service) -> Iterator[httpx.Client]:
    with person(service, knows_token=False) as client:
        client.get("/join")  # the service gives a cookie
        yield client


def begun(client: httpx.Client, path: str) -> str:
    answer = client.post(path)
    assert answer.status_code == 201, answer.text
    return str(answer.json()["id"])


def state(client: httpx.Client, session: str, step: str = "", **body: Any) -> dict[str, Any]:
    path = f"/api/sessions/{session}/puzzle{step}"
    answer = client.post(path, json=body or None) if step else client.get(path)
    assert answer.status_code == 200, answer.text
    return dict(answer.json())


@pytest.fixture(scope="module")
def of_log(owner: httpx.Client) -> str:
    """The token of a puzzle of the sample, with beams at the max range taken as hits."""
    session = owner.post("/api/sessions", json={"kind": "log", "log": "sample-office", "playing": False}).json()["id"]
    made = owner.post(f"/api/sessions/{session}/puzzles", json={"fault": "beam_order", "title": "Sample"})
    owner.delete(f"/api/sessions/{session}")
    assert made.status_code == 201, made.text
    return str(made.json()["token"])


def test_a_guest_solves_a_puzzle_and_the_answer_comes_last(guest: httpx.Client, of_log: str) -> None:
    assert guest.get(f"/api/shared-puzzles/{of_log}").json() == {"title": "Sample"}
    session = begun(guest, f"/api/shared-puzzles/{of_log}/sessions")
    first = state(guest, session)
    assert first["answer"] is None
    assert first["points"] == 0
    better = {
        name
        for name, sign in (("agreement", 1), ("sharpness", 1), ("entropy", -1))
        if sign * (first["goal"][name] - first["first"][name]) > 0
    }
    assert set(first["measures"]) == better
    texts = [hint for cause in CAUSES.values() for hint in (*cause.hints, cause.explanation, cause.lesson)]
    assert not any(text in json.dumps(first, ensure_ascii=False) for text in texts)
    assert {one["name"] for one in first["causes"]} == set(CAUSES)

    wrong = state(guest, session, "/answer", cause="drift")
    assert wrong["wrong"] == ["drift"]
    lessons = {one["name"]: one["lesson"] for one in wrong["causes"] if one["lesson"] is not None}
    assert lessons == {"drift": CAUSES["drift"].lesson}
    assert state(guest, session, "/answer", cause="drift")["wrong"] == ["drift"]  # costs once
    assert state(guest, session, "/hint")["hints"] == [CAUSES["beam_order"].hints[0]]
    assert state(guest, session, "/check")["repair"] == 0.0  # the map as it was given
    named = state(guest, session, "/answer", cause="beam_order")
    assert named["is_named"]
    assert not named["is_solved"]
    assert named["points"] == 40 - 10 - 10
    assert named["answer"] is None


def test_a_repaired_map_solves_it(owner: httpx.Client, service: Service) -> None:
    session = begun(owner, "/api/puzzles/doorway/sessions")
    state(owner, session, "/answer", cause="resolution")
    assert state(owner, session, "/check")["best"] == 0.0

    async def repair() -> None:
        async with service.connect(session, additional_headers={"Authorization": f"Bearer {TOKEN}"}) as socket:
            watcher = Watcher(socket)
            await watcher.send("parameters", values={"resolution": 0.05})
            await watcher.until(lambda: watcher.geometry.get("resolution") == 0.05)

    asyncio.run(repair())
    found = state(owner, session, "/check")
    assert found["is_solved"]
    assert found["points"] == 100
    assert found["answer"]["section"] == "resolution"
    faulty = found["answer"]["faulty"]["resolution"]
    assert faulty >= CAUSES["resolution"].amount[0]
    first = {"values": {"resolution": faulty}, "trajectory": found["answer"]["faulty_trajectory"]}
    assert owner.put(f"/api/sessions/{session}/compare", json=first).status_code == 200
    refused = owner.post(f"/api/sessions/{session}/puzzle/hint")
    assert refused.status_code == 422
    assert refused.json()["code"] == "puzzle.over"
    gave_up = begun(owner, "/api/puzzles/doorway/sessions")
    assert state(owner, gave_up, "/solution")["points"] == 0


def test_a_world_with_a_fault_becomes_a_puzzle(owner: httpx.Client, guest: httpx.Client) -> None:
    story = {"steps": 1500, "journal": [], "parameters": {"mount_yaw": 0.15}}
    wanted = {"kind": "simulation", "world": "room", "seed": 2, "playing": False, "story": story}
    world = owner.post("/api/sessions", json=wanted).json()["id"]
    made = owner.post(f"/api/sessions/{world}/puzzles", json={}).json()
    assert made["fault"] == "mount_yaw"
    session = begun(guest, f"/api/shared-puzzles/{made['token']}/sessions")
    assert state(guest, session, "/answer", cause="mount_yaw")["is_named"]
    assert state(guest, session)["first"]["agreement"] < 0.8
    assert owner.get("/api/puzzles").json()["mine"][0]["token"] == made["token"]
    assert owner.delete(f"/api/puzzles/{made['token']}").status_code == 204
    assert guest.get(f"/api/shared-puzzles/{made['token']}").status_code == 404
    assert guest.get(f"/api/sessions/{session}").status_code in (401, 404)  # the attempts have ended


def test_a_world_without_a_fault_and_unknown_names_are_refused(owner: httpx.Client) -> None:
    world = owner.post("/api/sessions", json={"kind": "simulation", "playing": False}).json()["id"]
    for body, code in (
        ({}, "puzzle.nothing_wrong"),
        ({"fault": "sweep"}, "puzzle.cause"),
    ):
        assert owner.post(f"/api/sessions/{world}/puzzles", json=body).json()["code"] == code
    assert owner.post("/api/sessions/nobody/puzzles", json={}).json()["code"] == "session.unknown"
    assert owner.post("/api/puzzles/nothing/sessions").json()["code"] == "puzzle.unknown"
    assert owner.get(f"/api/sessions/{world}/puzzle").json()["code"] == "puzzle.no_game"
    owner.delete(f"/api/sessions/{world}")


def test_a_guest_without_a_link_gets_no_puzzle(guest: httpx.Client) -> None:
    assert guest.get("/api/puzzles").status_code == 401
    assert guest.post("/api/puzzles/doorway/sessions").status_code == 401
    assert guest.post("/api/shared-puzzles/nothing/sessions").status_code == 404


def test_a_class_solves_a_puzzle_and_its_results_have_no_names(
    owner: httpx.Client, guest: httpx.Client, of_log: str
) -> None:
    code = owner.post("/api/classes").json()["code"]
    path = f"/api/classes/{code}/puzzle"
    assert guest.post(f"{path}/sessions").json()["code"] == "class.no_puzzle"
    assert guest.put(path, json={"puzzle": of_log}).status_code == 401
    assert owner.put(path, json={"puzzle": of_log}).status_code == 204
    session = begun(guest, f"{path}/sessions")
    assert begun(guest, f"{path}/sessions") == session  # the attempt goes on
    state(guest, session, "/answer", cause="beam_order")
    rows = list(csv.DictReader(io.StringIO(owner.get(f"/api/classes/{code}/results.csv").text)))
    assert {row["option"]: row["answers"] for row in rows if row["option"]} == {
        "begun": "1", "cause named": "1", "solved": "0"
    }  # fmt: skip
    assert [int(row["answers"]) for row in rows if row["unit"] == "points"] == [0, 0, 0, 0, 1, 0, 0, 0, 0, 0]
    assert owner.delete(path).status_code == 204
    assert owner.delete(f"/api/classes/{code}").status_code == 204
    assert guest.get(f"/api/sessions/{session}").status_code in (401, 404)


def test_what_a_follower_gave_up_stays_given_up_in_another_attempt(
    service: Service, owner: httpx.Client, of_log: str
) -> None:
    """They have the token here: without it nobody ends a session to begin another one."""
    path = f"/api/classes/{owner.post('/api/classes').json()['code']}"
    assert owner.put(f"{path}/puzzle", json={"puzzle": of_log}).status_code == 204
    first, second = (person(service, knows_token=True) for _ in range(2))
    for one in (first, second):
        one.get("/join")  # the service gives a cookie
    sessions = [begun(one, f"{path}/puzzle/sessions") for one in (first, second)]
    state(first, sessions[0], "/hint")
    state(first, sessions[0], "/answer", cause="drift")
    assert state(first, sessions[0], "/solution")["answer"]["cause"] == "beam_order"
    state(second, sessions[1], "/answer", cause="window")

    for one, session in zip((first, second), sessions, strict=True):
        assert one.delete(f"/api/sessions/{session}").status_code == 204
    sessions = [begun(one, f"{path}/puzzle/sessions") for one in (first, second)]
    again = state(first, sessions[0])
    assert (again["gave_up"], again["points"], len(again["hints"]), again["wrong"]) == (True, 0, 1, ["drift"])
    refused = first.post(f"/api/sessions/{sessions[0]}/puzzle/answer", json={"cause": "beam_order"})
    assert refused.json()["code"] == "puzzle.over"
    assert state(second, sessions[1])["wrong"] == ["window"]
    assert state(second, sessions[1], "/answer", cause="beam_order")["points"] == 40 - 10
    rows = list(csv.DictReader(io.StringIO(owner.get(f"{path}/results.csv").text)))
    assert {row["option"]: row["answers"] for row in rows if row["option"]} == {
        "begun": "2", "cause named": "1", "solved": "0"
    }  # fmt: skip
    assert owner.delete(path).status_code == 204
    first.close()
    second.close()


@pytest.mark.parametrize("name", [recipe.name for recipe in RECIPES.values()])
def test_a_puzzle_of_the_first_level_has_four_causes_and_each_has_its_own(name: str) -> None:
    recipe = RECIPES[name]
    assert len(recipe.choices or CAUSES) == (4 if recipe.level == 1 else 16)
    assert recipe.cause in (recipe.choices or CAUSES)
    assert set(recipe.choices) <= set(CAUSES)


def test_a_cause_that_a_puzzle_does_not_offer_is_refused(owner: httpx.Client) -> None:
    session = begun(owner, "/api/puzzles/doorway/sessions")
    first = state(owner, session)
    offered = [one["name"] for one in first["causes"]]
    assert len(offered) == 4
    assert first["repaired_with"] is None
    refused = owner.post(f"/api/sessions/{session}/puzzle/answer", json={"cause": "sonar"})
    assert (refused.status_code, refused.json()["code"]) == (422, "puzzle.cause")
    assert [one["name"] for one in state(owner, session)["causes"]] == offered
    named = state(owner, session, "/answer", cause="resolution")
    assert named["repaired_with"] == {"parameters": ["resolution"], "poses": False}
    owner.delete(f"/api/sessions/{session}")


def pixels(client: httpx.Client, path: str) -> NDArray[np.uint8]:
    answer = client.get(path)
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"] == "image/png"
    return np.asarray(Image.open(io.BytesIO(answer.content)).convert("RGB"))


def test_the_picture_of_a_puzzle_is_the_map_that_an_attempt_begins_with(owner: httpx.Client) -> None:
    picture = pixels(owner, "/api/puzzles/doorway/map.png")
    session = begun(owner, "/api/puzzles/doorway/sessions")
    grid = owner.get(f"/api/sessions/{session}/map.pgm")  # 0 occupied, 254 free, 205 unknown, as map_server writes
    state = np.asarray(Image.open(io.BytesIO(grid.content)))
    seen = state != 205
    rows, cols = (seen.any(axis=axis).nonzero()[0] for axis in (1, 0))
    state = state[rows[0] : rows[-1] + 1, cols[0] : cols[-1] + 1]
    drawn = np.select([(picture == colour).all(axis=2) for colour in LIGHT[:3]], [205, 254, 0], 99)
    pixels_per_cell = max(drawn.shape) // max(state.shape)
    assert pixels_per_cell > 1
    # Cells between the two thresholds may lie at the border.
    assert np.abs(np.subtract(drawn.shape, np.multiply(state.shape, pixels_per_cell))).max() <= 2 * pixels_per_cell
    for value in (0, 254):
        assert (drawn == value).sum() == (state == value).sum() * pixels_per_cell**2
    dark = pixels(owner, "/api/puzzles/doorway/map.png?dark=true")
    assert ((dark == DARK[2]).all(axis=2) == (drawn == 0)).all()


def test_each_puzzle_has_a_picture_and_nothing_else_does() -> None:
    assert {file.name for file in FOLDER.iterdir()} == {f"{name}.png" for name in RECIPES}


@pytest.mark.parametrize(
    "name",
    ["bumped", "offset", "torn", "cones", *also_long(*sorted(RECIPES.keys() - {"bumped", "offset", "torn", "cones"}))],
)
def test_the_picture_of_a_puzzle_is_what_is_drawn_now(name: str) -> None:
    """If not: ``python -m server.puzzles.pictures``."""
    codes = np.asarray(Image.open(FOLDER / f"{name}.png"))
    now = codes_of(name)
    assert codes.shape == now.shape
    # Processors differ in the last bit of a range, and so in a cell here and there.
    assert (codes == now).mean() > 0.98


def test_a_cell_at_the_lower_clamp_is_free_in_the_picture() -> None:
    grid = OccupancyGrid(GridGeometry(1.0, 1, 5))
    grid.log_odds[0] = [-0.5, -0.4, 3.0, -4.0, 0.0]
    grid.observed[0] = [True, True, True, True, False]
    codes = picture_codes(grid, log_odds_min=-0.5)
    side = codes.shape[0]
    assert codes[0, ::side].tolist() == [FREE, UNOBSERVED, OCCUPIED, FREE]


def test_an_unknown_puzzle_has_no_picture(owner: httpx.Client) -> None:
    answer = owner.get("/api/puzzles/nothing/map.png")
    assert (answer.status_code, answer.json()["code"]) == (422, "puzzle.unknown")
