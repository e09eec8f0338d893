"""A class over real sockets: what the lecturer shows, what followers may do, questions, a copy, the end."""

from __future__ import annotations

import asyncio
import base64
import csv
import io
import json
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import httpx
import pytest
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed
from websockets.typing import Subprotocol

from server.classes import classes, classroom
from server.http.brake import CodeGuesses
from tests.server.service import PATIENCE_S, Service, Watcher, running, settings_for, stream_at, until_closed

TOKEN = "long enough"


class Person:
    """A browser with cookies of its own."""

    def __init__(self, service: Service, *, knows_token: bool) -> None:
        headers = {"Authorization": f"Bearer {TOKEN}"} if knows_token else {}
        self.http = httpx.Client(base_url=service.http.base_url, timeout=PATIENCE_S, headers=headers)
        self.service = service
        self.headers = headers

    def stream(self, path: str) -> Any:
        self.http.get("/join")  # the service gives a cookie
        cookies = "; ".join(f"{name}={value}" for name, value in self.http.cookies.items())
        address = f"ws://127.0.0.1:{self.service.port}{path}"
        return stream_at(address, additional_headers={"Cookie": cookies} | self.headers)


class Seat:
    """One connection to a class: the newest message of each type."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket
        self.newest: dict[str, dict[str, Any]] = {}

    async def send(self, kind: str, **more: Any) -> None:
        await self.socket.send(json.dumps({"type": kind} | more))

    async def until(self, kind: str, holds: Callable[[dict[str, Any]], Any] = lambda _: True) -> dict[str, Any]:
        async with asyncio.timeout(PATIENCE_S):
            while kind not in self.newest or not holds(self.newest[kind]):
                message = json.loads(await self.socket.recv())
                self.newest[message["type"]] = message
        return self.newest[kind]


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    settings = settings_for(tmp_path_factory.mktemp("class"), token=TOKEN, max_sessions=4)
    with running(settings) as service:
        yield service


@pytest.fixture
def lecturer(service: Service) -> Iterator[Person]:
    person = Person(service, knows_token=True)
    yield person
    open_one = person.http.get("/api/classes")
    if open_one.status_code == 200:
        person.http.delete(f"/api/classes/{open_one.json()['code']}")
    for session in person.http.get("/api/sessions").json()["sessions"]:
        person.http.delete(f"/api/sessions/{session['id']}")
    person.http.close()


@pytest.fixture
def guest(service: Service) -> Iterator[Person]:
    person = Person(service, knows_token=False)
    yield person
    person.http.close()


def no_guesses_yet(service: Service, monkeypatch: pytest.MonkeyPatch) -> None:
    """Have the service forget the wrong codes so far, and those of the test after it."""
    for name, brake in vars(CodeGuesses(lambda: 0.0)).items():
        monkeypatch.setattr(service.state.code_brake, name, brake)


def shows_place(place: str, message: dict[str, Any]) -> bool:
    """Whether a message has this address of the lecturer's page."""
    return bool(message["view"]["hash"] == place)


def voting_is(is_closed: bool, state: dict[str, Any]) -> bool:
    """Whether a question is asked whose voting is closed, or not."""
    return state["question"] is not None and state["question"]["is_closed"] is is_closed


def lab_of(person: Person) -> str:
    wanted = {"kind": "simulation", "world": "room", "seed": 3}
    return str(person.http.post("/api/sessions", json=wanted).json()["id"])


