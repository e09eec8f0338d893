"""Every page at every size: it is shown, logs no error, requests no other host, and does not scroll sideways."""

from __future__ import annotations

import re
from itertools import product

import pytest
from playwright.sync_api import Page, Route, WebSocket, expect

from server.scenes.proxy import DRAWN, MOST_AHEAD
from tests.browser.looking import await_map, frame, open_group, place_on, settled_digest, until
from tests.browser.visits import SIZES

pytestmark = pytest.mark.moving

# On a phone innerWidth grows with a page that is too wide, clientWidth does not.
FITS = "() => document.documentElement.scrollWidth <= document.documentElement.clientWidth + 1"


#: A size and a colour scheme, for `context` and `scheme`.
LOOKS_IN_TURN = (("phone", "light"), ("desktop", "light"), ("phone", "dark"), ("laptop", "dark"))
PATHS = ["/", "/lecture.html", "/lab.html", "/logs.html", "/fleet.html", "/puzzles.html", "/missing.html"]


@pytest.mark.parametrize(
    ("path", "context", "scheme"),
    [
        # `make test` opens each page in one of these looks, in turn; `make test-long` in all.
        pytest.param(path, *look, marks=() if look == LOOKS_IN_TURN[n % 4] else pytest.mark.long)
        for n, path in enumerate(PATHS)
        for look in product(SIZES, ("light", "dark"))
    ],
    indirect=["context"],
)
def test_a_page_opens_without_errors(
    page: Page, server: str, path: str, scheme, request: pytest.FixtureRequest
) -> None:
    if path == "/fleet.html":
        request.getfixturevalue("mapped_logs")
    page.emulate_media(color_scheme=scheme)
    page.goto(server + path)
    what = {
        "/": "canvas",
        "/lecture.html": ".lesson-figure",
        "/lab.html": ".picture canvas",
        "/logs.html": ".log-card",
        "/fleet.html": ".fleet-card.done img",
        "/puzzles.html": ".puzzles .card",
        "/missing.html": "h1",
    }[path]
    expect(page.locator(what).first).to_be_visible()
    if path == "/lab.html":
        await_map(page)
    page.evaluate("() => document.fonts.ready.then(() => undefined)")
    page.wait_for_function(FITS)
    if page.viewport_size and page.viewport_size["width"] < 500:
        page.set_viewport_size({"width": 320, "height": 640})  # the narrowest that WCAG 1.4.10 names
        page.wait_for_function(FITS)  # the canvases take the new width in the next frame
    ground = page.evaluate("() => getComputedStyle(document.documentElement).colorScheme")
    assert scheme in ground or "light dark" in ground


#: Of each picture: its upper edge, width and height, pixels.
PICTURES = """() => [...document.querySelectorAll(".plate-picture")].map((picture) => {
  const { top, width, height } = picture.getBoundingClientRect();
  return [top, width, height].map(Math.round);
})"""


@pytest.mark.parametrize("context", ["phone"], indirect=True)
def test_a_tap_teleports_on_a_phone(page: Page, server: str) -> None:
    page.goto(f"{server}/lab.html")
    await_map(page)
    world = page.locator(".picture").first
    world.scroll_into_view_if_needed()
    x = frame(page)["pose"][0]
    bounds = page.evaluate("() => gridbloom.connection.store.world.peek().bounds")
    target = [bounds[2] - 2.5 if x < (bounds[0] + bounds[2]) / 2 else bounds[0] + 2.5, bounds[1] + 2.5]
    page.touchscreen.tap(*place_on(world, target))
    until("the robot to be there", lambda: abs(frame(page)["pose"][0] - x) > 3.0)
    # Both pictures share one scale: they are equally large, below each other and, on a tablet, beside each other.
    world_size, map_size = page.evaluate(PICTURES)
    assert world_size[1:] == map_size[1:]
    page.set_viewport_size({"width": 768, "height": 1024})
    until("both pictures on one line", lambda: len({tuple(one) for one in page.evaluate(PICTURES)}) == 1)


def test_the_front_page_leads_to_the_lab_and_to_the_logs(page: Page, server: str) -> None:
    page.goto(server)
    page.get_by_role("link", name="Open the lab").click()
    await_map(page)
    page.get_by_role("navigation", name="Pages").get_by_role("link", name="Logs").click()
    expect(page.get_by_role("heading", name="Robot logs")).to_be_visible()


COLOURS = """canvas => {
  const ctx = Object.assign(document.createElement("canvas"), { width: canvas.width, height: canvas.height })
    .getContext("2d");
  ctx.drawImage(canvas, 0, 0);
  const pixels = new Uint32Array(ctx.getImageData(0, 0, canvas.width, canvas.height).data.buffer);
  return new Set([...pixels].map((pixel) => pixel & 0xffffff)).size;
}"""


