"""A link opens exactly what its sender saw, in a session of its own, also when the sender's session is gone."""

from __future__ import annotations

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect

from tests.browser.looking import SECONDS, await_map, frame, map_digest, settled_digest, until


@pytest.fixture
def lab(context: BrowserContext, server: str) -> Page:
    """The lab, paused, in which a person has changed this and that."""
    # Not watched for console errors: that a session has ended is one, and is what the tests are about.
    page = context.new_page()
    page.goto(f"{server}/lab.html")
    await_map(page)
    page.locator("label", has_text="World").locator("select").select_option("room")
    until("the room", lambda: page.evaluate("() => gridbloom.connection.store.world.peek().name") == "room")
    page.evaluate(
        "() => { const s = gridbloom.connection.store; s.teleport([6, 6.2]);"
        " s.edit({ added: [['box', 300, 600, 340, 640]], erased: [] }); s.setParameter('window', 0.4);"
        " s.setSensor('n_beams', 180); s.look({ x: 5, y: 5, scale: 0.012 }); }"
    )
    until("some scans more", lambda: frame(page)["index"] > 60)
    page.get_by_role("button", name="Pause").click()
    until("the robot to stand", lambda: not frame(page)["playing"])
    return page


def end_session(page: Page) -> None:
    """End the page's session."""
    page.evaluate(
        "() => fetch(`/api/sessions/${new URLSearchParams(location.search).get('session')}`, { method: 'DELETE' })"
    )


def open_link(browser: Browser, link: str) -> Page:
    """Open a link as somebody else, and stand still at once."""
    page = browser.new_context(viewport={"width": 1440, "height": 900}).new_page()
    page.goto(link)
    await_map(page)
    return page


def test_the_address_opens_what_was_there_after_the_session_has_ended(lab: Page, browser: Browser) -> None:
    kept = settled_digest(lab)
    pose, index = frame(lab)["pose"], frame(lab)["index"]
    lab.evaluate("() => { gridbloom.connection.store.look({ x: 5.5, y: 5, scale: 0.011 }); }")
    until("the address to follow", lambda: "#s=" in lab.url and lab.evaluate("() => history.length") > 0)
    lab.wait_for_timeout(1500)
    link = lab.url
    session = link.split("session=")[1].split("#")[0]
    end_session(lab)
    other = open_link(browser, link)
    try:
        assert session not in other.url
        state = "() => { const s = gridbloom.connection.store; return [s.world.peek().edits, s.view.peek(),"
        state += " s.mapping.values.peek().window, s.sensor.values.peek().n_beams, s.hello.peek().seed]; }"
        edits, view, window, beams, _ = other.evaluate(state)
        assert edits == {"added": [["box", 300, 600, 340, 640]], "erased": []}
        assert view == {"x": 5.5, "y": 5, "scale": 0.011}
        assert (window, beams) == (0.4, 180)
        assert frame(other)["index"] == index
        assert frame(other)["pose"] == pytest.approx(pose, abs=0.02)  # what comes after a whole step is not told
        assert not frame(other)["playing"]
        assert settled_digest(other) == kept
    finally:
        end_session(other)
        other.context.close()


def test_share_copies_a_link_to_a_world_of_its_own(lab: Page, browser: Browser, server: str) -> None:
    lab.context.grant_permissions(["clipboard-read", "clipboard-write"], origin=server)
    lab.get_by_role("button", name="Share").click()
    expect(lab.locator(".toast").first).to_contain_text("The link is copied", timeout=SECONDS * 1000)
    link = lab.evaluate("() => navigator.clipboard.readText()")
    assert "session=" not in link
    other = open_link(browser, link)
    try:
        assert settled_digest(other) == settled_digest(lab)
        # Two worlds: what happens in one does not happen in the other.
        before = map_digest(lab)
        other.get_by_role("button", name="One scan on").click()
        until("a scan more", lambda: map_digest(other) != before)
        assert settled_digest(lab) == before
    finally:
        end_session(other)
        other.context.close()
        end_session(lab)


def test_a_link_that_lost_a_piece_opens_a_new_world_and_says_so(page: Page, server: str) -> None:
    page.goto(f"{server}/lab.html#s=notalink")
    await_map(page)
    expect(page.locator(".toast").first).to_contain_text("lost a piece", timeout=SECONDS * 1000)
    end_session(page)