async def test_followers_see_answer_and_copy_but_do_not_steer(lecturer: Person, guest: Person) -> None:
    session = lab_of(lecturer)
    opened = lecturer.http.post("/api/classes").json()
    code = opened["code"]
    assert opened["address"].endswith(f"/class/{code}")
    assert lecturer.http.get(opened["qr"]).text.startswith("<svg")
    class_path = f"/api/classes/{code}"
    async with lecturer.stream(f"{class_path}/stream") as front, guest.stream(f"{class_path}/stream") as back:
        teacher, pupil = Seat(front), Seat(back)
        assert (await teacher.until("welcome"))["role"] == "lecturer"
        assert (await pupil.until("welcome"))["number"] == 1
        await teacher.until("class", lambda state: state["present"] == 1)

        view = {"page": "lab", "pinned": [1.0, 2.0], "group": "why", "hash": ""}
        await teacher.send("show", view=view, session=session)
        seen = await pupil.until("view", lambda message: message["stage"] == 1)
        assert seen["view"]["pinned"] == [1.0, 2.0]
        assert session not in json.dumps(seen)  # who knows the id can steer the robot
        page = guest.http.get(f"/class/{code}")
        assert page.headers["location"] == f"/class/{code}/lab.html"

        # the session is seen, and obeys only whom the robot was handed to
        async with guest.stream(f"{class_path}/session") as socket:
            watcher = Watcher(socket)
            await watcher.until(lambda: watcher.complete)
            assert watcher.newest["hello"]["session"] == ""
            for command in ({"type": "pause"}, {"type": "teleport", "x": 1.0, "y": 1.0}, {"type": "restart"}):
                await socket.send(json.dumps(command))
                assert (await watcher.answer("error"))["code"] == "class.read_only"
            await pupil.send("raise", value=True)
            await teacher.until("class", lambda state: state["hands"] == [1])
            await teacher.send("hand", number=1)
            await pupil.until("class", lambda state: state["driver"] == 1)
            await watcher.send("auto", value=False)
            await watcher.until(lambda: watcher.newest["frame"]["auto"] is False)
            await watcher.send("pause")
            assert (await watcher.answer("error"))["code"] == "class.read_only"
            await teacher.send("hand")
            await pupil.until("class", lambda state: state["driver"] is None)

        # a copy of one's own obeys, and the lecturer's is left alone
        own = guest.http.post(f"{class_path}/sessions")
        assert own.status_code == 201, own.text
        async with guest.stream(own.json()["stream"]) as socket:
            watcher = Watcher(socket)
            await watcher.send("pause")
            await watcher.until(lambda: watcher.newest.get("frame", {}).get("playing") is False)
        assert lecturer.http.get(f"/api/sessions/{session}").json()["playing"] is True
        again = guest.http.post(f"{class_path}/sessions").json()["id"]
        assert guest.http.get(f"/api/sessions/{own.json()['id']}").status_code == 401  # one for each follower

        # a question: nothing is shown to the followers before the reveal
        await teacher.send("ask", text="Which?", options=["a", "b"], right=1)
        asked = (await pupil.until("class", lambda state: state["question"]))["question"]
        assert asked["counts"] is None
        assert asked["right"] is None
        await pupil.send("answer", question=asked["id"], value=0)
        await pupil.send("answer", question=asked["id"], value=1)
        state = await teacher.until("class", lambda state: state["question"] and state["question"]["answered"] == 1)
        assert state["question"]["counts"] == [0, 1]
        # no more answers once voting is closed, and the answer that is counted is told
        await teacher.send("stop")
        closed = (await pupil.until("class", lambda state: state["question"]["is_closed"]))["question"]
        assert (closed["is_revealed"], closed["counts"], closed["right"]) == (False, None, None)
        await pupil.send("answer", question=asked["id"], value=0)
        refused = await pupil.until("refused")
        assert (refused["code"], refused["answer"]) == ("class.closed", 1.0)
        # opened again, it keeps the answer, which can be changed
        await teacher.send("stop", value=False)
        opened_again = (await teacher.until("class", lambda state: not state["question"]["is_closed"]))["question"]
        assert (opened_again["id"], opened_again["counts"]) == (asked["id"], [0, 1])
        await pupil.send("answer", question=asked["id"], value=0)
        await teacher.until("class", lambda state: state["question"]["counts"] == [1, 0])
        await pupil.send("answer", question=asked["id"], value=1)
        await teacher.until("class", lambda state: state["question"]["counts"] == [0, 1])
        await teacher.send("reveal")
        shown = await pupil.until("class", lambda state: state["question"] and state["question"]["is_revealed"])
        assert shown["question"]["counts"] == [0, 1]
        assert shown["question"]["right"] == 1
        assert shown["question"]["is_closed"]
        await teacher.send("stop", value=False)
        assert (await teacher.until("refused"))["code"] == "class.revealed"
        pupil.newest.pop("refused")
        await pupil.send("answer", question=asked["id"], value=0)
        assert (await pupil.until("refused"))["code"] == "class.closed"
        rows = list(csv.DictReader(io.StringIO(lecturer.http.get(opened["results"]).text)))
        assert [(row["option"], row["answers"], row["right"]) for row in rows] == [("a", "0", "no"), ("b", "1", "yes")]

        # the end
        assert lecturer.http.delete(class_path).status_code == 204
        assert (await pupil.until("class", lambda state: state["has_ended"]))["code"] == code
        with pytest.raises(ConnectionClosed):
            await back.recv()
    assert guest.http.get(class_path).status_code == 404
    assert lecturer.http.get(f"/api/sessions/{again}").status_code == 404  # it has ended with the class
    assert guest.http.get(f"/class/{code}").headers["location"] == "/join?refused=class.unknown"


