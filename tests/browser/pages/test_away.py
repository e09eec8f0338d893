"""Pages without a connection to the server: they show it, and continue when the server is back."""

from __future__ import annotations

import re
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import BrowserContext, Page, Route, expect

from tests.browser.cutting_proxy import cutting_proxy
from tests.browser.looking import await_map, end_session, frame, open_group, until
from tests.browser.scenes.test_scene_picking import View

pytestmark = pytest.mark.moving

AWAY = "The server does not answer"


def says(page: Page, place: str, words: str) -> None:
    """Bring a page to the front, as hidden ones rest, and wait for its words."""
    page.bring_to_front()
    expect(page.locator(place)).to_contain_text(words)


@pytest.mark.long
def test_pages_show_a_lost_connection_and_reconnect(context: BrowserContext, server: str) -> None:
    # Pages that are not watched for console errors: a refused connection is one, and is what the test is about.
    with cutting_proxy(urlsplit(server).port or 0) as proxy:
        home, viewer, logs = (context.new_page() for _ in range(3))
        address = f"http://127.0.0.1:{proxy.port}"
        home.emulate_media(reduced_motion="reduce")  # its world stands: it would be drawn most of the time
        home.goto(address)
        viewer.goto(f"{address}/logs.html")
        viewer.bring_to_front()
        viewer.locator(".log-card", has_text="sample").get_by_role("button", name="Open map").click()
        await_map(viewer)
        logs.goto(f"{address}/logs.html")
        logs.bring_to_front()
        card = logs.locator(".log-card", has_text="sample")
        expect(card).to_be_visible()
        for page in (home, viewer, logs):
            page.evaluate("() => { window.notReloaded = true; }")
        says(home, ".hero-facts", "readings so far")

        proxy.cut()
        says(
            home, ".hero-maps", f"{AWAY}. The page tries again by itself. The sensor model can be dragged all the same."
        )
        home.get_by_role("slider", name="Hit", exact=True).press("ArrowRight")
        expect(home.locator(".profile .label-hit", has_text="hit")).to_contain_text("+0.90 → p 0.71")
        says(viewer, ".viewer-over", AWAY)
        logs.bring_to_front()
        card.get_by_role("button", name="Open map").click()
        says(logs, ".viewer-message", "tries again by itself")

        proxy.mend()
        await_map(logs)
        viewer.bring_to_front()
        expect(viewer.locator(".viewer-over")).to_have_count(0)
        seen = frame(viewer)["index"]
        until("the log to go on", lambda: frame(viewer)["index"] > seen or not frame(viewer)["playing"])
        says(home, ".hero-facts", "readings so far")
        for page in (home, viewer, logs):
            assert page.evaluate("() => window.notReloaded") is True

        # A server that begins again knows no views: the log opens again by itself, and the page says so.
        logs.bring_to_front()
        end_session(logs)
        says(logs, ".toast", "The log was opened again")
        until("another session", lambda: frame(logs)["index"] < frame(logs)["count"])


def test_a_3d_view_has_its_camera_again_after_a_lost_connection(context: BrowserContext, server: str) -> None:
    with cutting_proxy(urlsplit(server).port or 0) as proxy:
        page = context.new_page()
        view = View(page)
        page.goto(f"http://127.0.0.1:{proxy.port}/lab.html")
        await_map(page)
        page.get_by_role("button", name="Pause").click()
        panel = open_group(page, "3D view")

        def camera_is_west() -> bool:
            page.evaluate("() => true")  # what the page sent is told here only while Playwright is called
            return bool(view.cameras) and view.cameras[-1].turn[0, 2] > 0.9

        panel.get_by_role("combobox", name="Camera").select_option("West")
        until("the camera in the west", camera_is_west)
        proxy.cut()
        expect(page.locator(".lab-status")).to_contain_text(AWAY)
        view.cameras.clear()
        proxy.mend()
        until("the camera in the west again", camera_is_west)


def test_settings_made_without_a_connection_are_sent_to_the_restarted_server(
    context: BrowserContext, server: str
) -> None:
    with cutting_proxy(urlsplit(server).port or 0) as proxy:
        page = context.new_page()
        page.goto(f"http://127.0.0.1:{proxy.port}/lab.html")
        await_map(page)
        page.get_by_role("button", name="Pause").click()
        open_group(page, "Faults")
        expect(page.get_by_role("switch", name="Odometry drift")).to_be_visible()
        address = "() => location.href"
        until("the address to tell of the world", lambda: "#s=" in page.evaluate(address))
        session = page.evaluate(address).split("session=")[1].split("#")[0]
        proxy.cut()
        expect(page.locator(".lab-status")).to_contain_text(AWAY)
        open_group(page, "Sensor model").get_by_role("slider", name="Hit increment").press("ArrowRight")
        open_group(page, "Faults")
        page.get_by_role("switch", name="Odometry drift").click()
        page.evaluate("() => gridbloom.connection.store.setView({ x: 5, y: 5, scale: 0.02 })")
        set_here = "() => { const s = gridbloom.connection.store;"
        set_here += " return [s.mapping.values.peek().log_odds_hit, s.faults.peek().drift, s.view.peek()]; }"
        before = page.evaluate(set_here)
        assert before[1:] == [True, {"x": 5, "y": 5, "scale": 0.02}]
        assert context.request.delete(f"{server}/api/sessions/{session}").ok
        proxy.mend()
        expect(page.locator(".toast")).to_contain_text("Its world was restored")
        expect(page.locator(".lab-status")).to_have_text("live")
        confirmed = "() => { const s = gridbloom.connection.store;"
        confirmed += " return Object.keys({ ...s.mapping.pending(), ...s.robot.pending() }).length === 0; }"
        until("the server to have it", lambda: page.evaluate(confirmed) and page.evaluate(set_here) == before)
        expect(page.get_by_role("switch", name="Odometry drift")).to_have_attribute("aria-checked", "true")


def test_the_lecture_needs_no_server_once_it_is_open(context: BrowserContext, server: str) -> None:
    with cutting_proxy(urlsplit(server).port or 0) as proxy:
        page = context.new_page()
        page.goto(f"http://127.0.0.1:{proxy.port}/lecture.html")
        expect(page.locator("#grid figure")).to_be_visible()
        proxy.cut()
        section = page.locator("#rays")
        section.scroll_into_view_if_needed()
        section.get_by_role("button", name="Forward one cell").click()
        expect(section.locator("figcaption")).to_contain_text("Cell 11 of 19")


@pytest.mark.parametrize(
    ("path", "place"),
    [
        ("/", ".hero-maps"),
        ("/lab.html", ".lab-trouble"),
        ("/logs.html?log=sample-office", ".viewer-message"),
        ("/puzzles.html?puzzle=doorway", ".viewer-message"),
    ],
    ids=["front page", "lab", "log", "puzzle"],
)
def test_a_page_that_is_refused_says_why_and_goes_on_by_itself(
    context: BrowserContext, server: str, path: str, place: str
) -> None:
    page = context.new_page()  # not a watched one: a refused request is an error in the console
    refusals = [(429, "Too many requests at once."), (503, "The service has no memory left for this now.")]
    sentences = iter(refusals)

    def refuse(route: Route) -> None:
        if route.request.method != "POST" or (refusal := next(sentences, None)) is None:
            route.continue_()
            return
        status, message = refusal
        route.fulfill(status=status, json={"code": "refused", "message": message, "detail": None})

    page.route(re.compile("/sessions(\\?|$)"), refuse)
    page.goto(server + path)
    for _, message in refusals:
        says(page, place, f"{message} The page tries again by itself.")
    await_map(page)