@pytest.mark.parametrize("context", ["desktop", "phone"], indirect=True)
def test_the_script_of_the_front_page_moves_nothing_that_its_html_shows(page: Page, server: str) -> None:
    held: list[Route] = []
    page.route("**/assets/index-*.js", lambda route: held.append(route))  # noqa: PLW0108 - Playwright marks the function
    page.goto(server, wait_until="commit")
    shown = page.locator(
        "header nav a, h1, .hero p b, .hero .actions a, .plate-picture, .plate-picture img, .map-legend li"
    )
    expect(shown).to_have_count(4 + 1 + 4 + 2 + 2 + 2 + 4)
    page.wait_for_function("() => [...document.querySelectorAll('link[rel=stylesheet]')].every(link => link.sheet)")
    page.evaluate("() => document.fonts.ready.then(() => undefined)")
    before = [(one.text_content(), one.bounding_box()) for one in shown.all()]
    until("the script to be asked for", lambda: held)
    held[0].continue_()
    expect(page.get_by_role("button", name="Class", exact=True)).to_be_visible()
    after = [(one.text_content(), one.bounding_box()) for one in shown.all()]
    assert [text for text, _ in after] == [text for text, _ in before]
    for (text, box), (_, earlier) in zip(after, before, strict=True):
        assert box == pytest.approx(earlier, abs=1), text


@pytest.mark.parametrize("name", ["", "lab.html"])
def test_a_new_world_is_shown_before_its_session_says_anything(page: Page, server: str, name: str) -> None:
    page.route_web_socket(re.compile("/stream"), lambda _: None)  # it opens, and nothing arrives
    page.goto(f"{server}/{name}")
    pictures = page.get_by_role("application")
    expect(pictures).to_have_count(2)
    for picture in pictures.all():
        canvas = picture.locator("canvas")
        expect(canvas).to_be_visible()
        until("the world, its robot and beams", lambda canvas=canvas: canvas.evaluate(COLOURS) > 10)  # type: ignore[misc]


def test_pictures_are_not_black_while_a_known_session_says_nothing(page: Page, server: str) -> None:
    session = page.request.post(f"{server}/api/sessions", data={"kind": "simulation"}).json()["id"]
    page.route_web_socket(re.compile("/stream"), lambda _: None)
    page.goto(f"{server}/lab.html?session={session}")
    pictures = page.get_by_role("application")
    expect(pictures).to_have_count(2)
    for picture in pictures.all():
        expect(picture).to_be_visible()
        expect(picture.locator("canvas")).to_be_hidden()


def test_a_change_before_the_session_is_known_reaches_it(page: Page, server: str) -> None:
    held: list[Route] = []

    def hold(route: Route) -> None:
        held.append(route)

    page.route("**/api/sessions", hold)
    page.goto(server)
    page.get_by_role("slider", name="Hit", exact=True).press("ArrowRight")
    label = page.locator(".profile .label-hit", has_text="hit")
    expect(label).to_contain_text("+0.90")
    expect(page.get_by_role("status").filter(has_text="Starting the simulation")).to_be_visible()
    assert len(held) == 1
    held[0].continue_()
    await_map(page)
    settled_digest(page)
    page.unroute("**/api/sessions")
    page.reload()  # the page then knows only what the session has
    await_map(page)
    expect(label).to_contain_text("+0.90")


def test_an_ended_session_is_replaced_with_a_notice(page: Page, server: str, watched) -> None:
    page.goto(f"{server}/lab.html?session=endedlongago0123456789ab")
    await_map(page)
    expect(page.locator(".toast").first).to_contain_text("This is a new world")
    expect(page).not_to_have_url(re.compile("endedlongago"))
    # The browser itself notes the 404 by which the page learns that the session is gone.
    watched.problems[:] = [problem for problem in watched.problems if "404" not in problem]


def test_the_3d_view_says_that_it_loads(page: Page, server: str) -> None:
    held: list[Route] = []
    view = re.compile(r"/scenes/[^/]+/plain/[^/]+/(\?|$)")
    page.route(view, lambda route: held.append(route))  # noqa: PLW0108 (Playwright counts its arguments)
    page.goto(f"{server}/lab.html")
    await_map(page)
    open_group(page, "3D view")
    words = page.get_by_text("Loading the 3D view")
    expect(words).to_be_visible()
    until("the view is asked for", lambda: page.title() and held)
    expect(words).to_be_visible()
    for route in held:
        route.continue_()
    expect(words).to_have_count(0)
    expect(page.frame_locator("iframe.scene").locator("canvas").first).to_be_visible()


def test_the_3d_view_opens_in_the_dock_of_the_lab(page: Page, server: str) -> None:
    sent: list[bytes | str] = []

    def listen(socket: WebSocket) -> None:
        socket.on("framesent", lambda data: sent.extend([data]))

    page.on("websocket", listen)
    page.goto(f"{server}/lab.html")
    await_map(page)
    open_group(page, "3D view")
    scene = page.frame_locator("iframe.scene")
    expect(scene.locator("canvas").first).to_be_visible()
    # The parameters stand in viser's own panel, under the same labels.
    expect(scene.get_by_text("Hit window").first).to_be_attached()
    # It reports what it has drawn, so that a slow one is not sent more.
    until("the view reports drawn messages", lambda: page.title() and sent.count(DRAWN) > MOST_AHEAD)