async def test_the_lecturers_browser_follows_the_class_in_a_second_page(lecturer: Person) -> None:
    session = lab_of(lecturer)
    path = f"/api/classes/{lecturer.http.post('/api/classes').json()['code']}/stream"
    async with lecturer.stream(path) as front, lecturer.stream(f"{path}?follows=true") as second:
        teacher, pupil = Seat(front), Seat(second)
        await teacher.send("show", view={"page": "lab", "hash": ""}, session=session)
        assert (await pupil.until("welcome"))["role"] == "follower"
        assert (await pupil.until("view", lambda message: message["stage"] == 1))["view"]["page"] == "lab"
        await teacher.until("class", lambda state: state["present"] == 1)
        await pupil.send("lock", value=True)
        assert (await pupil.until("refused"))["code"] == "class.lecturer"


async def test_a_page_of_another_version_is_asked_to_reload(lecturer: Person, service: Service) -> None:
    path = f"/api/classes/{lecturer.http.post('/api/classes').json()['code']}/stream"
    cookies = "; ".join(f"{name}={value}" for name, value in lecturer.http.cookies.items())
    older = Subprotocol("gridbloom.v2")
    headers = {"Cookie": cookies} | lecturer.headers
    async with connect(
        f"ws://127.0.0.1:{service.port}{path}", subprotocols=[older], additional_headers=headers
    ) as page:
        assert page.subprotocol == older  # or the browser would not let the page hear it
        assert json.loads(await page.recv()) == {"type": "hello", "protocol": "gridbloom.v3"}
        await until_closed(page)
        assert page.close_code == 1008


async def test_the_map_of_a_log_is_followed_and_copied_and_the_copy_says_nothing_of_the_log(
    lecturer: Person, guest: Person
) -> None:
    wanted = {"kind": "log", "log": "sample-office", "playing": False}
    session = lecturer.http.post("/api/sessions", json=wanted).json()["id"]
    class_path = f"/api/classes/{lecturer.http.post('/api/classes').json()['code']}"
    async with lecturer.stream(f"/api/sessions/{session}/stream") as socket:
        watcher = Watcher(socket)
        await watcher.until(lambda: watcher.complete)
        await watcher.send("seek", index=25)
        await watcher.send("parameters", values={"range_max": 4.0})
        await watcher.until(lambda: watcher.newest["frame"]["index"] == 25)
        await watcher.until(lambda: watcher.newest["parameters"]["values"]["range_max"] == 4.0)
        async with lecturer.stream(f"{class_path}/stream") as front, guest.stream(f"{class_path}/stream") as back:
            await Seat(front).send("show", view={"page": "logs", "group": "settings"}, session=session)
            await Seat(back).until("view", lambda message: message["stage"] == 1)
            path = class_path.removeprefix("/api/classes")
            assert guest.http.get(f"/class{path}").headers["location"] == f"/class{path}/logs.html"
            assert guest.http.get(f"/class{path}/logs.html").status_code == 200
            async with guest.stream(f"{class_path}/session") as shown:
                follower = Watcher(shown)
                await follower.until(lambda: follower.complete)
                assert follower.newest["hello"]["session"] == ""
                await follower.send("seek", index=3)
                assert (await follower.answer("error"))["code"] == "class.read_only"
            made = guest.http.post(f"{class_path}/sessions")
            assert made.status_code == 201, made.text
            async with guest.stream(made.json()["stream"]) as copied:
                own = Watcher(copied)
                await own.until(lambda: own.complete and own.newest["frame"]["index"] == 25)
                assert own.newest["hello"]["log"]["id"] == ""
                assert own.newest["parameters"]["values"]["range_max"] == 4.0
                maps = [
                    person.http.get(f"/api/sessions/{id_}/map.pgm")
                    for person, id_ in ((lecturer, session), (guest, made.json()["id"]))
                ]
                assert [one.status_code for one in maps] == [200, 200]
                assert maps[0].content == maps[1].content
                await own.send("parameters", values={"range_max": 2.0})
                await own.until(lambda: own.newest["parameters"]["values"]["range_max"] == 2.0)
            assert watcher.newest["parameters"]["values"]["range_max"] == 4.0
            refused = guest.http.get(f"/api/sessions/{made.json()['id']}/links")
            assert refused.json()["code"] == "security.token"
    lecturer.http.delete(class_path)


