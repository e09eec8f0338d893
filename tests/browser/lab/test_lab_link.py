"""A link restores what its sender saw, in a session of its own, also after the sender's session has ended."""

from __future__ import annotations

import base64
import json
import re
import zlib

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from tests.browser.conftest import standing_world
from tests.browser.looking import await_map, end_session, frame, map_digest, open_group, settled_digest, told, until


@pytest.fixture
def lab(context: BrowserContext, server: str) -> Page:
    """The lab, standing still, in which a person has changed this and that."""
    # Not watched for console errors: that a session has ended is one, and is what the tests are about.
    page = context.new_page()
    page.goto(f"{server}/lab.html?session={standing_world(context, server, 'room')}")
    await_map(page)
    index = frame(page)["index"]
    page.evaluate(
        "() => { const s = gridbloom.connection.store; s.teleport([6, 6.2]);"
        " s.edit({ added: [['box', 300, 600, 340, 640]], erased: [] }); s.setParameter('window', 0.4);"
        " s.setSensor('n_beams', 180); s.setView({ x: 5, y: 5, scale: 0.012 }); s.send({ type: 'step', scans: 20 }); }"
    )
    until("some scans more", lambda: frame(page)["index"] >= index + 20)
    return page


def opened(visitor: BrowserContext, link: str) -> Page:
    """Open a link as somebody else."""
    page = visitor.new_page()
    page.goto(link)
    await_map(page)
    return page


def test_the_address_restores_an_ended_session(lab: Page, visitor: BrowserContext) -> None:
    kept = settled_digest(lab)
    pose, index = frame(lab)["pose"], frame(lab)["index"]
    look = {"x": 5.5, "y": 5, "scale": 0.011}
    lab.evaluate("(look) => { gridbloom.connection.store.setView(look); }", look)
    until("the address to follow", lambda: told(lab).get("view") == look)
    link = lab.evaluate("() => location.href")
    session = link.split("session=")[1].split("#")[0]
    end_session(lab)
    other = opened(visitor, link)
    expect(other).not_to_have_url(re.compile(session))
    state = "() => { const s = gridbloom.connection.store; return [s.world.peek().edits, s.view.peek(),"
    state += " s.mapping.values.peek().window, s.sensor.values.peek().n_beams]; }"
    edits, view, window, beams = other.evaluate(state)
    assert edits == {"added": [["box", 300, 600, 340, 640]], "erased": []}
    assert view == look
    assert (window, beams) == (0.4, 180)
    assert frame(other)["index"] == index
    assert frame(other)["pose"] == pytest.approx(pose, abs=0.02)  # what comes after a whole step is not told
    assert not frame(other)["playing"]
    assert settled_digest(other) == kept


def test_a_link_shows_the_cell_that_is_explained_and_the_map_made_right(lab: Page, visitor: BrowserContext) -> None:
    open_group(lab, "Faults")
    lab.get_by_role("switch", name="Laser mounted at an angle").click()
    lab.get_by_role("switch", name="Show the correct map").click()
    lab.evaluate(
        "() => { const s = gridbloom.connection.store; const [x, y] = s.frame.peek().pose;"
        " s.pinned.value = [x + 0.5, y]; s.explain([x + 0.5, y]); }"
    )
    lab.get_by_role("button", name="Previous beam").click()
    seen = "() => { const s = gridbloom.connection.store; return s.compared.peek() && s.why.peek()"
    seen += " && s.selectedContribution.peek()"
    # Epochs count all grids of the service.
    seen += " && [s.compared.peek().values, s.pinned.peek(), {...s.why.peek(), epoch: 0},"
    seen += " s.selectedContribution.peek()]; }"
    settled_digest(lab)
    shown = until("the second map and the answer", lambda: lab.evaluate(seen))

    def tells() -> bool:
        link = told(lab)
        return bool(link.get("right")) and (link.get("why") or {}).get("touch") == shown[3]["n"]

    until("the address to follow", tells)
    other = opened(visitor, lab.evaluate("() => location.href").replace("session=", "gone="))
    expect(other.locator(".plate .compare-name").first).to_have_text("A correct")
    assert until("the same", lambda: other.evaluate(seen)) == shown


def test_share_copies_a_link_to_a_world_of_its_own(lab: Page, visitor: BrowserContext, server: str) -> None:
    lab.context.grant_permissions(["clipboard-read", "clipboard-write"], origin=server)
    open_group(lab, "Share").get_by_role("button", name="Share").click()
    expect(lab.locator(".toast").first).to_contain_text("Link copied")
    link = lab.evaluate("() => navigator.clipboard.readText()")
    assert "session=" not in link
    other = opened(visitor, link)
    assert settled_digest(other) == settled_digest(lab)
    # Two worlds: what happens in one does not happen in the other.
    before = map_digest(lab)
    other.get_by_role("button", name="Forward one scan").click()
    until("a scan more", lambda: map_digest(other) != before)
    assert settled_digest(lab) == before


def test_a_truncated_link_opens_a_new_world_with_a_notice(page: Page, server: str) -> None:
    page.goto(f"{server}/lab.html#s=notalink")
    await_map(page)
    expect(page.locator(".toast").first).to_contain_text("incomplete or damaged")


def test_a_long_replay_shows_how_far_it_is_and_can_be_cancelled(visitor: BrowserContext, server: str) -> None:
    journal = [
        [100 + 6 * i, {"type": "edit", "added": [["box", 300 + i, 300, 340 + i, 340]], "erased": []}]
        for i in range(900)
    ]
    story = {"world": "office", "seed": 1, "journal": journal, "steps": 100 + 6 * len(journal)}
    deflate = zlib.compressobj(wbits=-15)
    packed = deflate.compress(json.dumps({"story": story}).encode()) + deflate.flush()
    page = visitor.new_page()
    page.goto(f"{server}/lab.html#s={base64.urlsafe_b64encode(packed).decode().rstrip('=')}")
    expect(page.locator(".working")).to_contain_text("Replaying the link")
    page.get_by_role("button", name="Cancel").click()
    await_map(page)
    expect(page.get_by_text("The replay of the link was cancelled.")).to_be_visible()
    expect(page.locator(".working")).to_have_count(0)
