"""Two services on one PostgreSQL and one bucket behind HAProxy: pages go on when theirs is killed."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path

import httpx
import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect

from tests.browser.classes.test_class import shows_cell
from tests.browser.looking import await_map, await_true, frame, open_group, settled_digest, told, until
from tests.browser.running import free_port
from tests.browser.visits import visiting
from tests.haproxy import running_haproxy
from tests.server.library.postgresql import running_postgresql
from tests.server.library.small_logs import carmen
from tests.server.service import PATIENCE_S
from tests.server.service import until as eventually

pytestmark = [pytest.mark.moving, pytest.mark.long]

BUCKET = "gridbloom"
TOKEN = "a-token-of-the-tests-0123456789"
FOLLOWERS = 4
S3 = {"AWS_ACCESS_KEY_ID": "tests", "AWS_SECRET_ACCESS_KEY": "tests", "AWS_REGION": "us-east-1", "AWS_ALLOW_HTTP": "1"}


def answers(address: str) -> bool:
    request = urllib.request.Request(address, headers={"Authorization": f"Bearer {TOKEN}"})
    try:
        with urllib.request.urlopen(request, timeout=60):
            return True
    except OSError:
        return False


def status_for(address: str, cookies: dict[str, str]) -> int:
    """The status of the answer to a browser that has these cookies."""
    return httpx.get(address, cookies=cookies, timeout=60).status_code


@contextmanager
def process(command: list[str], log: Path, **environment: str) -> Iterator[subprocess.Popen[bytes]]:
    """Run a program until the block ends; it may be killed before."""
    with log.open("ab") as output:
        running = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT, env=os.environ | environment)
    try:
        yield running
    finally:
        running.terminate()
        try:
            running.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            running.kill()
            running.wait()


class Replicas:
    """Services by the port of each, and the address of the proxy; ``start`` starts one at a port."""

    def __init__(self, address: str, ports: list[int], start: Callable[[int], subprocess.Popen[bytes]]) -> None:
        self.address, self._ports, self._start = address, ports, start
        self._processes: dict[int, subprocess.Popen[bytes]] = {}

    def complete(self) -> None:
        """Start the services that do not run, and wait until all are ready."""
        for port in self._ports:
            if port not in self._processes:
                self._processes[port] = self._start(port)
        for port in self._ports:
            eventually(partial(answers, f"http://127.0.0.1:{port}/readyz"))
        eventually(lambda: answers(f"{self.address}/readyz"))

    def of_session(self, session: str) -> int:
        """The port of the only service that has a session."""
        found = [port for port in self._processes if answers(f"http://127.0.0.1:{port}/api/sessions/{session}")]
        assert len(found) == 1
        return found[0]

    def kill(self, port: int) -> None:
        killed = self._processes.pop(port)
        killed.kill()
        killed.wait()


@contextmanager
def two_services(folder: Path, **environment: str) -> Iterator[Replicas]:
    """Two services behind a proxy, which have not begun yet."""
    with ExitStack() as stack:
        cluster = stack.enter_context(running_postgresql())
        ports = [free_port(), free_port()]
        address = stack.enter_context(running_haproxy(folder, free_port(), ports))
        endpoint = f"http://127.0.0.1:{free_port()}"
        moto = [sys.executable, "-m", "moto.server", "-p", endpoint.rsplit(":", 1)[1]]
        stack.enter_context(process(moto, folder / "s3.log"))
        eventually(lambda: answers(endpoint))
        request = urllib.request.Request(f"{endpoint}/{BUCKET}", method="PUT")
        urllib.request.urlopen(request, timeout=60).close()
        gridbloom = str(Path(sys.executable).with_name("gridbloom"))
        stores = ["--database", cluster.new_database(), "--blobs", f"s3://{BUCKET}/logs"]

        def start(port: int) -> subprocess.Popen[bytes]:
            command = [gridbloom, "serve", "--port", str(port), "--data-dir", str(folder / str(port)), *stores]
            known = S3 | {"AWS_ENDPOINT": endpoint} | environment
            return stack.enter_context(process(command, folder / f"{port}.log", **known))

        yield Replicas(address, ports, start)


@pytest.fixture(scope="module")
def services(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Replicas]:
    with two_services(tmp_path_factory.mktemp("replicas")) as services:
        yield services


@pytest.fixture
def replicas(services: Replicas) -> Replicas:
    """All services, also those that the test before has killed."""
    services.complete()
    return services


@pytest.fixture
def guarded(tmp_path: Path) -> Iterator[Replicas]:
    """Services that need a token."""
    with two_services(tmp_path, GRIDBLOOM_TOKEN=TOKEN) as services:
        services.complete()
        yield services


def session_of(page: Page) -> str:
    return str(page.evaluate("() => gridbloom.connection.store.hello.peek().session"))


def test_pages_reopen_on_the_other_service_when_theirs_is_killed(
    context: BrowserContext, replicas: Replicas, tmp_path: Path
) -> None:
    (tmp_path / "mine.log").write_bytes(carmen(60))
    logs = context.new_page()
    logs.goto(f"{replicas.address}/logs.html")
    logs.set_input_files("input[type=file]", tmp_path / "mine.log")
    await_true(logs, "() => window.gridbloom && gridbloom.connection.store.frame.peek()")
    lab = context.new_page()
    lab.goto(f"{replicas.address}/lab.html")
    await_map(lab)
    lab.get_by_role("button", name="Pause").click()
    open_group(lab, "Faults")
    lab.get_by_role("switch", name="Odometry drift").click()
    kept = settled_digest(lab)

    def is_told() -> bool:
        story = told(lab).get("story", {})
        return story.get("playing") is False and story["faults"] == {"drift": True}

    until("the address to tell of the pause and the fault", is_told)

    before = session_of(lab), session_of(logs)
    theirs = {replicas.of_session(one) for one in before}
    assert len(theirs) == 1, "all sessions of a visitor are with one service"
    # Acknowledged by the service that is killed, and perhaps not read yet.
    late = context.request.put(f"{replicas.address}/api/logs?name=late.log", data=carmen(40))
    assert late.status == 202
    replicas.kill(theirs.pop())

    expect(lab.locator(".toast")).to_contain_text("Its world was restored")
    expect(lab.locator(".lab-status")).to_have_text("live")
    assert settled_digest(lab) == kept
    expect(lab.get_by_role("switch", name="Odometry drift")).to_have_attribute("aria-checked", "true")
    lab.get_by_role("button", name="Play").click()
    at = frame(lab)["t"]
    until("the world to go on", lambda: frame(lab)["t"] > at)
    logs.bring_to_front()
    until("another session", lambda: session_of(logs) != before[1])
    until("the log to play", lambda: frame(logs)["count"] == 60)

    def is_read() -> bool:
        return bool(context.request.get(f"{replicas.address}/api/logs/{late.json()['id']}").json()["state"] == "ready")

    until("the late upload to be read", is_read)


def test_a_class_is_reached_over_the_proxy_and_its_end_is_said_when_its_service_is_killed(
    browser: Browser, context: BrowserContext, server: str, replicas: Replicas
) -> None:
    lecturer = context.new_page()
    lecturer.goto(f"{replicas.address}/lab.html")
    await_map(lecturer)
    lecturer.get_by_role("button", name="Pause").click()  # five pages that draw a robot's drive take half of the time
    lecturer.get_by_role("button", name="Class", exact=True).click()
    code = lecturer.locator(".class-code-small").text_content() or ""
    lecturer.get_by_role("dialog").get_by_role("button", name="Close").click()
    its_service = replicas.of_session(session_of(lecturer))
    lecturer.evaluate("() => { gridbloom.connection.store.pinned.value = [3.5, 2.5]; }")
    with ExitStack() as stack:
        phones = []
        for _ in range(FOLLOWERS):  # a cookie of its own each: by it alone the proxy would take either service
            phone = stack.enter_context(visiting(browser, server)).new_page()
            phone.goto(f"{replicas.address}/class/{code}")
            expect(phone).to_have_url(re.compile("/lab.html"))
            await_map(phone)
            until("the lecturer's cell", partial(shows_cell, phone))
            phones.append(phone)
        expect(lecturer.get_by_role("complementary", name="Class")).to_contain_text(f"{FOLLOWERS} here")
        replicas.kill(its_service)
        for phone in phones:
            expect(phone.get_by_role("complementary", name="Class")).to_contain_text("The class has ended.")
        # The lecturer's world goes on with the other service, and so does the lecture: a new class is opened there.
        expect(lecturer.locator(".toast")).to_contain_text("Its world was restored")
        bar = lecturer.get_by_role("complementary", name="Class")
        expect(bar).to_contain_text("has ended")
        bar.get_by_role("button", name="Close").click()
        expect(bar).to_have_count(0)
        lecturer.get_by_role("button", name="Class", exact=True).click()
        again = lecturer.locator(".class-code-small")
        expect(again).not_to_have_text(code)
        phones[0].goto(f"{replicas.address}/class/{again.text_content()}")
        await_map(phones[0])


def test_an_attempt_at_a_puzzle_ends_with_its_service_and_is_begun_again(
    context: BrowserContext, replicas: Replicas
) -> None:
    page = context.new_page()
    page.goto(f"{replicas.address}/puzzles.html")
    page.get_by_role("button", name="Open The closed doors").click()
    score = page.locator(".case-score")
    case = page.get_by_role("tabpanel", name="Case")
    for attempt in range(2):
        await_map(page)
        expect(score).to_have_text("0 of 100 points")
        case.get_by_role("radio", name="The cells are too large").check()
        case.get_by_role("button", name="This is the cause").click()
        expect(score).to_have_text("40 of 100 points")
        if attempt == 0:
            replicas.kill(replicas.of_session(session_of(page)))
            page.get_by_role("button", name="Begin again").click()


def test_who_has_signed_out_is_refused_by_the_other_service(
    browser: Browser, context: BrowserContext, server: str, guarded: Replicas
) -> None:
    entrance, worlds = f"{guarded.address}/?token={TOKEN}", f"{guarded.address}/api/worlds"
    with visiting(browser, server) as other:
        assert other.request.get(entrance).status == 200
        stays = {one["name"]: one["value"] for one in other.cookies()}
    page = context.new_page()
    page.goto(entrance)
    ends = {one["name"]: one["value"] for one in context.cookies()}
    assert [status_for(worlds, stays), status_for(worlds, ends)] == [200, 200]
    made = context.request.post(f"{guarded.address}/api/sessions", data={"kind": "simulation", "world": "office"})
    its_service = guarded.of_session(made.json()["id"])
    page.goto(f"{guarded.address}/sign-out")
    page.get_by_role("button", name="Sign out here").click()
    until("the service to refuse the cookie", lambda: status_for(worlds, ends) == 401)
    guarded.kill(its_service)
    until("the other service to refuse the cookie", lambda: status_for(worlds, ends) == 401)
    assert status_for(worlds, stays) == 200


def test_a_localization_is_finished_by_the_other_service(
    context: BrowserContext, replicas: Replicas, tmp_path: Path
) -> None:
    (tmp_path / "drive.log").write_bytes(carmen(20))
    page = context.new_page()
    page.emulate_media(reduced_motion="reduce")  # the log stands at its end
    page.goto(f"{replicas.address}/logs.html")
    page.set_input_files("input[type=file]", tmp_path / "drive.log")
    await_true(page, "() => window.gridbloom && gridbloom.connection.store.frame.peek()")
    panel = open_group(page, "Localize")
    panel.get_by_role("button", name="Use this map").click()
    panel.get_by_role("button", name="Find the robot").click()
    panel.get_by_role("progressbar", name="Localizing").wait_for()
    before = session_of(page)
    replicas.kill(replicas.of_session(before))
    # The other one begins with it when the lease ends that the killed service has, and knows the map that was chosen.
    await_true(
        page,
        """() => gridbloom.connection.store.hello.peek()?.log?.trajectories.some(({ name }) => name === "localized")""",
    )
    assert session_of(page) != before
    expect(open_group(page, "Localize").get_by_role("button", name="Find the robot again")).to_be_enabled()