async def test_a_session_that_is_not_shown_any_more_is_not_seen(lecturer: Person, guest: Person) -> None:
    session, code = lab_of(lecturer), lecturer.http.post("/api/classes").json()["code"]
    path = f"/api/classes/{code}"

    async with lecturer.stream(f"{path}/stream") as front, guest.stream(f"{path}/stream") as back:
        teacher, pupil = Seat(front), Seat(back)
        for stage in (1, 3):
            await teacher.send("show", view={"page": "lab"}, session=session)
            while (await pupil.until("view"))["stage"] != stage:
                del pupil.newest["view"]
            async with guest.stream(f"{path}/session") as socket:
                watcher = Watcher(socket)
                while not watcher.complete:
                    await watcher.read()
                if stage == 1:
                    await teacher.send("show", view={"page": "other"})
                else:
                    lecturer.http.delete(path)
                await until_closed(socket)
                assert socket.close_code == 4410
    assert lecturer.http.get(f"/api/sessions/{session}").status_code == 200


async def test_a_follower_who_comes_back_is_the_same_and_a_locked_class_takes_nobody_else(
    service: Service, lecturer: Person, guest: Person
) -> None:
    code = lecturer.http.post("/api/classes").json()["code"]
    assert lecturer.http.post("/api/classes").json()["code"] == code  # one for each lecturer
    path = f"/api/classes/{code}/stream"
    late = Person(service, knows_token=False)
    async with lecturer.stream(path) as front:
        teacher = Seat(front)
        async with guest.stream(path) as socket:
            await Seat(socket).until("welcome")
            await teacher.send("show", view={"page": "lecture", "hash": "?present#cell/2"})
            await teacher.send("ask", text="How far?", axis={"low": 0, "high": 40, "unit": "m"})
            pupil = Seat(socket)
            asked = (await pupil.until("class", lambda state: state["question"]))["question"]
            await pupil.send("answer", question=asked["id"], value=40.0)
            await teacher.until("class", lambda state: state["question"] and state["question"]["answered"] == 1)
        await teacher.send("lock", value=True)
        await teacher.until("class", lambda state: state["is_locked"] and state["present"] == 0)
        async with guest.stream(path) as socket:
            back = Seat(socket)
            assert await back.until("welcome") == {"type": "welcome", "role": "follower", "number": 1, "answer": 40.0}
            assert (await back.until("view"))["view"]["hash"] == "?present#cell/2"
        async with late.stream(path) as socket:
            with pytest.raises(ConnectionClosed, match=r"class\.locked"):
                await socket.recv()
        counts = (await teacher.until("class", lambda state: state["question"]))["question"]["counts"]
        assert counts == [0] * 19 + [1]
    late.http.close()


