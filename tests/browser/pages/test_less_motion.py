"""With reduced motion figures advance in steps: nothing moves by itself."""

from __future__ import annotations

import json
import re

from playwright.sync_api import Page, expect

from tests.browser.lecturing import open_lecture, set_up_every_figure
from tests.browser.looking import await_map, frame, frames, map_digest, open_group, painted, settled_digest, until


def stands(page: Page) -> None:
    """Nothing moves: neither the session nor anything that the page animates."""
    digest, at = settled_digest(page), frame(page)["stamp"]
    painted(page)
    frames(page, 30)
    assert not frame(page)["playing"]
    assert (frame(page)["stamp"], map_digest(page)) == (at, digest)
    assert page.evaluate("() => document.getAnimations().filter(one => one.playState === 'running').length") == 0


def test_live_maps_are_paused_and_advance_by_steps(page: Page, server: str) -> None:
    page.emulate_media(reduced_motion="reduce")
    page.goto(f"{server}/lab.html")
    await_map(page)
    stands(page)
    index = frame(page)["index"]
    page.get_by_role("button", name="Forward one scan").click()
    until("one scan more", lambda: frame(page)["index"] == index + 1)
    stands(page)
    # Also the moving table goes by steps: it is seen, taken away and forgotten.
    page.evaluate("() => gridbloom.connection.store.send({ type: 'world', name: 'room' })")
    page.evaluate("() => gridbloom.connection.store.send({ type: 'teleport', x: 4, y: 5, yaw: 0 })")
    until("the robot to be there", lambda: abs(frame(page)["pose"][1] - 5) < 0.1)
    open_group(page, "Moving table")
    page.get_by_role("button", name="Add a table").click()
    page.get_by_role("slider", name="My guess").press("ArrowRight")
    page.get_by_role("button", name="Remove the table").click()
    outcome = page.locator(".table-outcome")
    settled_digest(page)
    page.get_by_role("button", name="Forward 20 scans").click()
    expect(outcome).to_contain_text(re.compile(r"With the clamp: \d+"))
    stands(page)

    page.goto(server)
    facts = page.locator(".hero-facts")
    expect(facts).to_contain_text("readings so far")
    until("the front page's robot to stand", lambda: not frame(page)["playing"])
    settled_digest(page)
    before = facts.inner_text()
    frames(page, 30)
    assert facts.inner_text() == before
    page.get_by_role("button", name="Forward 10 scans").click()
    expect(facts).not_to_have_text(before)

    # The log is opened at its end: a seek would end that the session follows a job.
    sent: list[str | bytes] = []

    def keep(data: str | bytes) -> None:
        sent.append(data)

    page.on("websocket", lambda socket: socket.on("framesent", keep))
    page.goto(f"{server}/logs.html")
    with page.expect_response(lambda one: one.url == f"{server}/api/sessions") as begun:
        page.locator(".log-card", has_text="sample").get_by_role("button", name="Open map").click()
    await_map(page)
    until("the whole log", lambda: frame(page)["index"] == frame(page)["count"])
    stands(page)
    commands = [json.loads(one)["type"] for one in sent if isinstance(one, str)]
    assert "ack" in commands
    assert "seek" not in commands

    # So is a link to its start, which plays for who does not ask for less motion.
    page.evaluate("() => gridbloom.connection.store.send({ type: 'seek', index: 0 })")
    until("the start", lambda: frame(page)["index"] == 0)
    link = page.request.post(f"{server}/api/sessions/{begun.value.json()['id']}/links", data={}).json()
    page.goto(f"{server}{link['address']}")
    await_map(page)
    until("the whole log", lambda: frame(page)["index"] == frame(page)["count"] > 0)
    stands(page)


def test_figures_of_the_lecture_go_by_steps(page: Page, server: str) -> None:
    page.emulate_media(reduced_motion="reduce")
    open_lecture(page, server)
    set_up_every_figure(page)
    # Three of them run for who does not ask for less motion; each has its steps instead.
    expect(page.get_by_role("button", name="Play")).to_have_count(0)
    for section, step, told in (
        ("rays", "Forward one cell", "figcaption"),
        ("algorithm", "Step forward", ".figure-controls output"),
        ("forgetting", "Forward one scan", "figcaption"),
    ):
        if section == "algorithm":
            page.locator("#algorithm").get_by_text("beam by beam", exact=True).click()
        figure = page.locator(f"#{section} figure")
        figure.scroll_into_view_if_needed()
        if section == "forgetting":
            figure.get_by_role("button", name="Remove the table").click()
            expect(figure.get_by_role("button", name="Continue")).to_have_count(0)
        words = figure.locator(told)
        before = words.inner_text()
        frames(page, 36)
        assert words.inner_text() == before
        figure.get_by_role("button", name=step, exact=True).click()
        expect(words).not_to_have_text(before)
    assert page.evaluate("() => document.getAnimations().filter(one => one.playState === 'running').length") == 0
