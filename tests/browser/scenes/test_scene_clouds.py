"""The point clouds of a log in the 3D view of its stage: from the head of the page, in a tab, and of a link."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from playwright.sync_api import BrowserContext, Page, expect

from tests.browser.logs.test_share import CAMERA, scrolled
from tests.browser.looking import await_map, await_true, open_group, until
from tests.browser.visits import WatchedPage
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recording.test_clouds import recording_of_room

DRAWN = "() => window.gridbloom?.clouds?.store.part('volume').message.peek()?.chunks > 0"


def recording() -> bytes:
    """Return a recording of a lidar and, beside it, of clouds of a room."""
    clouds = recording_of_room(n=4)
    first = min(one.stamp_ns for one in clouds)
    lidar = [recorded.scan(first + n * 15_000_000, [1.0, 2.0, 3.0], frame="velodyne") for n in range(20)]
    return recorded.mcap_bytes([*lidar, *clouds])


def test_the_clouds_of_a_log_are_on_its_stage_and_in_its_links(
    page: Page, visitor: BrowserContext, server: str, tmp_path: Path
) -> None:
    (tmp_path / "room.mcap").write_bytes(recording())
    page.goto(f"{server}/logs.html")
    page.set_input_files("input[type=file]", tmp_path / "room.mcap")
    await_map(page)
    link = page.get_by_role("link", name="Open in 3D")
    with page.context.expect_page() as beside:
        link.click(modifiers=["Control"])
    expect(beside.value.get_by_role("heading", level=1)).to_have_text("room.mcap")
    beside.value.close()
    expect(page.locator(".view-pane")).to_have_count(1)

    link.click()
    views = page.locator(".view-pane")
    expect(views).to_have_count(2)
    solid = page.get_by_role("region", name="3D", exact=True)
    expect(solid.get_by_role("switch", name="Point clouds")).to_have_attribute("aria-checked", "true")
    await_true(page, DRAWN)
    solid.locator("iframe").hover()
    until("the camera moves", lambda: scrolled(page))
    solid.get_by_text("Colours and clip box").click()
    solid.get_by_role("combobox", name="Colour by").select_option("time")
    await_true(page, "() => gridbloom.clouds.store.part('volume').message.peek().look.values.colour === 'time'")
    solid.get_by_role("slider", name="Cut above").press("PageDown")
    await_true(page, "() => gridbloom.clouds.store.part('volume').message.peek().look.values.cut_high < 10")

    shared = open_group(page, "Share")
    shared.get_by_role("button", name="Create link").click()
    address = shared.get_by_role("listitem").get_by_role("textbox").input_value()
    seen = page.request.get(address.replace("/shared/", "/api/shared/")).json()["shown"]["scene"]
    assert seen["clouds"]
    assert seen["chosen"] is None
    watched = WatchedPage(visitor, server)
    guest = watched.page
    guest.goto(address)
    await_true(guest, DRAWN)
    until("the guest's view has a camera", lambda: guest.evaluate(CAMERA) is not None)
    np.testing.assert_allclose(guest.evaluate(CAMERA)["position"], seen["camera"]["position"], atol=0.01)
    await_true(guest, "() => gridbloom.clouds.store.part('volume').message.peek().look.values.colour === 'time'")
    await_true(guest, "() => gridbloom.clouds.store.part('volume').message.peek().look.values.cut_high < 10")
    assert watched.problems == []