async def test_commands_that_are_not_a_followers_are_refused(lecturer: Person, guest: Person) -> None:
    code = lecturer.http.post("/api/classes").json()["code"]
    session = lab_of(lecturer)
    path = f"/api/classes/{code}/stream"
    async with lecturer.stream(path) as front, guest.stream(path) as back:
        pupil = Seat(back)
        await pupil.until("welcome")
        for command in (
            {"type": "ask", "text": "?", "options": ["a", "b"]},
            {"type": "show", "view": {"page": "lab"}, "session": session},
            {"type": "hand", "number": 1},
            {"type": "lock", "value": True},
        ):
            pupil.newest.pop("refused", None)
            await back.send(json.dumps(command))
            assert (await pupil.until("refused"))["code"] == "class.lecturer"
        pupil.newest.pop("refused", None)
        await back.send("{")
        assert (await pupil.until("refused"))["code"] == "class.command"
        teacher = Seat(front)
        for wrong, error in (
            ({"text": "?", "options": ["a"]}, "class.options"),
            ({"text": " ", "options": ["a", "b"]}, "class.question"),
            ({"text": "?", "axis": {"low": 2, "high": 2}}, "class.axis"),
            ({"text": "?", "options": ["a", "b"], "right": 2}, "class.right"),
        ):
            teacher.newest.pop("refused", None)
            await teacher.send("ask", **wrong)
            assert (await teacher.until("refused"))["code"] == error
    for method, place in (
        ("GET", f"/api/classes/{code}/results.csv"),
        ("DELETE", f"/api/classes/{code}"),
        ("POST", "/api/classes"),
        ("GET", f"/api/sessions/{session}"),
    ):
        assert guest.http.request(method, place).status_code == 401, place


def test_a_follower_copies_the_world_a_few_times_and_has_one_copy(
    service: Service, lecturer: Person, guest: Person
) -> None:
    world = lecturer.http.post("/api/sessions", json={"kind": "simulation", "playing": False}).json()["id"]
    code = lecturer.http.post("/api/classes").json()["code"]
    guest.http.get("/join")  # the service gives a cookie

    async def shows() -> None:
        async with lecturer.stream(f"/api/classes/{code}/stream") as socket:
            seat = Seat(socket)
            await seat.send("show", view={"page": "lab"}, session=world)
            await seat.send("lock", value=False)
            await seat.until("class")
            for _ in range(7):
                answer = await asyncio.to_thread(guest.http.post, f"/api/classes/{code}/sessions")
                codes.append(answer.status_code)
            copies.extend(one for one in service.state.sessions.all() if one.link == f"class {code}")

    codes: list[int] = []
    copies: list[Any] = []
    asyncio.run(shows())
    assert codes == [201] * 6 + [429]
    assert len(copies) == 1


