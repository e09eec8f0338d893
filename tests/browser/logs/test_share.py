"""A link to a view of a log: made on one page, opened by another visitor, revoked."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from tests.browser.logs.test_workspace import SCREEN, opened
from tests.browser.looking import await_true, frame, open_group, settled_digest, until
from tests.browser.pages.test_axe import violations
from tests.browser.visits import WatchedPage
from tests.server.library.small_logs import carmen, tum

#: Where a person has moved the camera of the 3D view; null before that.
CAMERA = """() => document.querySelector("iframe")?.contentWindow.sceneCamera?.() ?? null"""
SHOWN = "() => window.gridbloom && gridbloom.connection.store.frame.peek() && gridbloom.connection.store.map.peek()"


def scrolled(page: Page) -> dict[str, list[float]] | None:
    """Scroll in the view under the pointer, and return the camera: none while the view loads."""
    page.mouse.wheel(0, 400)
    camera: dict[str, list[float]] | None = page.evaluate(CAMERA)
    return camera


def test_a_link_opens_exactly_this_view_until_it_is_revoked(
    page: Page, visitor: BrowserContext, server: str, tmp_path: Path
) -> None:
    (tmp_path / "mine.log").write_bytes(carmen(60))
    page.goto(f"{server}/logs.html")
    page.set_input_files("input[type=file]", tmp_path / "mine.log")
    await_true(page, SHOWN)
    page.evaluate("() => gridbloom.connection.store.send({ type: 'pause' })")
    page.evaluate("() => gridbloom.connection.store.send({ type: 'seek', index: 25 })")
    page.evaluate("() => gridbloom.connection.store.setParameter('log_odds_hit', 1.75)")
    until("the view", lambda: frame(page)["index"] == 25 and not frame(page)["playing"])
    look = {"x": 12.0, "y": 0.5, "scale": 0.03}
    page.evaluate("(look) => gridbloom.connection.store.setView(look)", look)
    shown = settled_digest(page)

    notes = open_group(page, "Notes")
    notes.get_by_label("New note").fill("look at this wall")
    notes.get_by_role("button", name="Add note").click()
    expect(notes.locator(".note.chosen")).to_contain_text("look at this wall")
    shared = open_group(page, "Share")
    shared.get_by_role("button", name="Create link").click()
    row = shared.get_by_role("listitem")
    expect(row).to_contain_text("25 of 60 scans")
    address = row.get_by_role("textbox").input_value()
    assert address.startswith(f"{server}/shared/")
    assert violations(page, ".share") == []

    watched = WatchedPage(visitor, server)
    guest = watched.page
    guest.goto(address)
    await_true(guest, SHOWN)
    until("the same map", lambda: settled_digest(guest) == shown)
    assert (frame(guest)["index"], frame(guest)["playing"]) == (25, False)
    assert guest.evaluate("() => gridbloom.connection.store.mapping.values.value.log_odds_hit") == 1.75
    seen = guest.evaluate("() => gridbloom.connection.store.view.peek()")
    assert (seen["x"], seen["y"]) == (look["x"], look["y"])
    assert abs(seen["scale"] / look["scale"] - 1.0) < 0.2, "the head of their page is lower"
    expect(guest.get_by_role("heading", level=1)).to_have_text("mine.log")
    expect(guest.get_by_role("tabpanel", name="Notes")).to_be_visible()
    open_group(guest, "Download")
    expect(guest.get_by_role("link", name="yaml")).to_be_visible()
    absent = guest.get_by_role("tab", name="Share"), guest.get_by_role("link", name="mcap")
    for one in (*absent, guest.get_by_role("button", name="All logs")):
        expect(one).to_have_count(0)
    # It opens where its sender was: at the notes, with the text of the chosen one over the map.
    card = guest.get_by_role("complementary", name="Note")
    expect(card).to_contain_text("look at this wall")
    card.get_by_role("button", name="Close the note").click()
    expect(card).to_have_count(0)
    # It is theirs to play with.
    guest.get_by_role("button", name="Forward one scan").click()
    until("one scan more", lambda: frame(guest)["index"] == 26)
    assert frame(page)["index"] == 25
    assert watched.problems == []

    shared.get_by_role("button", name="Revoke").click()
    page.get_by_role("dialog", name="Revoke this link?").get_by_role("button", name="Revoke").click()
    expect(row).to_have_count(0)
    expect(guest.get_by_role("alert")).to_contain_text("This link was revoked")
    guest.goto(f"{server}/shared/{'x' * 32}")
    expect(guest.get_by_role("alert")).to_contain_text("or there never was one: ask for another.")


def test_a_link_opens_on_the_views_of_its_sender_and_what_they_show(
    page: Page, visitor: BrowserContext, server: str, tmp_path: Path
) -> None:
    opened(page, server, tmp_path)
    page.get_by_label("Layout", exact=True).select_option("Map")
    page.keyboard.press("4")
    views = page.locator(".view-pane")
    for n, title in enumerate(["Map", "3D", "Messages", "Plots"]):
        page.get_by_label(f"View {n + 1}").select_option(title)
    # The camera of the 3D view is moved, and its grid shown.
    views.nth(1).locator("iframe").hover()
    until("the camera moves", lambda: scrolled(page))
    if not views.nth(1).get_by_role("group", name="Layers").is_visible():
        views.nth(1).get_by_role("button", name="Controls").click()
    views.nth(1).get_by_role("button", name="Grid of").click()
    views.nth(2).get_by_label("Topic").select_option("/imu")
    field = views.nth(3).get_by_label("Add a field to the plot")
    field.fill("imu yaw")
    views.nth(3).get_by_role("button", name="/imu orientation.yaw").click()
    fields = views.nth(3).get_by_role("list", name="Fields of the plot")
    expect(fields.get_by_role("listitem")).to_have_count(2)  # it begins with the speed
    page.get_by_role("region", name="Playback").get_by_role("switch", name="UTC").click()
    lines = open_group(page, "Log lines")
    lines.get_by_label("Search in the lines").fill("slips")
    page.evaluate("() => gridbloom.connection.store.explain([0.5, 0.5])")
    page.get_by_role("toolbar", name="Map tools").get_by_role("button", name="Measure a distance").click()
    for point in ([1.0, 1.0], [2.0, 1.0]):
        page.mouse.click(*page.evaluate(SCREEN, point))
    measured = page.get_by_role("region", name="Measured").locator(".number").first
    expect(measured).to_contain_text(" m ± ")
    shared = open_group(page, "Share")
    shared.get_by_role("button", name="Create link").click()
    address = shared.get_by_role("listitem").get_by_role("textbox").input_value()
    seen = page.request.get(address.replace("/shared/", "/api/shared/")).json()["shown"]["scene"]["camera"]
    assert seen == page.evaluate(CAMERA)

    watched = WatchedPage(visitor, server)
    guest = watched.page
    guest.goto(address)
    await_true(guest, SHOWN)
    theirs = guest.locator(".view-pane")
    expect(theirs).to_have_count(4)
    assert [one.get_attribute("aria-label") for one in theirs.all()] == ["Map", "3D", "Messages", "Plots"]
    until("the same camera", lambda: (guest.evaluate(CAMERA) or {}).get("position") == pytest.approx(seen["position"]))
    assert guest.evaluate(CAMERA)["look_at"] == pytest.approx(seen["look_at"])
    await_true(guest, "() => gridbloom.connection.store.part('scene').message.peek()?.layers.Grid === true")
    expect(theirs.nth(2).get_by_label("Topic")).to_have_value("/imu")
    theirs_plotted = theirs.nth(3).get_by_role("list", name="Fields of the plot").get_by_role("listitem")
    expect(theirs_plotted).to_have_count(2)
    expect(theirs_plotted.last).to_contain_text("/imu orientation.yaw")
    playback = guest.get_by_role("region", name="Playback")
    expect(playback.get_by_role("switch", name="UTC")).to_have_attribute("aria-checked", "true")
    expect(guest.get_by_role("region", name="Measured").locator(".number").first).to_have_text(measured.inner_text())
    assert guest.evaluate("() => gridbloom.connection.store.explainedPoint.value") == [0.5, 0.5]
    rows = open_group(guest, "Log lines").locator(".log-line")
    expect(rows).to_have_count(1)
    expect(rows).to_contain_text("Wheel slips")
    assert watched.problems == []


def test_a_link_opens_with_the_camera_that_follows_the_robot(
    page: Page, visitor: BrowserContext, server: str, tmp_path: Path
) -> None:
    (tmp_path / "ours.log").write_bytes(carmen(30))
    page.goto(f"{server}/logs.html")
    page.set_input_files("input[type=file]", tmp_path / "ours.log")
    await_true(page, SHOWN)
    page.get_by_label("Layout", exact=True).select_option(label="Map and 3D")
    solid = page.get_by_role("region", name="3D", exact=True)
    cameras = solid.get_by_role("combobox", name="Camera", exact=True)
    solid.get_by_role("button", name="Controls").wait_for()
    if not cameras.is_visible():
        solid.get_by_role("button", name="Controls").click()
    with page.expect_response(lambda answer: answer.url.endswith("/settings")):
        cameras.select_option("Follow")
    page.reload()  # the page has not seen the click any more
    solid.get_by_role("button", name="Controls").wait_for()
    shared = open_group(page, "Share")
    shared.get_by_role("button", name="Create link").click()
    address = shared.get_by_role("listitem").get_by_role("textbox").input_value()
    watched = WatchedPage(visitor, server)
    guest = watched.page
    with guest.expect_response(lambda answer: answer.url.endswith("/settings")) as answered:
        guest.goto(address)
    assert answered.value.ok
    assert (answered.value.request.post_data_json or {})["camera"] == "follow"
    assert watched.problems == []


def test_whoever_has_the_address_of_a_session_shares_it_and_sees_notes_come(
    page: Page, visitor: BrowserContext, server: str, tmp_path: Path
) -> None:
    (tmp_path / "ours.log").write_bytes(carmen(30))
    page.goto(f"{server}/logs.html")
    page.set_input_files("input[type=file]", tmp_path / "ours.log")
    await_true(page, SHOWN)  # a single log opens by itself once it is read
    session = page.evaluate("() => gridbloom.connection.store.hello.value.session")
    watched = WatchedPage(visitor, server)
    colleague = watched.page
    # As the address that ``gridbloom upload`` prints: the log is in nobody's list of this browser.
    colleague.goto(f"{server}/logs.html?session={session}")
    await_true(colleague, SHOWN)
    shared = open_group(colleague, "Share")
    shared.get_by_role("button", name="Create link").click()
    link = shared.get_by_role("listitem").get_by_role("textbox").input_value()
    expect(open_group(page, "Share").get_by_role("listitem").get_by_role("textbox")).to_have_value(link)
    (tmp_path / "theirs.tum").write_bytes(tum(30, y=1.0))
    trajectories = open_group(colleague, "Trajectories")
    trajectories.get_by_label("TUM files").set_input_files(tmp_path / "theirs.tum")
    expect(trajectories).to_contain_text("theirs was added.")
    # A note of theirs comes to a page that is open already, and a change of it too.
    notes = open_group(colleague, "Notes")
    notes.get_by_label("New note").fill("a door")
    notes.get_by_role("button", name="Add note").click()
    expect(page.locator(".timeline-mark")).to_have_attribute("aria-label", "Note: a door")
    seen = open_group(page, "Notes").get_by_role("list", name="Notes")
    expect(seen).to_contain_text("a door")
    expect(seen.get_by_role("button", name="Edit")).to_have_count(0)
    notes.get_by_role("button", name="Delete this note").click()
    expect(page.locator(".timeline-mark")).to_have_count(0)
    assert watched.problems == []