def test_a_further_follower_of_a_crowded_network_is_told_to_use_another(
    lecturer: Person, guest: Person, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(classes, "ADDRESS_SHARE", 1 / 400)  # of 400 places
    code = lecturer.http.post("/api/classes").json()["code"]
    newcomer = Person(guest.service, knows_token=False)

    async def joins() -> None:
        async with guest.stream(f"/api/classes/{code}/stream") as socket:
            await Seat(socket).until("welcome")
            refused = newcomer.http.get(f"/api/classes/{code}")
            assert refused.status_code == 429
            assert refused.json()["code"] == "class.crowded_address"
            assert "mobile data" in refused.json()["message"]
            for path in (f"/class/{code}", f"/class/{code}/lecture.html"):  # scanned, and reloaded
                assert newcomer.http.get(path).headers["location"] == "/join?refused=class.crowded_address"
            assert guest.http.get(f"/class/{code}/lecture.html").status_code == 200

    asyncio.run(joins())
    newcomer.http.close()


def test_who_asks_for_a_puzzle_that_is_not_there_takes_no_number(lecturer: Person, guest: Person) -> None:
    """A class has a limited quantity of them."""
    code = lecturer.http.post("/api/classes").json()["code"]
    assert guest.http.post(f"/api/classes/{code}/puzzle/sessions").json()["code"] == "class.no_puzzle"
    assert not guest.service.state.classes.get(code).knows(guest.http.cookies["gridbloom_visitor"])


def test_who_guesses_is_refused_and_others_of_the_network_still_join(
    service: Service, lecturer: Person, guest: Person, monkeypatch: pytest.MonkeyPatch
) -> None:
    no_guesses_yet(service, monkeypatch)
    code = lecturer.http.post("/api/classes").json()["code"]
    guest.http.get("/join")  # the service gives a cookie
    answers = [guest.http.get("/api/classes/BBBBBB").status_code for _ in range(63)]
    assert answers == [404] * 12 + [429] * 51
    assert guest.http.get(f"/api/classes/{code}").status_code == 429
    assert guest.http.get(f"/class/{code}").headers["location"] == "/join?refused=class.guesses"
    newcomer = Person(service, knows_token=False)  # another one in the same hall
    assert newcomer.http.get(f"/class/{code}").headers["location"] == f"/class/{code}/other.html"
    newcomer.http.close()


def test_who_drops_the_cookie_is_refused_by_the_network_except_who_is_in_the_class(
    service: Service, lecturer: Person, guest: Person, monkeypatch: pytest.MonkeyPatch
) -> None:
    code = lecturer.http.post("/api/classes").json()["code"]
    no_guesses_yet(service, monkeypatch)

    async def joins() -> None:
        async with guest.stream(f"/api/classes/{code}/stream") as socket:
            await Seat(socket).until("welcome")

    asyncio.run(joins())
    answers: list[int] = []
    with httpx.Client(base_url=service.http.base_url, timeout=PATIENCE_S) as somebody:
        for _ in range(310):
            somebody.cookies.clear()
            answers.append(somebody.get("/api/classes/BBBBBB").status_code)
    assert answers == [404] * 300 + [429] * 10
    newcomer = Person(service, knows_token=False)
    assert [who.http.get(f"/api/classes/{code}").status_code for who in (guest, newcomer)] == [200, 429]
    newcomer.http.close()


@pytest.mark.parametrize("knows_code", [True, False])
@pytest.mark.parametrize(
    ("method", "what"),
    [("GET", "/results.csv"), ("GET", "/qr.svg"), ("DELETE", ""), ("DELETE", "/puzzle"), ("PUT", "/puzzle")],
)
def test_what_is_the_lecturers_answers_others_as_if_there_were_no_class(
    service: Service,
    lecturer: Person,
    monkeypatch: pytest.MonkeyPatch,
    method: str,
    what: str,
    *,
    knows_code: bool,
) -> None:
    """Another visitor with the token learns no code by them, and they are counted with the guesses for joining."""
    no_guesses_yet(service, monkeypatch)
    code = lecturer.http.post("/api/classes").json()["code"] if knows_code else "BBBBBB"
    other = Person(service, knows_token=True)
    other.http.get("/join")  # the service gives a cookie
    body = {"puzzle": "doorway"} if method == "PUT" else None
    answers = [other.http.request(method, f"/api/classes/{code}{what}", json=body) for _ in range(13)]
    assert [answer.status_code for answer in answers] == [404] * 12 + [429]
    assert answers[0].json()["code"] == "class.unknown"
    assert other.http.get(f"/api/classes/{code}").status_code == 429
    if knows_code:
        assert lecturer.http.get(f"/api/classes/{code}/qr.svg").status_code == 200
    other.http.close()


async def test_a_deck_in_the_lecturers_address_reaches_no_follower(lecturer: Person, guest: Person) -> None:
    """As a page of an earlier version sends it; and fields of a slide that a follower has no use for."""
    code = lecturer.http.post("/api/classes").json()["code"]
    path = f"/api/classes/{code}/stream"
    deck = base64.urlsafe_b64encode(b"PRIVATE and LATER").decode()
    slide = {"kind": "text", "title": "Now", "text": "This one", "notes": "PRIVATE", "hidden": True}
    async with lecturer.stream(path) as front, guest.stream(path) as back:
        teacher, pupil = Seat(front), Seat(back)
        for sent, place in (
            (f"?present#own-text-2/3&deck={deck}", "?present#own-text-2/3"),
            (f"?present&deck={deck}#own-text", "?present"),
            (f"?present#own/{deck}", "?present#own"),
            ("#cell", "#cell"),
            (f"?deck={deck}", ""),
        ):
            await teacher.send("show", view={"page": "lecture", "hash": sent, "slide": slide})
            seen = (await pupil.until("view", partial(shows_place, place)))["view"]
            assert seen["slide"] == {
                "kind": "text",
                "title": "Now",
                "text": "This one",
                "section": None,
                "address": None,
            }
            assert "PRIVATE" not in json.dumps(seen)
            assert deck not in json.dumps(seen)
            pupil.newest.clear()


async def test_followers_are_told_that_the_lecturer_is_away(
    lecturer: Person, guest: Person, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(classroom, "AWAY_AFTER_S", 0.1)
    path = f"/api/classes/{lecturer.http.post('/api/classes').json()['code']}/stream"
    async with guest.stream(path) as back:
        pupil = Seat(back)
        async with lecturer.stream(path):
            await pupil.until("class", lambda state: not state["is_lecturer_away"])
        await pupil.until("class", lambda state: state["is_lecturer_away"])
        async with lecturer.stream(path):
            await pupil.until("class", lambda state: not state["is_lecturer_away"])


async def test_voting_closes_when_the_lecturer_moves_on(lecturer: Person, guest: Person) -> None:
    code = lecturer.http.post("/api/classes").json()["code"]
    path = f"/api/classes/{code}/stream"
    async with lecturer.stream(path) as front, guest.stream(path) as back:
        teacher, pupil = Seat(front), Seat(back)
        for at, is_closed in (("?present#cell/2", False), ("?present#cell/3", False), ("?present#rays", True)):
            await teacher.send("show", view={"page": "lecture", "hash": at})
            if at.endswith("/2"):
                await teacher.send("ask", text="How many?", options=["7", "8"], right=0)
            await pupil.until("view", partial(shows_place, at))
            state = await pupil.until("class", partial(voting_is, is_closed))
            assert state["question"]["right"] is None
        await pupil.send("answer", question=1, value=0)
        refused = await pupil.until("refused")
        assert (refused["code"], refused["answer"]) == ("class.closed", None)
        assert "too late" in refused["message"]


async def test_answers_are_counted_of_each_number_or_only_of_who_had_joined(
    service: Service, lecturer: Person, guest: Person
) -> None:
    opened = lecturer.http.post("/api/classes").json()
    path = f"/api/classes/{opened['code']}/stream"
    again = [Person(service, knows_token=False) for _ in range(3)]  # the same person with fresh cookies
    async with lecturer.stream(path) as front, guest.stream(path) as back:
        teacher, pupil = Seat(front), Seat(back)
        await teacher.until("class", lambda state: state["present"] == 1)
        await teacher.send("ask", text="Which?", options=["a", "b"])
        await pupil.until("class", lambda state: state["question"])
        await pupil.send("answer", question=1, value=0)
        for one in again:
            async with one.stream(path) as socket:
                seat = Seat(socket)
                await seat.until("class", lambda state: state["question"])
                await seat.send("answer", question=1, value=1)
                await seat.send("raise", value=True)
                await teacher.until("class", lambda state: state["hands"])
            await teacher.until("class", lambda state: not state["hands"])
        state = await teacher.until("class", lambda state: state["question"]["answered"] == 4)
        assert state["question"]["counts"] == [1, 3]
        assert state["question"]["last_number"] is None
        await teacher.send("count", joined_only=True)
        state = await teacher.until("class", lambda state: state["counts_joined_only"])
        assert (state["question"]["answered"], state["question"]["counts"]) == (1, [1, 0])
        assert (await pupil.until("class", lambda state: state["question"]["last_number"]))["question"][
            "last_number"
        ] == 1
        rows = list(csv.DictReader(io.StringIO(lecturer.http.get(opened["results"]).text)))
        assert [row["answers"] for row in rows] == ["1", "0"]
        await pupil.send("count", joined_only=False)
        assert (await pupil.until("refused"))["code"] == "class.lecturer"
    for one in again:
        one.http.close()
